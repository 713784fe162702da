//! Borders of the cells in a machine's tables, and the number of passes of the inverse.

use super::LINEAR;
use crate::compensation::key::Key;
use crate::compensation::nine::NineTerms;
use crate::compensation::table::AxisTable;
use crate::compensation::thermal::ThermalLine;
use crate::position::Position;
use crate::real::Real;

/// Error, mm, that the inverse may leave if it starts from the last cycle's correction: half of its tolerance.
pub(super) const INVERSE_MM: f64 = 0.5e-6;
/// Error, mm, that a cell may have beyond its ends: a third of the other half, for three axes.
const OVERLAP_MM: f64 = 0.5e-6 / 3.0;
/// Extent of the cell beyond a table's end, mm.
const BEYOND_MM: f64 = 2000.0;
/// Gap between a table's end and the cell beyond it, mm: the end itself belongs to the table.
const GAP_MM: f64 = 1e-6;

/// Which tables a cache of cells is bound to, and whether a cycle may read its cells directly: one number, so that a calm
/// cycle tests both by one comparison.
///
/// | number | bound to |
/// |---|---|
/// | 0 | no tables |
/// | 1 | tables without cells, to which no cache is ever bound |
/// | k | the tables of this key, read directly: their inverse takes one pass |
/// | !k | the same, not read directly: their inverse takes several, or periods add to them |
///
/// k has bit 1 set and bit 63 clear, so no two rows are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Binding(u64);

impl Binding {
    pub(super) const NONE: Self = Binding(0);
    const WITHOUT_CELLS: Self = Binding(1);

    fn direct(hash: u64) -> Self {
        Binding((hash | 2) & !(1 << 63))
    }

    /// From a direct binding, the one to the same tables if their inverse takes several passes.
    pub(super) fn by_several_passes(self) -> Self {
        Binding(!self.0)
    }
}

/// Where the cells of an axis end: immutable.
#[derive(Clone, Copy, Debug)]
pub(super) struct Borders<R, P: Position> {
    /// The table's first and last position.
    pub(super) ends: [P; 2],
    pub(super) below: [P; 2],
    pub(super) above: [P; 2],
    /// Extent of a cell beyond a point within the table, mm.
    pub(super) overlap: R,
}

impl<R: Real, P: Position> Borders<R, P> {
    fn of(table: &AxisTable<'_, R, P>) -> Self {
        let [first, last] = table.ends().map(P::to_f64);
        let gap = if table.is_empty() { 0.0 } else { GAP_MM };
        Borders {
            ends: table.ends(),
            below: [first - BEYOND_MM, first - gap].map(P::nearest),
            above: [last + gap, last + BEYOND_MM].map(P::nearest),
            overlap: R::of(table.overlap(OVERLAP_MM)),
        }
    }
}

/// Form of the errors in the cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// Linear polynomials.
    Linear,
    /// Cubic polynomials.
    Cubic,
    /// Either, with grids beside them.
    WithGrids,
}

/// Borders of the cells and bounds of the inverse: immutable, built once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tables<R, P: Position> {
    /// The direct binding to these tables.
    pub(super) direct: Binding,
    form: Form,
    cubic: bool,
    pub(super) borders: [Borders<R, P>; LINEAR],
    /// Norm of the Jacobian of the errors, without thermal growth and periods.
    norm: R,
    /// Norm of the Jacobian of the periods' errors.
    of_periods: R,
    /// Farthest that a command moves in a cycle, mm.
    motion: R,
    /// Largest change of the correction in a cycle, mm.
    change: R,
    /// Largest number of passes of the inverse.
    most: u8,
}

impl<R: Real, P: Position> Tables<R, P> {
    /// `grids`: key of the grids beside the tables. Norms of the errors' Jacobian, of tables and grids and of the periods;
    /// `most` passes of the inverse; per cycle, the largest `motion` of the command and `change` of the correction, mm.
    pub(crate) fn new<const N: usize>(
        terms: Option<&NineTerms<'_, R, P, N>>,
        grids: Option<u64>,
        [norm, of_periods]: [f64; 2],
        [motion, change]: [f64; 2],
        most: u8,
    ) -> Self {
        let mut built = Tables {
            direct: Binding::WITHOUT_CELLS,
            form: Form::Linear,
            cubic: false,
            borders: [Borders::of(&AxisTable::zero()); LINEAR],
            norm: R::of(norm),
            of_periods: R::of(of_periods),
            motion: R::of(motion),
            change: R::of(change),
            most,
        };
        let Some((terms, cubic)) = terms.and_then(|terms| Some((terms, terms.cells()?))) else { return built };
        built.cubic = cubic;
        built.form = match (grids, cubic) {
            (Some(_), _) => Form::WithGrids,
            (None, true) => Form::Cubic,
            (None, false) => Form::Linear,
        };
        for (borders, table) in built.borders.iter_mut().zip(&terms.tables) {
            *borders = Borders::of(table);
        }
        let mut key = Key(0);
        terms.numbers(&mut |number| key.add_number(number));
        key.add_all(&[norm, motion, change, f64::from(most)]);
        if of_periods != 0.0 {
            key.add_all(&[of_periods]);
        }
        key.add(grids.unwrap_or(0));
        built.direct = Binding::direct(key.0);
        built
    }

    /// Form of the errors in the cells.
    #[inline(always)]
    pub(crate) fn form(&self) -> Form {
        self.form
    }

    /// Whether their polynomials are cubic.
    #[inline(always)]
    pub(super) fn is_cubic(&self) -> bool {
        self.cubic
    }

    /// Whether periods add to the tables.
    pub(super) fn have_periods(&self) -> bool {
        self.of_periods != R::ZERO
    }

    /// Whether the tables have cells to cache.
    pub(crate) fn has_cells(&self) -> bool {
        self.direct != Binding::WITHOUT_CELLS
    }

    /// Largest number of passes of the inverse.
    pub(crate) fn most_passes(&self) -> u8 {
        self.most
    }

    /// Passes `r ← −E(q + r)` needed in a cycle that starts from the correction c of the previous cycle, and where they end
    /// if more than the position changed.
    ///
    /// With κ the norm of dE/dq, r* the fixed point, and r the result of `p` passes:
    ///
    /// ```text
    /// |r − r*| <= κᵖ |c − r*|       |c − r*| <= |c − r| + |r − r*|       |r − r*| <= κᵖ |c − r| / (1 − κᵖ)
    /// ```
    ///
    /// While locked on, the limiter sends r, and |c − r| is the change of r since the last cycle: by motion, at most
    /// κ |Δq| / (1 − κ), and at most the change that the limiter passes. While the limiter approaches, c − r is the
    /// remaining distance, and the error vanishes with it. How far periods move it, every
    /// cycle with them says. If anything but motion changes r, every pass says how far it moved
    /// the correction: [`InverseEnd`].
    pub(super) fn passes<const N: usize>(&self, thermal: &[ThermalLine<R>; N]) -> (u8, InverseEnd<R>) {
        let end = self.inverse_end(INVERSE_MM, thermal);
        let norm = end.norm;
        let rest = R::ONE - norm;
        let by_motion = norm * self.motion;
        let change = if by_motion < self.change * rest { by_motion / rest } else { self.change };
        let mut error = norm * change;
        let mut passes = 1;
        // At most 1 rounds without many_passes, else 7.
        while passes < self.most && error > R::of(INVERSE_MM) * rest {
            error = norm * error;
            passes += 1;
        }
        (passes, end)
    }

    /// Where the passes of the inverse end with a tolerance in mm.
    pub(crate) fn inverse_end<const N: usize>(&self, tolerance: f64, thermal: &[ThermalLine<R>; N]) -> InverseEnd<R> {
        let growth = thermal.iter().fold(R::ZERO, |most, line| most.max(line.slope().abs()));
        let norm = self.norm + growth;
        InverseEnd { norm, error: R::of(tolerance) * (R::ONE - norm), change: self.change }
    }
}

/// Where the passes of the inverse end in a cycle in which more than the position changed.
///
/// After a pass that moved the correction by m, the rest is at most κ m / (1 − κ): the inverse has converged where that is
/// within its tolerance. A correction farther from the one sent last than the limiter passes in a cycle is not sent, so it
/// need not be exact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InverseEnd<R> {
    /// κ, and its tolerance times 1 − κ.
    norm: R,
    error: R,
    /// Largest change of the correction in a cycle, mm.
    change: R,
}

impl<R: Real> InverseEnd<R> {
    pub(crate) const NEVER: Self = InverseEnd { norm: R::ONE, error: R::ZERO, change: R::MAX };

    /// Whether the inverse has converged after a pass that moved the correction by the root of `square`, mm.
    #[inline(always)]
    pub(crate) fn has_converged(&self, square: R) -> bool {
        self.norm * self.norm * square <= self.error * self.error
    }

    /// Whether it ends there, converged or not: the correction is that far from the one sent last.
    #[inline(always)]
    pub(crate) fn is_reached(&self, square: R) -> bool {
        self.has_converged(square) || square > self.change * self.change
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_kinds_of_binding_are_equal_whatever_the_hash() {
        for hash in [0, 1, 2, 3, 1 << 63, u64::MAX, u64::MAX - 1, !2, !(1 << 63)] {
            let direct = Binding::direct(hash);
            let all = [Binding::NONE, Binding::WITHOUT_CELLS, direct, direct.by_several_passes()];
            for (index, one) in all.iter().enumerate() {
                assert_eq!(all.iter().position(|other| other == one), Some(index), "{hash:x}");
            }
        }
    }
}
