//! The servo in a predicted part.

use crate::output::progress;
use anyhow::Result;
use clap::Args;
use trueaxis_evaluation::predict::{Options, Part, PredictDocument, predict, predict_with_servo};
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::uncertainty::Uncertainties;

#[derive(Args)]
#[command(next_help_heading = "Servo")]
pub(super) struct ServoArgs {
    /// Simulate the servo where the program cuts the features.
    #[arg(long, conflicts_with = "find")]
    servo: bool,
    /// Servo rate, Hz.
    #[arg(long, value_name = "HZ", default_value_t = 10_000.0, requires = "servo")]
    rate_hz: f64,
    /// Take the figures of the drives as exactly stated, which saves a run for each uncertain one.
    #[arg(long, requires = "servo")]
    exact_drives: bool,
}

impl ServoArgs {
    /// The prediction, with the servo if it is asked for.
    pub(super) fn predict(
        &self,
        known: (&Machine, &Uncertainties),
        program: &Program,
        part: &Part,
        options: Options,
    ) -> Result<PredictDocument> {
        if !self.servo {
            return predict(known.0, known.1, program, part, options);
        }
        let exact = self.exact_drives.then(|| known.1.clone().with_exact_drives());
        let known = (known.0, exact.as_ref().unwrap_or(known.1));
        let bar = progress(0, "simulating the servo");
        let document = predict_with_servo(known, program, part, options, self.rate_hz, &mut |done, all| {
            bar.set_length(all);
            bar.set_position(done);
        });
        bar.finish_and_clear();
        document
    }
}
