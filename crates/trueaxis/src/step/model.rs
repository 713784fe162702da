//! Model stage of a cycle: the wanted correction, and the error at the actual axis positions.
//!
//! | cycle | modelled by |
//! |---|---|
//! | active, nine terms in one pass, no axis has reversed or left its cell | `model` itself, in the cached cells |
//! | homed, nine terms, no axis has reversed, few enough cells are left to be filled | `model_in_refilled_cells` |
//! | volumetric tables looked up at the command | `model_in_tangents` |
//! | any other: a reversal, new tables or growth, too many cells left, tables without cells | `model_by_lookup` |
//! | not homed, frozen or stopped | nothing |
//!
//! All but the first are out of line, behind `model_outside_cells`.

#![deny(clippy::indexing_slicing)]

use super::{ServoLoop, State};
use crate::compensation::volumetric::Cycle;
use crate::compensation::{CycleGrids, Direction, NineTerms, PASSES_MASK, Query, Reversal, Source, Volumetric};
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Sample, Verdict};
use crate::vector::V3;

/// Cells filled per cycle; the remaining ones that an axis has left are looked up without a cell.
const REFILLS: u32 = 2;
/// Cells filled per cycle with grids, at whose nodes cells end too: a lookup without cells then costs more than filling
/// them.
const REFILLS_WITH_GRIDS: u32 = 4;

/// Where the inverse of a cycle starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum InverseStart {
    /// From no correction: takes as many passes as configured.
    Zero,
    /// From the correction sent last, which is so close that one pass will do.
    SentLast,
}

/// Result of the tables in a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Modelled<R, const N: usize> {
    pub(super) wanted: [R; N],
    pub(super) tip_error: [R; N],
    /// Small rotation of the tool in bed axes, rad, in addition to the rotary axes' entries in `tip_error`.
    pub(super) tilt: V3<R>,
    pub(super) at_edge: u8,
}

impl<R: Real, const N: usize> Modelled<R, N> {
    const NOTHING: Self = Modelled { wanted: [R::ZERO; N], tip_error: [R::ZERO; N], tilt: V3::ZERO, at_edge: 0 };

    /// From the errors at the drive positions and at the feedback; rotary axes have none.
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
    /// Wanted correction at the command, modelled error at the feedback; the direction's error only if `needs_tilt`.
    ///
    /// Nine terms of three axes looked up at the command are read at the drive positions sent last, command plus
    /// correction, in the cells of the previous cycle. Nothing else is done while no axis reverses or leaves its cell.
    #[inline(always)]
    pub(super) fn model(&self, state: &mut State<R, P, N>, sample: &Sample<P, N>, needs_tilt: bool) -> Modelled<R, N> {
        if sample.verdict == Verdict::Active
            && state.cells.are_direct(&self.tables)
            && self.all_continue(state)
            && let (Some(command), Some(feedback)) = (first(&self.place(state, sample.command)), first(sample.feedback))
            && let Some((errors, at_edge)) = state.cells.errors(&self.tables, &state.grids, &command, &feedback)
        {
            return Modelled::of_errors(errors, at_edge);
        }
        self.model_outside_cells(state, sample, needs_tilt)
    }

    /// Whether no drive has reversed.
    #[inline(always)]
    fn all_continue(&self, state: &mut State<R, P, N>) -> bool {
        let drives = self.targets(&state.output, &state.dynamic, state.sequence).iter().zip(&self.within);
        state.reversal.iter_mut().zip(drives).all(|(reversal, (drive, within))| reversal.continues(*drive, *within))
    }

    /// Models any cycle but one that stays within its cells.
    #[inline(never)]
    fn model_outside_cells(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        needs_tilt: bool,
    ) -> Modelled<R, N> {
        let before = state.reversal.map(|reversal| reversal.direction());
        let directions = self.travel(state, sample);
        // While switched off but homed, the tip is still estimated: that shows the errors without correction.
        let plausible = matches!(sample.verdict, Verdict::Active | Verdict::Inactive);
        if !(sample.homed && plausible) {
            state.cells.forget();
            state.grids.forget();
            return Modelled::NOTHING;
        }
        let mut start = InverseStart::Zero;
        if let (true, Some(terms)) = (self.tables.has_cells(), self.compensation.nine_terms())
            && !self.drop_stale_cells(state, &before, &directions)
        {
            if let Some(modelled) = self.model_in_refilled_cells(state, sample, terms, &directions) {
                return modelled;
            }
            if state.cells.passes() == 1 {
                start = InverseStart::SentLast;
            }
        }
        match self.compensation.volumetric().filter(|model| model.is_at_command()) {
            Some(volumetric) => self.model_in_tangents(state, sample, &directions, volumetric, needs_tilt),
            None => self.model_by_lookup(state, sample, &directions, start, needs_tilt),
        }
    }

    /// Drops all cells if they belong to other tables, and the cells of every axis that has reversed; returns whether
    /// either was the case.
    #[inline(always)]
    fn drop_stale_cells(
        &self,
        state: &mut State<R, P, N>,
        before: &[Direction; N],
        directions: &[Direction; N],
    ) -> bool {
        let mut stale = state.cells.bind_to(&self.tables, &state.thermal);
        if let (true, Some(grids)) = (stale, self.compensation.grids()) {
            state.grids.bind_to(grids);
        }
        for (slot, (before, now)) in before.iter().zip(directions).enumerate() {
            if before != now {
                state.cells.forget_axis(slot);
                stale = true;
            }
        }
        stale
    }

    /// Only the axes have moved: fills the cells that they left. If those are too many, fills one of them and returns
    /// `None`.
    #[inline(always)]
    fn model_in_refilled_cells(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        terms: &NineTerms<'_, R, P, N>,
        directions: &[Direction; N],
    ) -> Option<Modelled<R, N>> {
        let mut at = self.place(state, sample.command);
        let grids = self.compensation.grids().map(|grids| (grids, &mut state.grids));
        let (most, near) = if grids.is_some() { (REFILLS_WITH_GRIDS, true) } else { (REFILLS, false) };
        let missing = state.cells.missing(grids, &at, sample.feedback);
        let near = near.then_some(&state.grids);
        let mut source = Source { terms, tables: &self.tables, directions, thermal: &state.thermal, near, left: most };
        if missing > most {
            source.left = 1;
            source.fill_left(&mut state.cells, &at, sample.feedback);
            return None;
        }
        for _ in 1..state.cells.passes() & PASSES_MASK {
            let error = source.at_command(&mut state.cells, &at)?;
            for ((at, command), error) in at.iter_mut().zip(sample.command).zip(error) {
                *at = command.moved(P::offset(-error));
            }
        }
        source.fill_left(&mut state.cells, &at, sample.feedback);
        let (command, feedback) = (first(&at)?, first(sample.feedback)?);
        let (errors, at_edge) = match near {
            Some(near) => state.cells.errors_with_grids(&self.tables, near, &command, &feedback)?,
            None => state.cells.errors(&self.tables, &state.grids, &command, &feedback)?,
        };
        Some(Modelled::of_errors(errors, at_edge))
    }

    /// Volumetric tables looked up at the command: reads the cached tangents.
    #[inline(always)]
    fn model_in_tangents(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        directions: &[Direction; N],
        volumetric: &Volumetric<'_, R, P, N>,
        needs_tilt: bool,
    ) -> Modelled<R, N> {
        let mut at_edge = 0;
        let (command, feedback, thermal) = (sample.command, sample.feedback, &state.thermal);
        let drive = &self.place(state, command);
        let cycle = Cycle { command, drive, feedback, directions, thermal };
        let passes = self.compensation.passes();
        let grids = self.compensation.grids().and_then(|grids| {
            // Cells of other tables lie in grid boxes, which now change.
            state.cells.forget();
            CycleGrids::new(grids, &mut state.grids, &first(drive)?, &first(feedback)?)
        });
        let (wanted, (tip, tilt)) = match &grids {
            None => volumetric.modelled(&mut state.poses, &cycle, passes, needs_tilt, &mut at_edge),
            Some(grids) => {
                volumetric.modelled_with_grids(&mut state.poses, &cycle, passes, needs_tilt, grids, &mut at_edge)
            }
        };
        let mut tip_error = [R::ZERO; N];
        for (error, tip) in tip_error.iter_mut().zip(tip.array()) {
            *error = tip;
        }
        Modelled { wanted, tip_error, tilt, at_edge }
    }

    /// Any tables, looked up without a cache.
    #[inline(always)]
    fn model_by_lookup(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        directions: &[Direction; N],
        start: InverseStart,
        needs_tilt: bool,
    ) -> Modelled<R, N> {
        let mut at_edge = 0;
        let (place, passes) = match start {
            InverseStart::Zero => (*sample.command, self.compensation.passes()),
            InverseStart::SentLast => (self.place(state, sample.command), 1),
        };
        let command = self.compensation.coordinates(&place);
        let feedback = self.compensation.coordinates(sample.feedback);
        let wanted = self.compensation.correction_in(
            &Query { command: &command, feedback: &feedback, directions, thermal: &state.thermal },
            passes,
            &mut at_edge,
        );
        let thermal = &state.thermal;
        let (mut tip_error, mut tilt) = ([R::ZERO; N], V3::ZERO);
        match self.compensation.volumetric() {
            Some(_) if needs_tilt => {
                let pose = self.compensation.pose_error(&Query::at(&feedback, directions, thermal), &mut 0);
                for (error, tip) in tip_error.iter_mut().zip(pose.tip.into()) {
                    *error = tip;
                }
                tilt = V3::from_glam(pose.orientation);
            }
            _ => tip_error = self.compensation.errors(&Query::at(&feedback, directions, thermal), &mut 0),
        }
        Modelled { wanted, tip_error, tilt, at_edge }
    }

    /// Direction of travel of every drive as last sent, command plus correction: while only one axis is commanded, the
    /// corrections of the others take up lost motion that their commands do not show. A held drive does not move.
    #[inline(always)]
    fn travel(&self, state: &mut State<R, P, N>, sample: &Sample<P, N>) -> [Direction; N] {
        let begins = sample.first || (sample.homed && !state.homed);
        state.homed = sample.homed;
        let mut directions = [Direction::POSITIVE; N];
        if begins {
            let place = if sample.verdict == Verdict::Hold && !sample.first {
                *self.targets(&state.output, &state.dynamic, state.sequence)
            } else {
                self.place(state, sample.command)
            };
            state.begin_travel(place);
            return directions;
        }
        let drives = self.targets(&state.output, &state.dynamic, state.sequence).iter().zip(&self.bands);
        for ((direction, reversal), (drive, band)) in directions.iter_mut().zip(&mut state.reversal).zip(drives) {
            *direction = reversal.update(*drive, *band);
        }
        directions
    }
}

/// Returns the first three positions.
#[inline(always)]
fn first<P: Position, const N: usize>(positions: &[P; N]) -> Option<[P; 3]> {
    match positions[..] {
        [x, y, z, ..] => Some([x, y, z]),
        _ => None,
    }
}

impl<R: Real, P: Position, const N: usize> State<R, P, N> {
    /// Before homing, positions have no meaning, and homing does not move the drives: they travel from here, forward.
    #[cold]
    fn begin_travel(&mut self, place: [P; N]) {
        self.reversal = place.map(Reversal::at);
        self.cells.forget();
    }
}
