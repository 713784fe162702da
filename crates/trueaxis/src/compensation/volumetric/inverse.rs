//! The correction of the volumetric model: its exact inverse by a bounded number of passes.

#![deny(clippy::indexing_slicing)]

use super::Volumetric;
use super::carriages::Poses;
use crate::compensation::{Grids, PASSES_MASK, Query};
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;

/// Below this |determinant| of the slides' directions the correction fades instead of growing without bound.
pub(crate) const LEAST_DETERMINANT: f64 = 0.05;
/// Smallest sine of `fade_deg`: keeps the correction of the direction bounded even without a configured fade.
pub(crate) const LEAST_FADE: f64 = 1e-3;

/// Range in which the correction of the direction fades.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fade<R> {
    sine: R,
    square: R,
}

impl<R: Real> Fade<R> {
    pub(super) fn from_deg(angle: f64) -> Self {
        let sine = libm::sin(angle.to_radians()).max(LEAST_FADE);
        Fade { sine: R::of(sine), square: R::of(sine * sine) }
    }

    /// `f/s²` with s² = `square` the square of a singular measure and f its weight: 1 from the fade's sine outwards,
    /// `x² (3 − 2x)`, x = s/sine, below it. Bounded, with a continuous derivative.
    fn over(&self, square: R) -> R {
        if square >= self.square {
            R::ONE / square
        } else {
            (R::THREE - R::TWO * (square.sqrt() / self.sine)) / self.square
        }
    }
}

// Only with volumetric.
impl<R: Real, P: Position, const N: usize> Volumetric<'_, R, P, N> {
    /// Returns the correction `r` at a commanded position in table coordinates: the tip at `q + r`, errors included, is
    /// the ideal tip at `q` in workpiece coordinates. mm, rotary axes in degrees.
    ///
    /// The slides correct the tip: `Σ r_j R_j n_j = −d(q + r)`, with their directions as turned by the rotary axes; below
    /// a determinant of 0.05 the solution fades with it. With `orientation` the rotary axes correct the tool's direction
    /// t: `Σ δ_k a_k × t = −w × t`, least squares over the axes' directions a_k, weighted by 1 where their singular
    /// measure s = |t · (a_1 × a_2)| (one axis: |a × t|) is at least sin(`fade_deg`), by `x² (3 − 2x)`,
    /// x = s / sin(`fade_deg`), below; on a machine with two perpendicular rotary axes s is the sine of the angle between the
    /// tool and the axis next to the workpiece. All are scaled down together if one would exceed its magnitude limit. The
    /// slides cancel the motion of the tip that the rotary axes cause. Without `orientation` rotary axes get no
    /// correction. An absent slide is not solved for.
    ///
    /// Takes `passes` lookups from `r = 0`; sines, rotary tables and directions once, unless rotary axes are corrected.
    #[inline(always)]
    pub fn correction(&self, query: &Query<'_, R, N>, passes: u8, clamped: &mut u8) -> [R; N] {
        self.correction_with(query, None, passes, clamped)
    }

    /// [`Volumetric::correction`] with grids beside the tables.
    #[inline(never)]
    pub(crate) fn correction_with(
        &self,
        query: &Query<'_, R, N>,
        grids: Option<&Grids<'_, R>>,
        passes: u8,
        clamped: &mut u8,
    ) -> [R; N] {
        let mut twists = [[R::ZERO; 6]; N];
        let mut first = true;
        // At the command every axis is looked up; after that, only the axes that a correction moves.
        let slots = if self.orientation.is_some() { 0..N } else { 0..3 };
        self.inverse(query.command, [R::ZERO; N], passes, |at, _, poses| {
            let query = Query { command: at, ..*query };
            if !first {
                self.look_up(slots.clone(), &query, &mut twists, clamped);
            } else if self.plain {
                self.look_up_plain(&query, &mut twists, clamped);
            } else {
                self.look_up(0..N, &query, &mut twists, clamped);
            }
            first = false;
            let error = self.carried(&query, poses, &twists);
            let (mut tip, mut turn) = (V3::from_glam(error.tip), V3::from_glam(error.orientation));
            if let Some(grids) = grids {
                let sum = self.of_grids(grids, at);
                tip += sum.tip;
                turn += sum.turn;
                *clamped |= sum.edge;
            }
            (tip, turn)
        })
    }

    /// The correction after `passes` from the one in `correction`; `error` returns the errors of tip and direction at a
    /// position with a correction and in the poses there (in the first pass those at the command).
    #[inline(always)]
    pub(super) fn inverse(
        &self,
        command: &[R; N],
        mut correction: [R; N],
        passes: u8,
        mut error: impl FnMut(&[R; N], &[R; N], &Poses<R, N>) -> (V3<R>, V3<R>),
    ) -> [R; N] {
        // A machine of three slides has no rotary axis, so it does not need the code and stack for one.
        let orientation = if N > 3 { self.orientation.as_ref() } else { None };
        let slides_turn = N > 3 && self.chain.turned;
        let mut poses = self.chain.poses(command);
        let turned = slides_turn || orientation.is_some();
        let nominal = if turned { self.chain.directions(&poses) } else { ([V3::ZERO; N], V3::ZERO) };
        let mut directions = nominal.0;
        let mut at = *command;
        for ((at, q), r) in at.iter_mut().zip(command).zip(&correction) {
            *at = *q + *r;
        }
        for _ in 0..passes & PASSES_MASK {
            let (mut wrong, turn) = error(&at, &correction, &poses);
            if let Some(fade) = orientation {
                self.turn_back(fade, &nominal, turn, &mut correction);
                for ((at, q), r) in at.iter_mut().zip(command).zip(&correction).skip(3) {
                    *at = *q + *r;
                }
                poses = self.chain.poses(&at);
                directions = self.slide_directions(&poses, directions);
                wrong += self.chain.moved_tip(command, &poses, &correction);
            }
            let along = if slides_turn { self.along(&directions, wrong) } else { self.present(wrong) };
            for (((r, at), q), error) in correction.iter_mut().zip(&mut at).zip(command).zip(along) {
                *r = -error;
                *at = *q - error;
            }
        }
        correction
    }

    /// Components along the slides that exist.
    fn present(&self, error: V3<R>) -> [R; 3] {
        let mut components = error.array();
        for (component, present) in components.iter_mut().zip(self.chain.present) {
            if !present {
                *component = R::ZERO;
            }
        }
        components
    }

    fn slide_directions(&self, poses: &Poses<R, N>, before: [V3<R>; N]) -> [V3<R>; N] {
        if self.chain.turned { self.chain.directions(poses).0 } else { before }
    }

    /// Corrections of the rotary axes that turn the tool's direction back by `w × t`, degrees.
    fn turn_back(&self, fade: &Fade<R>, (directions, tool): &([V3<R>; N], V3<R>), w: V3<R>, correction: &mut [R; N]) {
        let wrong = w.cross(*tool);
        let mut columns = [V3::ZERO; N];
        for (column, direction) in columns.iter_mut().zip(directions).skip(3) {
            *column = direction.cross(*tool);
        }
        let columns = columns.get(3..).unwrap_or(&[]);
        let mut wanted = [R::ZERO; N];
        let mut square = R::ZERO;
        if let [only] = columns {
            square = only.dot(*only);
            if let Some(wanted) = wanted.get_mut(3) {
                *wanted = -only.dot(wrong);
            }
        }
        // With more than two axes the shortest solution is the mean over all pairs, weighted by the squares of their
        // determinants.
        for (i, first) in columns.iter().enumerate() {
            for (j, second) in columns.iter().enumerate().skip(i + 1) {
                let determinant = tool.dot(first.cross(*second));
                square += determinant * determinant;
                if let Some(wanted) = wanted.get_mut(3 + i) {
                    *wanted += -(determinant * tool.dot(wrong.cross(*second)));
                }
                if let Some(wanted) = wanted.get_mut(3 + j) {
                    *wanted += -(determinant * tool.dot(first.cross(wrong)));
                }
            }
        }
        // The slides must not compensate a rotation that the drives do not get: all corrections are scaled together.
        let mut scale = fade.over(square) * R::of(180.0 / core::f64::consts::PI);
        for (wanted, most) in wanted.iter().zip(&self.most).skip(3) {
            if (*wanted * scale).abs() > *most {
                scale = *most / wanted.abs();
            }
        }
        for (correction, wanted) in correction.iter_mut().zip(wanted).skip(3) {
            *correction = wanted * scale;
        }
    }

    /// Components of an error along the slides' directions; the nearest solution if slides are absent.
    fn along(&self, directions: &[V3<R>; N], error: V3<R>) -> [R; 3] {
        let [x, y, z, ..] = directions.as_slice() else { return error.array() };
        let (mut x, mut y, mut z) = (*x, *y, *z);
        match self.chain.present {
            [true, true, true] => {}
            [false, true, true] => x = unit(y.cross(z)),
            [true, false, true] => y = unit(z.cross(x)),
            [true, true, false] => z = unit(x.cross(y)),
            [x_present, y_present, z_present] => {
                let one = |direction: V3<R>, present| if present { direction.dot(error) } else { R::ZERO };
                return [one(x, x_present), one(y, y_present), one(z, z_present)];
            }
        }
        let determinant = x.dot(y.cross(z));
        let least = R::of(LEAST_DETERMINANT);
        let inverse =
            if determinant.abs() >= least { R::ONE / determinant } else { determinant * (R::ONE / (least * least)) };
        let solution = [error.dot(y.cross(z)), x.dot(error.cross(z)), x.dot(y.cross(error))];
        let mut along = [R::ZERO; 3];
        for ((along, solution), present) in along.iter_mut().zip(solution).zip(self.chain.present) {
            if present {
                *along = solution * inverse;
            }
        }
        along
    }
}

/// Normalises a direction; zero if its length is zero.
fn unit<R: Real>(v: V3<R>) -> V3<R> {
    let length = v.norm();
    if length > R::of(1e-6) { v * (R::ONE / length) } else { V3::ZERO }
}
