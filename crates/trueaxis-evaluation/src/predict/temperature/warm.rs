//! The growth at every place of a part's programs.

use super::{DAY_S, Growth, Lines, Start};
use crate::predict::Part;
use crate::predict::times::Times;
use anyhow::Result;
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;

/// Differences of times below which a set-up starts when the one before has ended, s: what a clock in whole seconds shows.
const SAME_S: f64 = 0.5;

/// A place of a part: its set-up, if not the first, the move, and the parameter on its curve.
pub(in crate::predict) type Place = (Option<usize>, (usize, f64));

/// The growth at every place of the programs.
pub(in crate::predict) struct Warm<'g> {
    pub(in crate::predict) growth: &'g Growth,
    /// First set-up, then the further ones; empty at a constant temperature.
    programs: Vec<Timed>,
}

/// A program in time.
struct Timed {
    /// Start after that of the first program, s.
    start_s: f64,
    times: Times,
}

impl<'g> Warm<'g> {
    /// A set-up that states no start follows the one before at once.
    ///
    /// # Errors
    /// A program that cannot be planned; a set-up that starts before the one before has ended.
    pub(in crate::predict) fn new(
        growth: &'g Growth,
        (machine, part): (&Machine, &Part),
        program: &Program,
    ) -> Result<Warm<'g>> {
        let Some(record) = &growth.record else { return Ok(Warm { growth, programs: Vec::new() }) };
        let first = Timed { start_s: 0.0, times: Times::of(machine, program, part.at_mm)? };
        let mut programs = vec![first];
        let mut before = "the first set-up";
        for (index, setup) in part.setups.iter().enumerate() {
            let ended = programs.last().map_or(0.0, Timed::end_s);
            let start_s = match setup.start {
                Some(Start::After(seconds)) => seconds - record.start_s,
                Some(Start::At(seconds)) => {
                    let today = seconds - record.first_s - record.start_s;
                    let tomorrow = today + DAY_S;
                    let is_after_midnight = today < ended - SAME_S && growth.lasts(tomorrow).is_ok();
                    if is_after_midnight { tomorrow } else { today }
                }
                None => ended,
            };
            if start_s < ended - SAME_S {
                let seconds = |after: f64| format!("{:.1} s", after + record.start_s);
                let found = format!("the set-up {} that starts {} into the record", setup.name, seconds(start_s));
                let needed = format!("{} or later, when {before} has ended", seconds(ended));
                return Err(part.wrong(setup.start_line, found, needed).into());
            }
            before = &setup.name;
            let times = Times::of(machine, part.program_of(Some(index), program), setup.at_mm)?;
            programs.push(Timed { start_s, times });
        }
        Ok(Warm { growth, programs })
    }

    /// Time since the start of the first program, s; 0 at a constant temperature.
    fn time(&self, (setup, (step, u)): Place) -> f64 {
        let timed = self.programs.get(setup.map_or(0, |setup| setup + 1));
        timed.map_or(0.0, |timed| timed.start_s + timed.times.at(step, u))
    }

    /// Growth at a place.
    pub(in crate::predict) fn at(&self, place: Place) -> Lines {
        self.growth.at(self.time(place))
    }

    /// Whether places have times: those of a record.
    pub(in crate::predict) fn is_timed(&self) -> bool {
        !self.programs.is_empty()
    }

    /// Starts of the further set-ups after that of the first program, s; none at a constant temperature.
    pub(in crate::predict) fn starts_s(&self) -> impl Iterator<Item = f64> {
        self.programs.iter().skip(1).map(|timed| timed.start_s)
    }

    /// Times of the first and last of these places.
    ///
    /// # Errors
    /// A record that ends earlier.
    pub(in crate::predict) fn span(&self, places: impl Iterator<Item = Place>) -> Result<[f64; 2]> {
        let times = places.map(|place| self.time(place));
        let [first, last] = times.fold([f64::INFINITY, 0.0_f64], |[low, high], time| [low.min(time), high.max(time)]);
        self.growth.lasts(last)?;
        Ok([first.min(last), last])
    }
}

impl Timed {
    fn end_s(&self) -> f64 {
        self.start_s + self.times.end_s()
    }
}
