//! The tables' share of a cycle: the wanted correction, and the error where the axes stand.

#![deny(clippy::indexing_slicing)]

use super::{ServoLoop, State};
use crate::compensation::volumetric::Cycle;
use crate::compensation::{Direction, Query, Reversal};
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Sample, Verdict};
use crate::vector::V3;

/// Result of the tables in a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Modelled<R, const N: usize> {
    pub(super) wanted: [R; N],
    pub(super) tip_error: [R; N],
    /// Small rotation of the tool in bed axes, rad, beside what the rotary axes' own entries in `tip_error` say.
    pub(super) tilt: V3<R>,
    pub(super) at_edge: u8,
}

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    /// Wanted correction at the command, modelled error at the feedback; that of the direction only for a `tool`.
    #[inline(always)]
    pub(super) fn model(&self, state: &mut State<R, P, N>, sample: &Sample<P, N>, tool: bool) -> Modelled<R, N> {
        let directions = self.travel(state, sample);
        // Switched off but homed, the tip is still estimated: that is how the errors look without correction.
        let believed = matches!(sample.verdict, Verdict::Active | Verdict::Inactive);
        if !(sample.homed && believed) {
            return Modelled { wanted: [R::ZERO; N], tip_error: [R::ZERO; N], tilt: V3::ZERO, at_edge: 0 };
        }
        let mut at_edge = 0;
        if let Some(volumetric) = self.compensation.volumetric().filter(|model| model.is_at_command()) {
            let (command, feedback, thermal) = (&sample.command, &sample.feedback, &state.thermal);
            let drive = &state.output.drive_at(command);
            let cycle = Cycle { command, drive, feedback, directions: &directions, thermal };
            let passes = self.compensation.passes();
            let (wanted, (tip, tilt)) = volumetric.modelled(&mut state.poses, &cycle, passes, tool, &mut at_edge);
            let mut tip_error = [R::ZERO; N];
            for (error, tip) in tip_error.iter_mut().zip(tip.array()) {
                *error = tip;
            }
            return Modelled { wanted, tip_error, tilt, at_edge };
        }
        let command = self.compensation.coordinates(&sample.command);
        let feedback = self.compensation.coordinates(&sample.feedback);
        let wanted = self.compensation.correction(
            &Query { command: &command, feedback: &feedback, directions: &directions, thermal: &state.thermal },
            &mut at_edge,
        );
        let (directions, thermal) = (&directions, &state.thermal);
        let (mut tip_error, mut tilt) = ([R::ZERO; N], V3::ZERO);
        match self.compensation.volumetric() {
            Some(volumetric) if tool => {
                let pose = volumetric.pose_error(&Query::at(&feedback, directions, thermal), &mut 0);
                for (error, tip) in tip_error.iter_mut().zip(pose.tip.into()) {
                    *error = tip;
                }
                tilt = V3::from_glam(pose.orientation);
            }
            _ => tip_error = self.compensation.errors(&Query::at(&feedback, directions, thermal), &mut 0),
        }
        Modelled { wanted, tip_error, tilt, at_edge }
    }

    /// Direction of travel of every drive as it was sent last, command plus correction: while one axis alone is commanded,
    /// the corrections of the others take up lost motion that their commands do not show. A held drive stands.
    #[inline(always)]
    fn travel(&self, state: &mut State<R, P, N>, sample: &Sample<P, N>) -> [Direction; N] {
        let begins = sample.first || (sample.homed && !state.homed);
        state.homed = sample.homed;
        let mut directions = [Direction::POSITIVE; N];
        if begins {
            state.begin_travel(sample);
            return directions;
        }
        let drives = state.output.drive().iter().zip(&self.bands);
        for ((direction, reversal), (drive, band)) in directions.iter_mut().zip(&mut state.reversal).zip(drives) {
            *direction = reversal.update(*drive, *band);
        }
        directions
    }
}

impl<R: Real, P: Position, const N: usize> State<R, P, N> {
    /// Before homing positions have no meaning, and homing moves none of the drives: they travel from here, forward.
    #[cold]
    fn begin_travel(&mut self, sample: &Sample<P, N>) {
        let held = sample.verdict == Verdict::Hold && !sample.first;
        let drive = if held { *self.output.drive() } else { self.output.drive_at(&sample.command) };
        self.reversal = drive.map(Reversal::at);
    }
}
