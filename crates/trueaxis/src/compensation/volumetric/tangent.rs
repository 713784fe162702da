//! Error of the pose about a position, to first order: value, derivative and the box in which that is enough.
//!
//! With u = e + w × L the contribution of an axis in its carrier's directions, L the lever from its frame to the tip, and
//! ρ_i the half width of the box along axis i (rad where it turns), λ = √Σρ² over the slides, θ = Σρ over the rotary axes,
//! the second derivative of the tip's error along any way from the centre to a border is at most
//!
//! ```text
//! Σ_k  θ² |u| + 2θ (|e'| ρ_k + |w'| ρ_k Λ + |w| l) + |e''| ρ_k² + |w''| ρ_k² Λ + 2 |w'| ρ_k l + |w| (2θλ + θ²Λ)
//! l = λ + θΛ
//! ```
//!
//! |L| <= Λ, and the tangent is off by half of that. The form is homogeneous in the ρ: a box of a fixed shape is scaled so
//! that it gives [`TOLERANCE_MM`]. Second derivatives come from cubic tables only; at a point of a linear table the slope
//! jumps, so a box ends there, but for an overlap in which the jump stays below [`KINK_MM`]. Values and slopes are the
//! largest in the largest box.

use super::carriages::{Carriage, about};
use super::{Side, Volumetric, halves};
use crate::compensation::reversal::Direction;
use crate::compensation::thermal::ThermalLine;
use crate::machine::{Axis, MachineSettings, Rows, Twist};
use crate::position::Position;
use crate::real::Real;
use crate::vector::{About, V3};

/// What the tangent may be off at the border of its box: of what the inverse may leave, most.
pub(super) const TOLERANCE_MM: f64 = 0.6e-6;
/// What it may be off in the overlap at a point of a linear table.
const KINK_MM: f64 = 0.1e-6;
/// Largest overlap.
const MOST_OVERLAP_MM: f64 = 0.02;
/// Half widths of the box before it is scaled, mm and degrees, and largest factor.
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
    /// Their derivatives, per step of a position.
    pub(super) tip_slopes: [V3<R>; N],
    turn_slopes: [V3<R>; N],
    /// Of three slides the rest, see [`super::slides`]: second and third powers, products of X and Y, X and Z, Y and Z.
    pub(super) powers: [[V3<R>; 2]; 3],
    pub(super) products: [V3<R>; 3],
    pub(super) curved: bool,
    /// A bit for every axis whose edge value is clamped.
    pub(super) edge: u8,
}

impl<R: Real, P: Position, const N: usize> Tangent<R, P, N> {
    /// A box that no position is in.
    pub(super) fn nowhere() -> Self {
        Tangent {
            low: [P::of(f64::NAN); N],
            reach: [P::Reach::default(); N],
            tip: V3::ZERO,
            turn: V3::ZERO,
            tip_slopes: [V3::ZERO; N],
            turn_slopes: [V3::ZERO; N],
            powers: [[V3::ZERO; 2]; 3],
            products: [V3::ZERO; 3],
            curved: false,
            edge: 0,
        }
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

    /// Error of the tip so many steps from the low corner.
    #[inline(always)]
    pub(super) fn tip(&self, steps: &[R; N]) -> V3<R> {
        if let (3, [x, y, z, ..], [along_x, along_y, along_z, ..]) = (N, steps.as_slice(), self.tip_slopes.as_slice()) {
            let [xy, xz, yz] = self.products;
            let (mut of_x, mut of_y, mut of_z) = (*along_x + xy * *y + xz * *z, *along_y + yz * *z, *along_z);
            if self.curved {
                let [[x2, x3], [y2, y3], [z2, z3]] = self.powers;
                of_x += (x2 + x3 * *x) * *x;
                of_y += (y2 + y3 * *y) * *y;
                of_z += (z2 + z3 * *z) * *z;
            }
            return self.tip + of_x * *x + of_y * *y + of_z * *z;
        }
        let mut tip = self.tip;
        for (steps, slope) in steps.iter().zip(&self.tip_slopes) {
            tip += *slope * *steps;
        }
        tip
    }

    /// Error of the direction so many steps from the low corner.
    #[inline(always)]
    pub(super) fn turn(&self, steps: &[R; N]) -> V3<R> {
        let mut turn = self.turn;
        for (steps, slope) in steps.iter().zip(&self.turn_slopes) {
            turn += *slope * *steps;
        }
        turn
    }
}

/// The twist of an axis at its position, with what bounds its change.
#[derive(Clone, Copy, Debug)]
struct Local<R> {
    twist: Twist<R>,
    slope: Twist<R>,
    bend: Twist<R>,
    below: R,
    above: R,
}

/// Twists and tip in the frame that the walk has reached, with their derivatives by the positions of all axes.
struct Walk<R, const N: usize> {
    side: Side<R>,
    tip: V3<R>,
    sides: [Side<R>; N],
    tips: [V3<R>; N],
}

impl<R: Real, const N: usize> Walk<R, N> {
    fn from(tip: V3<R>) -> Self {
        let none = Side { v: V3::ZERO, w: V3::ZERO };
        Walk { side: none, tip, sides: [none; N], tips: [V3::ZERO; N] }
    }

    /// The axis' own twist.
    fn add(&mut self, slot: usize, local: &Local<R>) {
        self.side.add(halves(local.twist));
        if let Some(side) = self.sides.get_mut(slot) {
            side.add(halves(local.slope));
        }
    }

    /// Through a slide that stands `travel` in the sense `sense`.
    fn slide(&mut self, carriage: &Carriage<R>, travel: R, sense: R) {
        self.side.slide(carriage.axis, travel);
        for side in &mut self.sides {
            side.slide(carriage.axis, travel);
        }
        let mut own = Side { v: V3::ZERO, w: self.side.w };
        own.slide(carriage.axis, sense);
        if let Some(side) = self.sides.get_mut(carriage.slot) {
            side.v += own.v;
        }
    }

    /// The tip moves with a slide that carries the tool.
    fn advance(&mut self, carriage: &Carriage<R>, travel: R) {
        let n = along(about(carriage.axis));
        self.tip += n * travel;
        if let Some(tip) = self.tips.get_mut(carriage.slot) {
            *tip += n;
        }
    }

    /// Out of a rotary axis' frame.
    fn turn(&mut self, carriage: &Carriage<R>, pose: (R, R), local: &Local<R>) {
        let about = about(carriage.axis);
        let turned = |side: &Side<R>| Side { v: side.v.turned(about, pose), w: side.w.turned(about, pose) };
        self.side = turned(&self.side);
        for side in &mut self.sides {
            *side = turned(side);
        }
        // Per degree of the command.
        let rate = along::<R>(about) * (carriage.motion * R::of(RAD));
        if let Some(side) = self.sides.get_mut(carriage.slot) {
            side.v += rate.cross(self.side.v);
            side.w += rate.cross(self.side.w);
        }
        self.add(carriage.slot, local);
        if carriage.is_offset {
            self.side.v -= self.side.w.cross(carriage.offset);
            for side in &mut self.sides {
                side.v -= side.w.cross(carriage.offset);
            }
        }
        self.tip = self.tip.turned(about, pose);
        for tip in &mut self.tips {
            *tip = tip.turned(about, pose);
        }
        if let Some(tip) = self.tips.get_mut(carriage.slot) {
            *tip += rate.cross(self.tip);
        }
        self.tip += carriage.offset;
    }
}

fn along<R: Real>(about: About) -> V3<R> {
    match about {
        About::X => V3::new(R::ONE, R::ZERO, R::ZERO),
        About::Y => V3::new(R::ZERO, R::ONE, R::ZERO),
        About::Z => V3::new(R::ZERO, R::ZERO, R::ONE),
    }
}

/// Overlap of two neighbouring intervals of an axis: as far as the jumps of all slopes together stay below [`KINK_MM`].
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

impl<R: Real, P: Position, const N: usize> Volumetric<'_, R, P, N> {
    /// Twist of the axis at `slot`, all that is added to its table included.
    fn local(&self, slot: usize, at: R, direction: Direction, line: &ThermalLine<R>) -> Option<(Local<R>, bool)> {
        let interval = self.tables.get(slot)?.interval(at, direction);
        let ([mut twist, mut slope], bent) = interval.powers(interval.t);
        let room = interval.below.max(interval.above);
        let bend = match bent {
            Some([second, third]) if !interval.edge => {
                core::array::from_fn(|k| R::TWO * (second[k].abs() + R::THREE * third[k].abs() * room))
            }
            _ => [R::ZERO; 6],
        };
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
        let [c0y, b0z, a0z] = self.squareness;
        let (tilt_x, tilt_y) = match slot {
            1 => (-c0y, R::ZERO),
            2 => (b0z, -a0z),
            _ => (R::ZERO, R::ZERO),
        };
        let ([x, y, ..], [along_x, along_y, ..]) = (&mut twist, &mut slope);
        *x += tilt_x * q;
        *y += tilt_y * q;
        *along_x += tilt_x;
        *along_y += tilt_y;
        let [below, above] = interval.rooms(*self.overlaps.get(slot)?);
        Some((Local { twist, slope, bend, below, above }, interval.edge))
    }

    /// Makes `tangent` the one about a position.
    #[inline(never)]
    pub(super) fn tangent(
        &self,
        tangent: &mut Tangent<R, P, N>,
        position: &[P; N],
        directions: &[Direction; N],
        thermal: &[ThermalLine<R>; N],
    ) {
        let at = self.coordinates(position);
        let zero = [R::ZERO; 6];
        let still = Local { twist: zero, slope: zero, bend: zero, below: R::MAX, above: R::MAX };
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
        (tangent.tip, tangent.turn, tangent.tip_slopes, tangent.turn_slopes) = self.derivatives(&at, &locals);
        tangent.edge = edge;
        let scale = self.scale(&locals);
        for (slot, (position, local)) in position.iter().zip(&locals).enumerate() {
            let half = self.shape(slot) * scale;
            let low = position.moved_back(P::offset(local.below.min(half)));
            let high = position.moved(P::offset(local.above.min(half)));
            let from: R = position.since_near(low);
            if let (Some(corner), Some(reach), Some(along), Some(turning)) = (
                tangent.low.get_mut(slot),
                tangent.reach.get_mut(slot),
                tangent.tip_slopes.get_mut(slot),
                tangent.turn_slopes.get_mut(slot),
            ) {
                (*corner, *reach) = (low, high.apart(low));
                tangent.tip -= *along * from;
                tangent.turn -= *turning * from;
                *along = *along * R::of(P::STEP);
                *turning = *turning * R::of(P::STEP);
            }
        }
    }

    /// Half width of the box before it is scaled.
    fn shape(&self, slot: usize) -> R {
        R::of(if self.own.get(slot).is_some_and(|own| *own >= 3) { SHAPE_DEG } else { SHAPE_MM })
    }

    /// Factor of the box's shape: see the head of the file.
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
            let [(e, w), (e1, w1), (e2, w2)] =
                [local.twist, local.slope, local.bend].map(|twist| (halves(twist).0.norm(), halves(twist).1.norm()));
            // The largest in the largest box.
            let far = rho * most;
            let (e1, w1) = (e1 + e2 * far, w1 + w2 * far);
            let (e, w) = (e + e1 * far, w + w1 * far);
            sum += rho * (R::TWO * w1 * l + rho * (e2 + w2 * longest));
            if turns > 0 {
                let u = e + w * longest;
                sum += theta * (theta * u + R::TWO * (rho * (e1 + w1 * longest) + w * l));
                sum += w * theta * (R::TWO * lambda + theta * longest);
            }
        }
        let bound = sum * R::HALF;
        if bound * (most * most) > R::of(TOLERANCE_MM) { (R::of(TOLERANCE_MM) / bound).sqrt() } else { most }
    }

    /// Errors of tip and direction, and their derivatives by every position, per mm (deg).
    fn derivatives(&self, at: &[R; N], locals: &[Local<R>; N]) -> (V3<R>, V3<R>, [V3<R>; N], [V3<R>; N]) {
        let poses = self.chain.poses(at);
        let of = |carriage: &Carriage<R>| {
            let slot = carriage.slot;
            let q = at.get(slot).copied().unwrap_or(R::ZERO) + self.origins.get(slot).copied().unwrap_or(R::ZERO);
            (q, poses.get(slot).copied().unwrap_or((R::ONE, R::ZERO)), locals.get(slot))
        };
        let mut tool = Walk::<R, N>::from(self.chain.tool);
        for carriage in self.chain.tool_side() {
            let (q, pose, Some(local)) = of(carriage) else { continue };
            if carriage.axis.is_rotary() {
                tool.turn(carriage, pose, local);
            } else {
                tool.add(carriage.slot, local);
                tool.slide(carriage, q, R::ONE);
                tool.advance(carriage, q);
            }
        }
        let mut workpiece = Walk::<R, N>::from(V3::ZERO);
        for carriage in self.chain.workpiece_side() {
            let (q, pose, Some(local)) = of(carriage) else { continue };
            if carriage.axis.is_rotary() {
                workpiece.turn(carriage, pose, local);
            } else if carriage.fixed {
                workpiece.slide(carriage, -q, -R::ONE);
                workpiece.add(carriage.slot, local);
            } else {
                workpiece.add(carriage.slot, local);
                workpiece.slide(carriage, -q, -R::ONE);
            }
        }
        let turn = tool.side.w + workpiece.side.w;
        let tip = tool.side.v + workpiece.side.v + turn.cross(tool.tip);
        let (mut tip_slopes, mut turn_slopes) = ([V3::ZERO; N], [V3::ZERO; N]);
        let sides = tool.sides.iter().zip(&workpiece.sides).zip(&tool.tips);
        for ((along, turning), ((of_tool, of_workpiece), moved)) in
            tip_slopes.iter_mut().zip(&mut turn_slopes).zip(sides)
        {
            *turning = of_tool.w + of_workpiece.w;
            *along = of_tool.v + of_workpiece.v + turning.cross(tool.tip) + turn.cross(*moved);
        }
        (tip, turn, tip_slopes, turn_slopes)
    }
}
