//! What a simulated machine does at the places of the features.

use super::super::cut::Followed;
use std::sync::Arc;
use trueaxis::machine::AXES;
use trueaxis_sim::run::{Moment, Sample};

/// Line of the program and code of the fault at which the step stopped.
pub(super) type Stopped = (u32, u8);

/// Reading minus command at places of the program, and the share of the lost motion that is taken up in negative travel.
pub(super) struct Caught {
    /// In the order of the program.
    places: Arc<[(usize, f64)]>,
    errors: Vec<Followed>,
    /// Place and error of the last cycle.
    before: Option<((usize, f64), Followed)>,
    stopped: Option<Stopped>,
}

impl Caught {
    pub(super) fn new(places: &Arc<[(usize, f64)]>) -> Caught {
        Caught { places: Arc::clone(places), errors: Vec::new(), before: None, stopped: None }
    }

    pub(super) fn finish(mut self) -> (Vec<Followed>, Option<Stopped>) {
        // The last place may be beyond the last setpoint by a rounding.
        let last = self.before.map_or([[0.0; AXES]; 2], |(_, error)| error);
        self.errors.resize(self.places.len(), last);
        (self.errors, self.stopped)
    }

    pub(super) fn cycle(&mut self, moment: &Moment, sample: &Sample) {
        if sample.fault != 0 && self.stopped.is_none() {
            self.stopped = Some((moment.line, sample.fault));
        }
        let at = (moment.move_index, moment.u);
        let off = std::array::from_fn(|axis| sample.feedback[axis] - sample.command[axis]);
        let error = [off, sample.reverse];
        while let Some(place) = self.places.get(self.errors.len()).filter(|place| **place <= at) {
            let share = |(step, u): (usize, f64)| (step == at.0 && at.1 > u).then(|| (place.1 - u) / (at.1 - u));
            let mixed = self.before.and_then(|(before, own)| Some((share(before)?, own)));
            self.errors.push(match mixed {
                Some((share, own)) => [0, 1].map(|of| {
                    let [own, error]: [[f64; AXES]; 2] = [own[of], error[of]];
                    std::array::from_fn(|axis| own[axis] + share * (error[axis] - own[axis]))
                }),
                None => error,
            });
        }
        self.before = Some((at, error));
    }
}
