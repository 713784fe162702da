//! Angles of three probes on the command line.

use clap::Args;
use trueaxis_evaluation::probes::Probes;

#[derive(Args)]
pub(crate) struct ProbeArgs {
    /// Points of a revolution N, a power of two from 64 to 4096.
    #[arg(long, value_name = "N", help_heading = "Probes")]
    n: usize,
    /// Band of harmonics in undulations per revolution, 2 or more and below N/2 [default: 2..100, or up to N/2 − 1].
    #[arg(long, value_name = "FIRST..LAST", value_parser = band, help_heading = "Probes")]
    harmonics: Option<Ends>,
    /// Slots from probe 1 to probe 2: φ2 = 360° p/N, from 1 to N − 1.
    #[arg(
        long,
        value_parser = slots,
        requires = "q",
        conflicts_with_all = ["phi2_deg", "phi3_deg"],
        allow_hyphen_values = true,
        help_heading = "Probes"
    )]
    p: Option<i64>,
    /// Slots from probe 2 to probe 3: φ3 = 360° q/N, from 1 to N − 1.
    #[arg(
        long,
        value_parser = slots,
        requires = "p",
        conflicts_with_all = ["phi2_deg", "phi3_deg"],
        allow_hyphen_values = true,
        help_heading = "Probes"
    )]
    q: Option<i64>,
    /// Angle from probe 1 to probe 2, in the sense of θ; any real number.
    #[arg(long, value_name = "DEG", requires = "phi3_deg", allow_hyphen_values = true, help_heading = "Probes")]
    phi2_deg: Option<f64>,
    /// Angle from probe 2 to probe 3.
    #[arg(long, value_name = "DEG", requires = "phi2_deg", allow_hyphen_values = true, help_heading = "Probes")]
    phi3_deg: Option<f64>,
}

/// First and last harmonic.
type Ends = [u16; 2];

fn slots(text: &str) -> Result<i64, String> {
    text.parse()
        .map_err(|_| "needed a whole number of slots; angles between slots go into --phi2-deg, --phi3-deg".into())
}

fn band(text: &str) -> Result<Ends, String> {
    let needed = "needed two whole numbers as in 2..100";
    let (first, last) = text.split_once("..").ok_or(needed)?;
    match (first.trim().parse(), last.trim().parse()) {
        (Ok(first), Ok(last)) => Ok([first, last]),
        _ => Err(needed.into()),
    }
}

impl ProbeArgs {
    /// The arguments in the form of the evaluation.
    pub(crate) fn asked(&self) -> Probes {
        let ProbeArgs { n, harmonics, p, q, phi2_deg, phi3_deg } = *self;
        Probes { n, harmonics, p, q, phi2_deg, phi3_deg, angles_deg: None }
    }
}
