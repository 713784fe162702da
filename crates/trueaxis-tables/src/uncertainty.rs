//! Standard uncertainties of a machine's figures, stated beside its tables.
//!
//! They are in `[uncertainty]`, `[uncertainty.location]`, `[[uncertainty.correlation]]`, `[axis.X.uncertainty]`,
//! `[axis.X.drive.uncertainty]` and `[axis.X.friction.uncertainty]` of `machine.toml`, and in columns like `EXX_u_um` of an
//! axis' CSV. They are never compiled, so controllers do not know them, and they change no correction.

use trueaxis::machine::Axis;

/// Instrument and set-up with which the tables were measured; standard uncertainties (k = 1). `None`: not stated.
///
/// The terms are those of ISO/TR 230-9 for linear positioning.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instrument {
    /// Calibration of the instrument by length, mm per mm; the same for all axes.
    pub device_per_length: Option<f64>,
    /// Calibration and resolution of the instrument at a single reading, mm.
    pub device: Option<f64>,
    /// Lateral misalignment of instrument and axis over the axis' travel, mm.
    pub misalignment: Option<f64>,
    /// Temperature of the machine's scales or screws during the measurement, K; the same for all axes.
    pub temperature_k: Option<f64>,
    /// Difference of that temperature from the reference, K: not an uncertainty, but the factor for `expansion_per_k`.
    pub temperature_difference_k: Option<f64>,
    /// Coefficient of expansion, 1/K; the same for all axes.
    pub expansion_per_k: Option<f64>,
    /// Environmental variation error of a single reading, mm.
    pub eve: Option<f64>,
    /// A temperature sensor of the machine, K.
    pub sensor_k: Option<f64>,
    /// Degrees of freedom of these figures; `None`: well known.
    pub degrees_of_freedom: Option<f64>,
}

/// Location errors; standard uncertainties (k = 1), mm and rad. `None`: not stated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LocationUncertainty {
    /// A0Z, B0Z, C0Y.
    pub squareness: [Option<f64>; 3],
    /// For A, B, C in this order: `EX0r … EC0r`.
    pub rotary: [[Option<f64>; 6]; 3],
    /// Degrees of freedom of these figures; `None`: well known.
    pub degrees_of_freedom: Option<f64>,
    /// Degrees of freedom of single figures, by name as `C0Y`; they take precedence over `degrees_of_freedom`.
    pub own_degrees_of_freedom: Vec<(String, f64)>,
}

impl LocationUncertainty {
    /// Degrees of freedom of a figure, `C0Y` or `EX0C`; `None`: well known.
    pub fn degrees_of(&self, name: &str) -> Option<f64> {
        own(&self.own_degrees_of_freedom, name).or(self.degrees_of_freedom)
    }
}

fn own(all: &[(String, f64)], name: &str) -> Option<f64> {
    all.iter().find(|(own, _)| own == name).map(|(_, degrees)| *degrees)
}

/// A figure of `[axis.X.drive]` or `[axis.X.friction]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Figure {
    PositionGain,
    VelocityGain,
    ResetTime,
    VelocityFeedForward,
    DeadTime,
    Coulomb,
    Presliding,
    StribeckShare,
    StribeckVelocity,
    Viscous,
}

impl Figure {
    /// All figures, those of the drive first.
    pub const ALL: [Figure; 10] = [
        Figure::PositionGain,
        Figure::VelocityGain,
        Figure::ResetTime,
        Figure::VelocityFeedForward,
        Figure::DeadTime,
        Figure::Coulomb,
        Figure::Presliding,
        Figure::StribeckShare,
        Figure::StribeckVelocity,
        Figure::Viscous,
    ];

    /// Name for readers.
    pub fn name(self) -> &'static str {
        match self {
            Figure::PositionGain => "position gain",
            Figure::VelocityGain => "velocity gain",
            Figure::ResetTime => "reset time",
            Figure::VelocityFeedForward => "velocity feed-forward",
            Figure::DeadTime => "dead time",
            Figure::Coulomb => "Coulomb friction",
            Figure::Presliding => "pre-sliding",
            Figure::StribeckShare => "Stribeck share",
            Figure::StribeckVelocity => "Stribeck velocity",
            Figure::Viscous => "viscous friction",
        }
    }

    /// Section of the axis that states the figure.
    pub fn section(self) -> &'static str {
        if Figure::ALL[..5].contains(&self) { "drive" } else { "friction" }
    }

    /// Key in that section and in its `uncertainty`.
    pub fn key(self, axis: Axis) -> &'static str {
        let rotary = axis.is_rotary();
        match self {
            Figure::PositionGain => "position_gain_per_s",
            Figure::VelocityGain => "velocity_gain_per_s",
            Figure::ResetTime => "reset_time_s",
            Figure::VelocityFeedForward => "velocity_feed_forward",
            Figure::DeadTime => "dead_time_s",
            Figure::Coulomb if rotary => "coulomb_deg_per_s",
            Figure::Coulomb => "coulomb_mm_per_s",
            Figure::Presliding if rotary => "presliding_urad",
            Figure::Presliding => "presliding_um",
            Figure::StribeckShare => "stribeck_share",
            Figure::StribeckVelocity if rotary => "stribeck_velocity_deg_per_s",
            Figure::StribeckVelocity => "stribeck_velocity_mm_per_s",
            Figure::Viscous => "viscous",
        }
    }
}

/// Uncertainties of an axis; standard uncertainties (k = 1), mm and rad. `None`: not stated.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisUncertainty {
    /// The axis.
    pub axis: Axis,
    /// Scale, mm per mm; linear axes only.
    pub scale: Option<f64>,
    /// Lost motion.
    pub backlash: Option<f64>,
    /// Scatter of a single approach.
    pub repeatability: Option<f64>,
    /// Every point of a column, independent from point to point.
    pub columns: [Option<f64>; 6],
    /// Every point separately, from the columns `…_u_…` of the axis' CSV; these take precedence over `columns`.
    pub points: [Option<Vec<f64>>; 6],
    /// Growth of the axis that remains unknown when its temperature is known.
    pub growth: Option<f64>,
    /// Resonance of the drive, Hz.
    pub resonance_hz: Option<f64>,
    /// Damping of that resonance, share of critical.
    pub resonance_damping: Option<f64>,
    /// Figures of drive and friction in the order of [`Figure::ALL`]; mm, s (degrees for a rotary axis).
    pub servo: [Option<f64>; Figure::ALL.len()],
    /// Degrees of freedom of the figures of drive and friction; `None`: well known.
    pub servo_degrees_of_freedom: [Option<f64>; 2],
    /// Degrees of freedom of these figures; `None`: well known.
    pub degrees_of_freedom: Option<f64>,
    /// Degrees of freedom of single figures, by name as `backlash` or `EXX`; they take precedence over `degrees_of_freedom`.
    pub own_degrees_of_freedom: Vec<(String, f64)>,
}

impl AxisUncertainty {
    /// Degrees of freedom of a figure, `scale`, `backlash` or `EXX`; `None`: well known.
    pub fn degrees_of(&self, name: &str) -> Option<f64> {
        own(&self.own_degrees_of_freedom, name).or(self.degrees_of_freedom)
    }

    /// An axis for which nothing is stated.
    pub fn unstated(axis: Axis) -> AxisUncertainty {
        AxisUncertainty {
            axis,
            scale: None,
            backlash: None,
            repeatability: None,
            columns: [None; 6],
            points: Default::default(),
            growth: None,
            resonance_hz: None,
            resonance_damping: None,
            servo: [None; Figure::ALL.len()],
            servo_degrees_of_freedom: [None; 2],
            degrees_of_freedom: None,
            own_degrees_of_freedom: Vec::new(),
        }
    }

    /// Uncertainty of a point of a column, from 0; `None`: not stated.
    pub fn of_point(&self, component: usize, point: usize) -> Option<f64> {
        match self.points.get(component)? {
            Some(points) => points.get(point).copied(),
            None => self.columns.get(component).copied().flatten(),
        }
    }
}

/// Correlation of two figures that were found together.
#[derive(Clone, Debug, PartialEq)]
pub struct Correlation {
    /// Full keys of their standard uncertainties, as [`Uncertainties::figures`] lists them.
    pub between: [String; 2],
    /// Coefficient of correlation, −1 to 1.
    pub coefficient: f64,
}

/// All standard uncertainties that the files of a machine state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Uncertainties {
    /// Instrument and set-up.
    pub instrument: Instrument,
    /// Squareness and location of rotary axes.
    pub location: LocationUncertainty,
    /// One entry per axis, in the order of the machine's list.
    pub axes: Vec<AxisUncertainty>,
    /// Each pair once; all others are independent.
    pub correlations: Vec<Correlation>,
    /// Numbers of the records that the machine's figures are based on.
    pub records: Vec<String>,
}

impl Uncertainties {
    /// Standard deviation of a reading of this machine, mm: its instrument, the environment and the largest scatter of an
    /// approach of a linear axis; `None` if neither environment nor scatter is stated.
    pub fn reading(&self) -> Option<f64> {
        let linear = self.axes.iter().filter(|own| !own.axis.is_rotary());
        let scatter = linear.filter_map(|own| own.repeatability).reduce(f64::max);
        if self.instrument.eve.is_none() && scatter.is_none() {
            return None;
        }
        let parts = [self.instrument.device, self.instrument.eve, scatter].map(Option::unwrap_or_default);
        Some(parts.iter().map(|part| part * part).sum::<f64>().sqrt())
    }

    /// The same with every figure of the drives and of friction stated as exact.
    #[must_use]
    pub fn with_exact_drives(mut self) -> Uncertainties {
        self.axes.iter_mut().for_each(|own| own.servo = [Some(0.0); Figure::ALL.len()]);
        self
    }

    /// Full key of every figure that is a single number and can be correlated with others, like
    /// `axis.X.uncertainty.scale_ppm`, with its standard uncertainty in SI units or mm; `None`: not stated.
    pub fn figures(&self) -> Vec<(String, Option<f64>)> {
        let unit = |axis: Axis| if axis.is_rotary() { "urad" } else { "um" };
        let has = |axis: &Axis| self.of(*axis).is_some();
        let mut all = Vec::new();
        let squareness = ["A0Z", "B0Z", "C0Y"].into_iter().zip(self.location.squareness);
        all.extend(squareness.map(|(name, u)| (format!("uncertainty.location.{name}_urad"), u)));
        for (errors, axis) in self.location.rotary.iter().zip([Axis::A, Axis::B, Axis::C]) {
            let errors = Axis::ALL.into_iter().zip(errors).filter(|_| has(&axis));
            all.extend(errors.map(|(moved, u)| {
                (format!("uncertainty.location.E{}0{}_{}", moved.letter(), axis.letter(), unit(moved)), *u)
            }));
        }
        for own in &self.axes {
            let (letter, unit) = (own.axis.letter(), unit(own.axis));
            let mut put = |key: &str, u| all.push((format!("axis.{letter}.uncertainty.{key}"), u));
            if !own.axis.is_rotary() {
                put("scale_ppm", own.scale);
            }
            put(&format!("backlash_{unit}"), own.backlash);
            put(&format!("growth_{unit}"), own.growth);
        }
        all.push(("uncertainty.device_um_per_m".into(), self.instrument.device_per_length));
        all.push(("uncertainty.temperature_k".into(), self.instrument.temperature_k));
        all
    }

    /// Uncertainties of an axis.
    pub fn of(&self, axis: Axis) -> Option<&AxisUncertainty> {
        self.axes.iter().find(|own| own.axis == axis)
    }
}
