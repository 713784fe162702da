//! Uncertainty of measurement: propagation to a point, coverage factors, intervals, and decisions on a tolerance.
//!
//! ```text
//! d = Σ_k s_k z_k           z_k of unit variance; s_k the derivative times the standard uncertainty (vectors, mm)
//! Σ = Σ_kl r_kl s_k s_lᵀ    u_x = √Σ_xx; r_kl: coefficients of correlation, 0 for independent quantities
//! U_x = t_p(ν_x) u_x        ν_x = u_x⁴ / Σ_k (c_kx²/ν_k), c_kx = s_kx Σ_l r_kl s_lx     Welch and Satterthwaite
//! ```
//!
//! Sources: JCGM 100:2008 (GUM), 5.1.2 (law of propagation), G.3 and G.4 (Student's factor, effective degrees of freedom);
//! JCGM 101:2008, clauses 5 to 7 (Monte Carlo); ISO 14253-1:2017 (decision rule).

mod budget;
mod correlation;
mod coverage;
mod decision;
mod draws;
mod factor;
mod positioning;
mod update;

pub use budget::{Contribution, Covariance};
pub use correlation::{Correlations, Impossible, Pair};
pub use coverage::{Interval, half_width, quantile};
pub use decision::{Verdict, verdict, verdict_within};
pub use draws::Draws;
pub use factor::{chi_squared_quantile, student_factor};
pub use positioning::{Band, FIGURES, Instrument, Positioning, Take, positioning};
pub use update::{Update, condensed};
