//! Model stage of a cycle: the wanted correction, and the error at the actual axis positions.
//!
//! | cycle | modelled by |
//! |---|---|
//! | active, nine terms in one pass, no axis has reversed or left its cell | `model` itself, in the cached cells |
//! | any with periods | `model_with_periods`, which adds them to one of these rows |
//! | any other with nine terms that have cells: cells left, a reversal, new tables or growth, several passes | `model_in_some_cells` |
//! | volumetric tables looked up at the command | `model_in_tangents` |
//! | tables without cells | `model_by_lookup` |
//! | not homed, frozen or stopped | nothing |
//!
//! All but the first are out of line.

#![deny(clippy::indexing_slicing)]

use super::{ServoLoop, State};
use crate::compensation::volumetric::Cycle;
use crate::compensation::{
    CycleGrids, Direction, NineTerms, PASSES_MASK, Periods, Query, Reversal, Source, Volumetric,
};
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Sample, Verdict};
use crate::vector::V3;

/// Cells filled per cycle with grids, at whose nodes cells end too: a look-up of tables and grids without cells costs more
/// than filling them, and an axis that dithers about a node leaves its cells again and again.
const FILLS_WITH_GRIDS: u32 = 2;

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
        if sample.verdict == Verdict::Active && state.cells.are_direct(&self.tables) && self.all_continue(state) {
            if let (Some(command), Some(feedback)) = (first(&self.place(state, sample.command)), first(sample.feedback))
                && let Some((errors, at_edge)) = state.cells.errors(&self.tables, &state.grids, &command, &feedback)
            {
                return Modelled::of_errors(errors, at_edge);
            }
            return self.model_outside_left_cells(state, sample);
        }
        if let Some(periods) = self.compensation.periods() {
            return self.model_with_periods(state, sample, periods, needs_tilt);
        }
        self.model_outside_cells(state, sample, needs_tilt)
    }

    /// Models any cycle of a machine with periods.
    // Only with periods.
    #[inline(never)]
    fn model_with_periods(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        periods: &Periods<'_, R>,
        needs_tilt: bool,
    ) -> Modelled<R, N> {
        let drive = self.place(state, sample.command);
        let is_calm = sample.verdict == Verdict::Active
            && state.cells.are_direct_with_periods(&self.tables)
            && self.all_continue(state);
        if is_calm && let Some((mut modelled, square)) = self.model_in_kept_cells(state, sample, periods, &drive) {
            if !state.cells.inverse_end().is_reached(square) {
                self.model_there(state, sample, periods, &mut modelled);
            }
            return modelled;
        }
        let mut modelled = self.model_beside_periods(state, sample, periods, &drive, needs_tilt);
        if sample.homed && matches!(sample.verdict, Verdict::Active | Verdict::Inactive) {
            let places = [sample.command, &drive, sample.feedback];
            let Modelled { wanted, tip_error, .. } = &mut modelled;
            let square = periods.complete(places, &state.reversal, wanted, tip_error);
            let end = state.cells.end_with_periods(&self.tables, &state.thermal);
            if state.cells.are_direct_with_periods(&self.tables) && !end.is_reached(square) {
                self.model_there(state, sample, periods, &mut modelled);
            }
        }
        modelled
    }

    /// Models a cycle again where its corrections lead, if that is within the cells: the periods have moved them so far that
    /// the tables differ there.
    // Only with periods.
    #[cold]
    #[inline(never)]
    fn model_there(
        &self,
        state: &State<R, P, N>,
        sample: &Sample<P, N>,
        periods: &Periods<'_, R>,
        modelled: &mut Modelled<R, N>,
    ) {
        let mut drive = *sample.command;
        for (drive, wanted) in drive.iter_mut().zip(&modelled.wanted) {
            *drive = drive.moved(P::offset(*wanted));
        }
        if let Some((again, _)) = self.model_in_kept_cells(state, sample, periods, &drive) {
            *modelled = again;
        }
    }

    /// The tables' part of any cycle with periods: the tables see a machine without periods with these drives. Their command
    /// is moved by the periods' correction, and the rest of the correction counts as sent.
    // Only with periods.
    #[inline(never)]
    fn model_beside_periods(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        periods: &Periods<'_, R>,
        drive: &[P; N],
        needs_tilt: bool,
    ) -> Modelled<R, N> {
        let (mut sent, mut of_tables) = ([R::ZERO; N], [R::ZERO; N]);
        for ((sent, of_tables), (drive, command)) in
            sent.iter_mut().zip(&mut of_tables).zip(drive.iter().zip(sample.command))
        {
            *sent = drive.since_near(*command);
            *of_tables = *sent;
        }
        // Of a correction that the tables leave as it is, only the periods' part changes.
        periods.complete([sample.command, drive, drive], &state.reversal, &mut of_tables, &mut [R::ZERO; N]);
        let (mut command, mut offsets) = (*sample.command, [P::offset(R::ZERO); N]);
        for (((command, offset), drive), (sent, of_tables)) in
            command.iter_mut().zip(&mut offsets).zip(drive).zip(sent.iter().zip(&of_tables))
        {
            *command = command.moved(P::offset(*of_tables - *sent));
            *offset = P::offset::<R>(drive.since_near(*command));
        }
        self.exchange_offsets(state, &mut offsets);
        let modelled = self.model_outside_cells(state, &Sample { command: &command, ..*sample }, needs_tilt);
        self.exchange_offsets(state, &mut offsets);
        modelled
    }

    /// Models a cycle with periods within its cells. Returns the square of the way to the corrections as well.
    // Only with periods.
    #[inline(always)]
    fn model_in_kept_cells(
        &self,
        state: &State<R, P, N>,
        sample: &Sample<P, N>,
        periods: &Periods<'_, R>,
        drive: &[P; N],
    ) -> Option<(Modelled<R, N>, R)> {
        let (there, back) = (drive.first_chunk()?, sample.feedback.first_chunk()?);
        let (errors, at_edge) = state.cells.errors_beside_periods(&self.tables, &state.grids, there, back)?;
        let mut modelled = Modelled::of_errors(errors, at_edge);
        let Modelled { wanted, tip_error, .. } = &mut modelled;
        let places = [sample.command, drive, sample.feedback];
        let square = periods.complete(places, &state.reversal, wanted, tip_error);
        Some((modelled, square))
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
        if let (true, Some(terms)) = (self.tables.has_cells(), self.compensation.nine_terms()) {
            let stale = self.drop_stale_cells(state, &before, &directions);
            return self.model_in_some_cells(state, sample, terms, &directions, stale);
        }
        match self.compensation.volumetric().filter(|model| model.is_at_command()) {
            Some(volumetric) => self.model_in_tangents(state, sample, &directions, volumetric, needs_tilt),
            None => self.model_by_lookup(state, sample, &directions, needs_tilt),
        }
    }

    /// Models a cycle in which an axis has left its cell and nothing else has changed.
    #[inline(never)]
    fn model_outside_left_cells(&self, state: &mut State<R, P, N>, sample: &Sample<P, N>) -> Modelled<R, N> {
        let Some(terms) = self.compensation.nine_terms() else { return Modelled::NOTHING };
        let directions = state.reversal.map(|reversal| reversal.direction());
        self.model_in_some_cells(state, sample, terms, &directions, false)
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

    /// Nine terms with cells, of which some were left or dropped: reads the others and, for a point without all of its
    /// cells, the tables. Fills one cell, with grids [`FILLS_WITH_GRIDS`], unless `stale`: then the inverse may take more passes
    /// instead.
    ///
    /// The passes start from the correction sent last.
    #[inline(always)]
    fn model_in_some_cells(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        terms: &NineTerms<'_, R, P, N>,
        directions: &[Direction; N],
        stale: bool,
    ) -> Modelled<R, N> {
        let mut at = self.place(state, sample.command);
        let grids = self.compensation.grids();
        let (boxes, fills) = match (grids, stale) {
            (_, true) => (1, 0),
            (None, false) => (0, 1),
            (Some(_), false) => (2, FILLS_WITH_GRIDS),
        };
        if let Some(grids) = grids {
            for _ in 0..boxes {
                state.cells.follow(grids, &mut state.grids, &at, sample.feedback);
            }
        }
        let grids = grids.map(|grids| (grids, &state.grids));
        let source = Source { terms, tables: &self.tables, directions, thermal: &state.thermal, grids };
        for _ in 0..fills {
            if !source.refill(&mut state.cells, &at, sample.feedback) {
                break;
            }
        }
        let (passes, end) = if stale {
            (self.tables.most_passes(), Some(state.cells.inverse_end()))
        } else {
            (state.cells.passes(), None)
        };
        let tip = source.at_feedback(&state.cells, sample.feedback);
        let (mut wrong, at_edge) = source.at_command(&state.cells, &at);
        // At most 1 rounds without many_passes, else 7: more than eight are refused when the tables are built.
        for _ in 1..passes & PASSES_MASK {
            let mut square = R::ZERO;
            for ((at, command), error) in at.iter_mut().zip(sample.command).zip(wrong) {
                let next = command.moved(P::offset(-error));
                let way: R = next.since_near(*at);
                square += way * way;
                *at = next;
            }
            if end.is_some_and(|end| end.is_reached(square)) {
                break;
            }
            wrong = source.at_command(&state.cells, &at).0;
        }
        Modelled::of_errors([wrong, tip], at_edge)
    }

    /// Volumetric tables looked up at the command: reads the cached tangents.
    // Only with volumetric.
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
        let cycle = Cycle { command, drive, feedback, directions, thermal, tables: &self.tables };
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

    /// Any tables, looked up without a cache. The passes of the inverse start from no correction.
    // Only with lookup.
    #[inline(always)]
    fn model_by_lookup(
        &self,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        directions: &[Direction; N],
        needs_tilt: bool,
    ) -> Modelled<R, N> {
        let mut at_edge = 0;
        let command = self.compensation.coordinates(sample.command);
        let feedback = self.compensation.coordinates(sample.feedback);
        let wanted = self.compensation.correction_of_tables(
            &Query { command: &command, feedback: &feedback, directions, thermal: &state.thermal },
            &mut at_edge,
        );
        let thermal = &state.thermal;
        let (mut tip_error, mut tilt) = ([R::ZERO; N], V3::ZERO);
        match self.compensation.volumetric() {
            Some(_) if needs_tilt => {
                let pose = self.compensation.pose_error_of_tables(&Query::at(&feedback, directions, thermal), &mut 0);
                for (error, tip) in tip_error.iter_mut().zip(pose.tip.into()) {
                    *error = tip;
                }
                tilt = V3::from_glam(pose.orientation);
            }
            _ => tip_error = self.compensation.errors_of_tables(&Query::at(&feedback, directions, thermal), &mut 0),
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
