//! The tables' share of a cycle: the wanted correction, and the error where the axes stand.

#![deny(clippy::indexing_slicing)]

use super::{ServoLoop, State};
use crate::compensation::{Direction, NineTerms, Query, Reversal, Source};
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Sample, Verdict};
use crate::vector::V3;

/// Cells filled in one cycle; others that have been left are looked up without.
const REFILLS: u32 = 2;

/// Result of the tables in a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Modelled<R, const N: usize> {
    pub(super) wanted: [R; N],
    pub(super) tip_error: [R; N],
    /// Small rotation of the tool in bed axes, rad, beside what the rotary axes' own entries in `tip_error` say.
    pub(super) tilt: V3<R>,
    pub(super) at_edge: u8,
}

impl<R: Real, const N: usize> Modelled<R, N> {
    const NOTHING: Self = Modelled { wanted: [R::ZERO; N], tip_error: [R::ZERO; N], tilt: V3::ZERO, at_edge: 0 };

    /// From the errors where the drives stand and at the feedback; rotary axes have none.
    #[inline(always)]
    fn of_errors([at_drives, at_feedback]: [[R; 3]; 2], at_edge: u8) -> Self {
        let mut modelled = Modelled { at_edge, ..Self::NOTHING };
        for ((wanted, tip), (drive, feedback)) in
            modelled.wanted.iter_mut().zip(&mut modelled.tip_error).zip(at_drives.into_iter().zip(at_feedback))
        {
            (*wanted, *tip) = (-drive, feedback);
        }
        modelled
    }
}

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    /// Wanted correction at the command, modelled error at the feedback; that of the direction only for a `tool`.
    ///
    /// Nine terms of three axes looked up at the command are read where the drives were sent last, command plus correction,
    /// in the cells of the cycle before: nothing else is done while no axis turns or leaves its cell.
    #[inline(always)]
    pub(super) fn model(&self, state: &mut State<R, P, N>, sample: &Sample<P, N>, tool: bool) -> Modelled<R, N> {
        if sample.verdict == Verdict::Active
            && state.cells.key() == self.tables.key()
            && self.all_go_on(state)
            && let (Some(command), Some(feedback)) = (first(&drives(state, sample)), first(&sample.feedback))
            && let Some(errors) = state.cells.errors(command, feedback, self.tables.is_cubic())
        {
            return Modelled::of_errors(errors, state.cells.at_edge());
        }
        self.model_anew(state, sample, tool)
    }

    /// No drive has turned.
    #[inline(always)]
    fn all_go_on(&self, state: &mut State<R, P, N>) -> bool {
        let drives = state.output.drive().iter().zip(&self.within);
        state
            .reversal
            .iter_mut()
            .zip(drives)
            .fold(true, |on, (reversal, (drive, within))| on & reversal.goes_on(*drive, *within))
    }

    #[inline(never)]
    fn model_anew(&self, state: &mut State<R, P, N>, sample: &Sample<P, N>, tool: bool) -> Modelled<R, N> {
        let before = state.reversal.map(|reversal| reversal.direction());
        let directions = self.travel(state, sample);
        // Switched off but homed, the tip is still estimated: that is how the errors look without correction.
        let believed = matches!(sample.verdict, Verdict::Active | Verdict::Inactive);
        if !(sample.homed && believed) {
            state.cells.forget();
            return Modelled::NOTHING;
        }
        match self.compensation.nine_terms() {
            Some(terms) if self.tables.has_cells() => self.model_in_cells(state, sample, terms, (&before, &directions)),
            _ => self.model_at_large(state, sample, &directions, tool),
        }
    }

    /// Three axes looked up at the command: cells that have been left are filled.
    #[inline(always)]
    fn model_in_cells(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        terms: &NineTerms<'_, R, P, N>,
        (before, directions): (&[Direction; N], &[Direction; N]),
    ) -> Modelled<R, N> {
        let mut changed = !state.cells.are_of(&self.tables, &state.thermal);
        for (slot, (before, now)) in before.iter().zip(directions).enumerate() {
            if before != now {
                state.cells.forget_axis(slot);
                changed = true;
            }
        }
        // Where more than the place has changed, one look-up more is made; cells are filled in the next cycle.
        let refills = if changed { 0 } else { REFILLS };
        let mut source = Source::new(terms, &self.tables, directions, &state.thermal, refills);
        let mut at = drives(state, sample);
        let (mut errors, mut at_edge) = source.at_command(&mut state.cells, &at);
        for _ in 1..state.cells.passes(changed) & 15 {
            for ((at, command), error) in at.iter_mut().zip(&sample.command).zip(errors) {
                *at = command.moved(P::offset(-error));
            }
            (errors, at_edge) = source.at_command(&mut state.cells, &at);
        }
        let tip = source.at_feedback(&mut state.cells, &sample.feedback);
        Modelled::of_errors([errors, tip], at_edge)
    }

    /// Any tables.
    #[inline(always)]
    fn model_at_large(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        directions: &[Direction; N],
        tool: bool,
    ) -> Modelled<R, N> {
        let mut at_edge = 0;
        let command = self.compensation.coordinates(&sample.command);
        let feedback = self.compensation.coordinates(&sample.feedback);
        let wanted = self.compensation.correction(
            &Query { command: &command, feedback: &feedback, directions, thermal: &state.thermal },
            &mut at_edge,
        );
        let thermal = &state.thermal;
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

/// The first three positions.
#[inline(always)]
fn first<P: Position, const N: usize>(positions: &[P; N]) -> Option<[P; 3]> {
    match positions[..] {
        [x, y, z, ..] => Some([x, y, z]),
        _ => None,
    }
}

/// Where the drives would stand with the corrections sent last.
#[inline(always)]
fn drives<R: Real, P: Position, const N: usize>(state: &State<R, P, N>, sample: &Sample<P, N>) -> [P; N] {
    let mut drives = sample.command;
    for (drive, offset) in drives.iter_mut().zip(state.output.offsets()) {
        *drive = drive.moved(*offset);
    }
    drives
}

impl<R: Real, P: Position, const N: usize> State<R, P, N> {
    /// Before homing positions have no meaning, and homing moves none of the drives: they travel from here, forward.
    #[cold]
    fn begin_travel(&mut self, sample: &Sample<P, N>) {
        let held = sample.verdict == Verdict::Hold && !sample.first;
        let drive = if held { *self.output.drive() } else { self.output.drive_at(&sample.command) };
        self.reversal = drive.map(Reversal::at);
        self.cells.forget();
    }
}
