//! Error of the pose around a position, to first order: value, derivative and the box in which that is accurate enough.
//!
//! With u = e + w × L the contribution of an axis in its carrier's directions, L the lever from its frame to the tip, ρ_i
//! the half width of the box along axis i (rad if it is rotary), λ = √Σρ² over the slides and θ = Σρ over the rotary
//! axes, the second derivative of the tip's error along any line from the centre to a border is at most
//!
//! ```text
//! Σ_k  θ² |u| + 2θ (|e'| ρ_k + |w'| ρ_k Λ + |w| l) + 2 |w'| ρ_k l + |w| (2θλ + θ²Λ)
//! l = λ + θΛ
//! ```
//!
//! where |L| <= Λ, and the tangent is off by half of that. The form is homogeneous in the ρ: a box of a fixed shape is
//! scaled to give [`TOLERANCE_MM`]. The axis' own second and third powers of a cubic table are included too; at a point
//! of a linear table the slope jumps, so a box ends there, except for an overlap in which the jump stays below
//! [`KINK_MM`]. Values and slopes are the largest in the largest box.

use super::carriages::{Carriage, Poses, about};
use super::{Volumetric, halves};
use crate::compensation::reversal::Direction;
use crate::compensation::thermal::ThermalLine;
use crate::machine::{Axis, MachineSettings, Rows, Twist};
use crate::position::Position;
use crate::real::Real;
use crate::vector::{About, V3};

/// Permitted error of the tangent at the border of its box: the greater part of the inverse's permitted error.
pub(super) const TOLERANCE_MM: f64 = 0.6e-6;
/// Permitted error in the overlap at a point of a linear table.
const KINK_MM: f64 = 0.1e-6;
/// Largest overlap.
const MOST_OVERLAP_MM: f64 = 0.02;
/// Half widths of the box before scaling, mm and degrees, and the largest factor.
const SHAPE_MM: f64 = 1.0;
const SHAPE_DEG: f64 = 0.1;
const MOST_SCALE: f64 = 4.0;

/// A rotation by one degree, rad.
pub(super) const RAD: f64 = core::f64::consts::PI / 180.0;

/// Tip and direction of the tool.
pub(crate) type Pose<R> = (V3<R>, V3<R>);

/// First-order form of the pose error in a box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tangent<R, P: Position, const N: usize> {
    pub(super) low: [P; N],
    pub(super) reach: [P::Reach; N],
    /// Error of the tip (mm) and of the direction (rad) at the low corner.
    pub(super) tip: V3<R>,
    turn: V3<R>,
    /// Derivatives of both, per step of a position.
    pub(super) tip_slopes: [V3<R>; N],
    turn_slopes: [V3<R>; N],
    /// Second and third powers, of tip and direction, if tables are cubic.
    pub(super) powers: [[V3<R>; 2]; N],
    turn_powers: [[V3<R>; 2]; N],
    pub(super) curved: bool,
    /// For three slides, products of X and Y, X and Z, Y and Z: see [`super::slides`].
    pub(super) products: [V3<R>; 3],
    /// One bit for every axis whose edge value is clamped.
    pub(super) edge: u8,
}

impl<R: Real, P: Position, const N: usize> Tangent<R, P, N> {
    /// A box that contains no position.
    pub(super) fn empty() -> Self {
        Tangent {
            low: [P::of(f64::NAN); N],
            reach: [P::Reach::default(); N],
            tip: V3::ZERO,
            turn: V3::ZERO,
            tip_slopes: [V3::ZERO; N],
            turn_slopes: [V3::ZERO; N],
            powers: [[V3::ZERO; 2]; N],
            turn_powers: [[V3::ZERO; 2]; N],
            curved: false,
            products: [V3::ZERO; 3],
            edge: 0,
        }
    }

    /// Makes the box contain no position.
    pub(super) fn clear(&mut self) {
        (self.low, self.reach) = ([P::of(f64::NAN); N], [P::Reach::default(); N]);
    }

    /// Steps from the low corner, and whether the position is in the box.
    #[inline(always)]
    pub(super) fn steps(&self, at: &[P; N]) -> ([R; N], bool) {
        let mut steps = [R::ZERO; N];
        let mut inside = true;
        for (((steps, at), low), reach) in steps.iter_mut().zip(at).zip(&self.low).zip(&self.reach) {
            let (distance, within) = at.steps_above(*low, *reach);
            *steps = distance;
            inside &= within;
        }
        (steps, inside)
    }

    /// Error of the tip at a distance in steps from the low corner.
    #[inline(always)]
    pub(super) fn tip(&self, steps: &[R; N]) -> V3<R> {
        if let (3, [x, y, z, ..], [along_x, along_y, along_z, ..]) = (N, steps.as_slice(), self.tip_slopes.as_slice()) {
            let [xy, xz, yz] = self.products;
            let (mut of_x, mut of_y, mut of_z) = (*along_x + xy * *y + xz * *z, *along_y + yz * *z, *along_z);
            if let (true, [[x2, x3], [y2, y3], [z2, z3], ..]) = (self.curved, self.powers.as_slice()) {
                of_x += (*x2 + *x3 * *x) * *x;
                of_y += (*y2 + *y3 * *y) * *y;
                of_z += (*z2 + *z3 * *z) * *z;
            }
            return self.tip + of_x * *x + of_y * *y + of_z * *z;
        }
        polynomials(self.tip, &self.tip_slopes, self.curved.then_some(&self.powers), steps)
    }

    /// Error of the direction at a distance in steps from the low corner.
    #[inline(always)]
    pub(super) fn turn(&self, steps: &[R; N]) -> V3<R> {
        polynomials(self.turn, &self.turn_slopes, self.curved.then_some(&self.turn_powers), steps)
    }
}

/// `start + Σ t (slope + t (square + t cube))`.
#[inline(always)]
fn polynomials<R: Real, const N: usize>(
    start: V3<R>,
    slopes: &[V3<R>; N],
    powers: Option<&[[V3<R>; 2]; N]>,
    steps: &[R; N],
) -> V3<R> {
    let mut sum = start;
    match powers {
        None => {
            for (t, slope) in steps.iter().zip(slopes) {
                sum += *slope * *t;
            }
        }
        Some(powers) => {
            for ((t, slope), [square, cube]) in steps.iter().zip(slopes).zip(powers) {
                sum += (*slope + (*square + *cube * *t) * *t) * *t;
            }
        }
    }
    sum
}

/// The twist of an axis around its position: polynomial, and its extent.
#[derive(Clone, Copy, Debug)]
struct Local<R> {
    powers: [Twist<R>; 4],
    below: R,
    above: R,
}

/// Directions of an axis' carrier and origin of its moved frame, in the bed.
#[derive(Clone, Copy, Debug)]
struct Frame<R> {
    turned: bool,
    directions: [V3<R>; 3],
    origin: V3<R>,
}

impl<R: Real> Frame<R> {
    fn bed() -> Self {
        Frame { turned: false, directions: [About::X, About::Y, About::Z].map(along), origin: V3::ZERO }
    }

    /// Converts a vector from the carrier to the bed.
    #[inline(always)]
    fn out(&self, v: V3<R>) -> V3<R> {
        if !self.turned {
            return v;
        }
        let [x, y, z] = self.directions;
        x * v.x + y * v.y + z * v.z
    }

    fn direction(&self, about: About) -> V3<R> {
        let [x, y, z] = self.directions;
        match about {
            About::X => x,
            About::Y => y,
            About::Z => z,
        }
    }

    /// The frame of the axes that a rotary axis carries.
    fn rotated(&self, about: About, (c, s): (R, R)) -> Self {
        let [x, y, z] = self.directions;
        let directions = match about {
            About::X => [x, y * c + z * s, z * c - y * s],
            About::Y => [x * c - z * s, y, z * c + x * s],
            About::Z => [x * c + y * s, y * c - x * s, z],
        };
        Frame { turned: true, directions, ..*self }
    }
}

/// Share of an axis in the errors of tip and direction, and the axis' own changes of it.
#[derive(Clone, Copy, Debug)]
struct Share<R> {
    tip: [V3<R>; 4],
    turn: [V3<R>; 4],
}

fn along<R: Real>(about: About) -> V3<R> {
    match about {
        About::X => V3::new(R::ONE, R::ZERO, R::ZERO),
        About::Y => V3::new(R::ZERO, R::ONE, R::ZERO),
        About::Z => V3::new(R::ZERO, R::ZERO, R::ONE),
    }
}

/// Overlap of two neighbouring intervals of an axis: the jumps of all slopes together stay below [`KINK_MM`] in it.
pub(super) fn overlap<R: Real>(kinks: Twist<R>, longest: f64) -> R {
    let (e, w) = halves(kinks);
    let kink = e.norm() + w.norm() * R::of(longest);
    let most = R::of(MOST_OVERLAP_MM);
    if kink * most > R::of(KINK_MM) { R::of(KINK_MM) / kink } else { most }
}

/// Upper bound of every lever of a machine within its travel and its tables, mm.
pub(super) fn longest<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: impl Fn(Axis) -> Option<&'r T>,
) -> f64 {
    let length = |v: [f64; 3]| libm::sqrt(v.iter().map(|x| x * x).sum());
    let mut travels = [0.0; 3];
    let mut offsets = length(machine.tool_mm);
    for settings in &machine.axes {
        offsets += length(settings.offset_mm);
        let Some(travel) = travels.get_mut(settings.axis.index()) else { continue };
        let [low, high] = settings.travel;
        let ends = rows(settings.axis).and_then(|rows| Some([rows.row(0)?, rows.row(rows.len().wrapping_sub(1))?]));
        let table = ends.map_or(0.0, |[first, last]| first.position.abs().max(last.position.abs()));
        *travel = low.abs().max(high.abs()).max(table) + MOST_SCALE * SHAPE_MM;
    }
    offsets + length(travels)
}

// Only with volumetric.
impl<R: Real, P: Position, const N: usize> Volumetric<'_, R, P, N> {
    /// Twist of the axis at `slot`, including everything added to its table.
    fn local(&self, slot: usize, at: R, direction: Direction, line: &ThermalLine<R>) -> Option<(Local<R>, bool)> {
        let interval = self.tables.get(slot)?.interval(at, direction);
        let ([mut twist, mut slope], bent) = interval.powers(interval.t);
        let [second, third] = bent.unwrap_or([[R::ZERO; 6]; 2]);
        let (own, constant) = (*self.own.get(slot)?, self.constant.get(slot)?);
        let (mut growth, mut rate) = (line.at(at - *self.datum.get(slot)?), line.slope());
        if own >= 3 {
            (growth, rate) = (growth * R::of(RAD), rate * R::of(RAD));
            for (twist, constant) in twist.iter_mut().zip(constant) {
                *twist += *constant;
            }
        }
        *twist.get_mut(own)? += growth;
        *slope.get_mut(own)? += rate;
        let q = at + *self.origins.get(slot)?;
        let [tilt_x, tilt_y] = self.squareness.slopes(slot);
        let ([x, y, ..], [along_x, along_y, ..]) = (&mut twist, &mut slope);
        *x += tilt_x * q;
        *y += tilt_y * q;
        *along_x += tilt_x;
        *along_y += tilt_y;
        let [below, above] = interval.rooms(*self.overlaps.get(slot)?);
        Some((Local { powers: [twist, slope, second, third], below, above }, interval.edge))
    }

    /// Computes `tangent` around a position.
    #[inline(never)]
    pub(super) fn tangent(
        &self,
        tangent: &mut Tangent<R, P, N>,
        position: &[P; N],
        directions: &[Direction; N],
        thermal: &[ThermalLine<R>; N],
    ) {
        let at = self.coordinates(position);
        let still = Local { powers: [[R::ZERO; 6]; 4], below: R::MAX, above: R::MAX };
        let mut locals = [still; N];
        let mut edge = 0;
        for (slot, (((local, at), direction), line)) in
            locals.iter_mut().zip(&at).zip(directions).zip(thermal).enumerate()
        {
            if let Some((found, at_edge)) = self.local(slot, *at, *direction, line) {
                *local = found;
                edge |= u8::from(at_edge) << (slot & 7);
            }
        }
        self.derivatives(&at, &locals, tangent);
        (tangent.edge, tangent.curved) = (edge, self.curved);
        let scale = self.scale(&locals);
        for (slot, (position, local)) in position.iter().zip(&locals).enumerate() {
            let half = self.shape(slot) * scale;
            let low = position.moved_back(P::offset(local.below.min(half)));
            let high = position.moved(P::offset(local.above.min(half)));
            let from: R = position.since_near(low);
            if let (Some(corner), Some(reach), Some(along), Some(turning), Some(powers), Some(turn_powers)) = (
                tangent.low.get_mut(slot),
                tangent.reach.get_mut(slot),
                tangent.tip_slopes.get_mut(slot),
                tangent.turn_slopes.get_mut(slot),
                tangent.powers.get_mut(slot),
                tangent.turn_powers.get_mut(slot),
            ) {
                (*corner, *reach) = (low, high.apart(low));
                let curved = self.curved;
                begin_at_corner(&mut tangent.tip, along, powers, from, R::of(P::STEP), curved);
                begin_at_corner(&mut tangent.turn, turning, turn_powers, from, R::of(P::STEP), curved);
            }
        }
    }

    /// Half width of the box before scaling.
    fn shape(&self, slot: usize) -> R {
        R::of(if self.own.get(slot).is_some_and(|own| *own >= 3) { SHAPE_DEG } else { SHAPE_MM })
    }

    /// Scale factor of the box's shape: see the module's documentation.
    fn scale(&self, locals: &[Local<R>; N]) -> R {
        let longest = self.longest;
        let turns = self.own.iter().filter(|own| **own >= 3).count();
        let theta = R::of(SHAPE_DEG * RAD) * R::of_i32(turns as i32);
        let lambda = R::of(SHAPE_MM * 1.732_050_807_568_877_3);
        let l = lambda + theta * longest;
        let most = R::of(MOST_SCALE);
        let mut sum = R::ZERO;
        for (slot, local) in locals.iter().enumerate() {
            let rho = self.shape(slot);
            let size = |twist| (halves(twist).0.norm(), halves(twist).1.norm());
            let [zeroth, first, second, third] = local.powers;
            let ((e, w), (e1, w1)) = (size(zeroth), size(first));
            // Upper bounds within the largest box.
            let far = rho * most;
            let (mut e1, mut w1) = (e1, w1);
            if self.curved {
                let ((e2, w2), (e3, w3)) = (size(second), size(third));
                e1 += (R::TWO * e2 + R::THREE * e3 * far) * far;
                w1 += (R::TWO * w2 + R::THREE * w3 * far) * far;
            }
            let (e, w) = (e + e1 * far, w + w1 * far);
            sum += rho * (R::TWO * w1 * l);
            if turns > 0 {
                let u = e + w * longest;
                sum += theta * (theta * u + R::TWO * (rho * (e1 + w1 * longest) + w * l));
                sum += w * theta * (R::TWO * lambda + theta * longest);
            }
        }
        let bound = sum * R::HALF;
        if bound * (most * most) > R::of(TOLERANCE_MM) { (R::of(TOLERANCE_MM) / bound).sqrt() } else { most }
    }

    /// Frames of all axes, and the position of the tip.
    fn frames(&self, at: &[R; N], poses: &Poses<R, N>) -> ([Frame<R>; N], V3<R>) {
        let mut frames = [Frame::bed(); N];
        let mut place = |frame: &mut Frame<R>, carriage: &Carriage<R>| {
            let slot = carriage.slot;
            let about = about(carriage.axis);
            let here = *frame;
            if carriage.axis.is_rotary() {
                frame.origin += here.out(carriage.offset);
                *frame = frame.rotated(about, poses.get(slot).copied().unwrap_or((R::ONE, R::ZERO)));
            } else {
                let q = at.get(slot).copied().unwrap_or(R::ZERO) + self.origins.get(slot).copied().unwrap_or(R::ZERO);
                frame.origin += here.direction(about) * (q * carriage.motion);
            }
            if let Some(entry) = frames.get_mut(slot) {
                *entry = if carriage.fixed { here } else { Frame { origin: frame.origin, ..here } };
            }
        };
        let mut workpiece = Frame::bed();
        self.chain.workpiece_side().rev().for_each(|carriage| place(&mut workpiece, carriage));
        let mut tool = Frame::bed();
        self.chain.tool_side().rev().for_each(|carriage| place(&mut tool, carriage));
        (frames, tool.origin + tool.out(self.chain.tool))
    }

    /// Errors of tip and direction, and their derivatives by every position, per mm (deg): with D, W the sums over the
    /// axes further out on the same side, a the direction of a rotary axis (rad per deg), n that of a slide, p − o the
    /// lever to the tip,
    ///
    /// ```text
    /// tool side      a × D + (W_all − W) × (a × (p − o))     (W_all − W − own) × n
    /// workpiece      a × D − W × (a × (p − o))               (W + own) × n
    /// ```
    ///
    /// plus the change of the own twist. For a slide whose errors stay where its travel starts, `own` is omitted.
    fn derivatives(&self, at: &[R; N], locals: &[Local<R>; N], tangent: &mut Tangent<R, P, N>) {
        let (frames, tip) = self.frames(at, &self.chain.poses(at));
        let none = Share { tip: [V3::ZERO; 4], turn: [V3::ZERO; 4] };
        let mut shares = [none; N];
        (tangent.tip, tangent.turn) = (V3::ZERO, V3::ZERO);
        for ((share, frame), local) in shares.iter_mut().zip(&frames).zip(locals) {
            let lever = tip - frame.origin;
            let powers = if self.curved { 4 } else { 2 };
            for ((tip, turn), twist) in share.tip.iter_mut().zip(&mut share.turn).zip(&local.powers).take(powers) {
                let (e, w) = halves(*twist);
                *turn = frame.out(w);
                *tip = frame.out(e) + turn.cross(lever);
            }
            let ([error, ..], [rotation, ..]) = (share.tip, share.turn);
            tangent.tip += error;
            tangent.turn += rotation;
        }
        let all = tangent.turn;
        for on_tool in [false, true] {
            let (mut outer_tip, mut outer_turn) = (V3::ZERO, V3::ZERO);
            for carriage in self.chain.side(on_tool) {
                let slot = carriage.slot;
                let (Some(frame), Some(share)) = (frames.get(slot), shares.get(slot)) else { continue };
                let ([error, own, square, cube], [rotation, turning, turn_square, turn_cube]) = (share.tip, share.turn);
                let direction = frame.direction(about(carriage.axis));
                let (mut along, mut turning) = (own, turning);
                if carriage.axis.is_rotary() {
                    let rate = direction * (carriage.motion * R::of(RAD));
                    let moved = rate.cross(tip - frame.origin);
                    let with = if on_tool { all - outer_turn } else { -outer_turn };
                    along += rate.cross(outer_tip) + with.cross(moved);
                    turning += rate.cross(outer_turn);
                } else {
                    let with = match (on_tool, carriage.fixed) {
                        (true, _) => all - outer_turn - rotation,
                        (false, false) => outer_turn + rotation,
                        (false, true) => outer_turn,
                    };
                    along += with.cross(direction);
                }
                outer_tip += error;
                outer_turn += rotation;
                if let (Some(to), Some(turn_to), Some(powers), Some(turn_powers)) = (
                    tangent.tip_slopes.get_mut(slot),
                    tangent.turn_slopes.get_mut(slot),
                    tangent.powers.get_mut(slot),
                    tangent.turn_powers.get_mut(slot),
                ) {
                    (*to, *turn_to) = (along, turning);
                    (*powers, *turn_powers) = ([square, cube], [turn_square, turn_cube]);
                }
            }
        }
    }
}

/// Converts a polynomial around a point `from` mm (deg) above the corner to one of steps from the corner.
#[inline(always)]
fn begin_at_corner<R: Real>(
    start: &mut V3<R>,
    slope: &mut V3<R>,
    [square, cube]: &mut [V3<R>; 2],
    from: R,
    step: R,
    curved: bool,
) {
    if curved {
        *start -= (*slope - (*square - *cube * from) * from) * from;
        *slope = (*slope - (*square * R::TWO - *cube * (R::THREE * from)) * from) * step;
        *square = (*square - *cube * (R::THREE * from)) * (step * step);
        *cube = *cube * (step * step * step);
    } else {
        *start -= *slope * from;
        *slope = *slope * step;
    }
}
