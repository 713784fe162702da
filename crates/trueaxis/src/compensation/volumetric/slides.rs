//! Error of the tip in a box, for three slides without rotary axes.
//!
//! With e and w the tables' polynomials of t, the distances from the low corner of the box, L the levers at that corner,
//! and n_j the directions of the slides between an axis and the tool,
//!
//! ```text
//! d = Σ_k  e_k(t_k) + w_k(t_k) × L_k  +  Σ_k Σ_j  w_k(t_k) × n_j t_j
//! ```
//!
//! The first sum is a polynomial of each t alone. The second keeps the terms w_k(0), w_k' t_k, which are all of a linear
//! table. With |w_k''| the largest in the table, T the width of the box and m other slides beyond, the rest of a cubic
//! table is at most `|w_k''| T³ (√m/2 + 1/3)`, the 1/3 only if the own travel counts: T keeps the sum below
//! [`TOLERANCE_MM`]. In the direction of travel the box extends over [`AHEAD`] of its width.

use super::tangent::{TOLERANCE_MM, Tangent};
use super::{Volumetric, halves};
use crate::compensation::reversal::Direction;
use crate::compensation::table::Interval;
use crate::compensation::thermal::ThermalLine;
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;

/// Largest box, mm: 32-bit floats still resolve its nanometres.
const MOST_WIDTH_MM: f64 = 16.0;
const AHEAD: f64 = 0.9;

/// Width of the boxes, mm; `beyond` as in the chain, `bends` the largest |w''| of each table, per mm².
pub(super) fn width<R: Real>(beyond: &[[R; 3]], bends: &[R]) -> R {
    let mut sum = 0.0;
    for (slot, (slides, bend)) in beyond.iter().zip(bends).enumerate() {
        let others = slides.iter().enumerate().filter(|(j, there)| *j != slot && **there != R::ZERO).count();
        let own = slides.get(slot).is_some_and(|there| *there != R::ZERO);
        sum += bend.to_f64() * (libm::sqrt(others as f64) / 2.0 + if own { 1.0 / 3.0 } else { 0.0 });
    }
    let cubed = MOST_WIDTH_MM * MOST_WIDTH_MM * MOST_WIDTH_MM;
    R::of(if sum * cubed > TOLERANCE_MM { libm::cbrt(TOLERANCE_MM / sum) } else { MOST_WIDTH_MM })
}

/// `w × n` with n along X (0), Y (1) or Z.
#[inline(always)]
fn across<R: Real>(w: V3<R>, slide: usize) -> V3<R> {
    match slide {
        0 => V3::new(R::ZERO, w.z, -w.y),
        1 => V3::new(-w.z, R::ZERO, w.x),
        _ => V3::new(w.y, -w.x, R::ZERO),
    }
}

/// A slide in its table, from the low corner of the box.
struct Corner<'a, R> {
    interval: Interval<'a, R, 6>,
    /// Parameter of the interval's polynomial there.
    t: R,
    /// Position from the table's first point, and from machine zero.
    at: R,
    q: R,
}

/// Sums over the slides.
struct Sums<R> {
    tip: V3<R>,
    slopes: [V3<R>; 3],
    powers: [[V3<R>; 2]; 3],
    products: [V3<R>; 3],
    /// For each slide, the sum of rotations of the axes for which it carries the tool.
    carried: [V3<R>; 3],
}

impl<'a, R: Real, P: Position, const N: usize> Volumetric<'a, R, P, N> {
    /// Sets `form` to the polynomials around a position.
    #[inline(never)]
    pub(super) fn of_slides(
        &self,
        form: &mut Tangent<R, P, N>,
        position: &[P; N],
        directions: &[Direction; N],
        thermal: &[ThermalLine<R>; N],
    ) {
        form.edge = 0;
        let corners: [Option<Corner<'a, R>>; 3] =
            core::array::from_fn(|slot| self.corner(form, slot, *position.get(slot)?, *directions.get(slot)?));
        let [Some(x), Some(y), Some(z)] = &corners else { return };
        let place = [x.q, y.q, z.q];
        let none = V3::ZERO;
        let mut sums =
            Sums { tip: none, slopes: [none; 3], powers: [[none; 2]; 3], products: [none; 3], carried: [none; 3] };
        self.add(&mut sums, 0, x, &place, thermal);
        self.add(&mut sums, 1, y, &place, thermal);
        self.add(&mut sums, 2, z, &place, thermal);
        let step = R::of(P::STEP);
        form.tip = sums.tip;
        for (slide, (slope, (own, carried))) in
            form.tip_slopes.iter_mut().zip(sums.slopes.into_iter().zip(sums.carried)).enumerate()
        {
            *slope = (own + across(carried, slide)) * step;
        }
        form.products = sums.products.map(|product| product * (step * step));
        form.curved = self.curved;
        if form.curved {
            for (powers, [square, cube]) in form.powers.iter_mut().zip(sums.powers) {
                *powers = [square * (step * step), cube * (step * step * step)];
            }
        }
    }

    /// The box along one slide, and the slide at its low corner.
    #[inline(always)]
    fn corner(
        &self,
        form: &mut Tangent<R, P, N>,
        slot: usize,
        position: P,
        direction: Direction,
    ) -> Option<Corner<'a, R>> {
        let table = self.tables.get(slot)?;
        let at = table.coordinate(position);
        let interval = table.interval(at, direction);
        let ahead = self.width * R::of(AHEAD);
        let behind = self.width - ahead;
        let (down, up) = if direction == Direction::POSITIVE { (behind, ahead) } else { (ahead, behind) };
        let [below, above] = interval.rooms(*self.overlaps.get(slot)?);
        let low = position.moved_back(P::offset(below.min(down)));
        let high = position.moved(P::offset(above.min(up)));
        let back: R = position.since_near(low);
        (*form.low.get_mut(slot)?, *form.reach.get_mut(slot)?) = (low, high.apart(low));
        form.edge |= u8::from(interval.edge) << (slot & 7);
        let at = at - back;
        let t = interval.t - back * interval.per_mm;
        Some(Corner { interval, t, at, q: at + *self.origins.get(slot)? })
    }

    /// Adds a slide's polynomials at the levers of the low corner, plus the errors outside its table.
    #[inline(always)]
    fn add(
        &self,
        sums: &mut Sums<R>,
        slot: usize,
        corner: &Corner<'_, R>,
        [qx, qy, qz]: &[R; 3],
        thermal: &[ThermalLine<R>; N],
    ) {
        let (Some(beyond @ [bx, by, bz]), Some(line), Some(datum)) =
            (self.chain.beyond.get(slot), thermal.get(slot), self.datum.get(slot))
        else {
            return;
        };
        let Some(own) = beyond.get(slot).copied() else { return };
        let lever = V3::new(*bx * *qx, *by * *qy, *bz * *qz);
        let ([value, slope], bent) = corner.interval.powers(corner.t);
        let ((mut e, w), (mut e1, w1)) = (halves(value), halves(slope));
        let (growth, rate) = (line.at(corner.at - *datum), line.slope());
        match slot {
            0 => (e.x, e1.x) = (e.x + growth, e1.x + rate),
            1 => {
                let [x_slope, _] = self.squareness.slopes(1);
                (e.x, e1.x) = (e.x + self.squareness.of_y(corner.q), e1.x + x_slope);
                (e.y, e1.y) = (e.y + growth, e1.y + rate);
            }
            _ => {
                let ([x, y], [x_slope, y_slope]) = (self.squareness.of_z(corner.q), self.squareness.slopes(2));
                (e.x, e1.x) = (e.x + x, e1.x + x_slope);
                (e.y, e1.y) = (e.y + y, e1.y + y_slope);
                (e.z, e1.z) = (e.z + growth, e1.z + rate);
            }
        }
        sums.tip += e + w.cross(lever);
        for (carried, there) in sums.carried.iter_mut().zip(beyond) {
            *carried += w * *there;
        }
        let mut square = across(w1, slot) * own;
        let mut cube = V3::ZERO;
        if let Some([second, third]) = bent {
            let ((e2, w2), (e3, w3)) = (halves(second), halves(third));
            square += e2 + w2.cross(lever);
            cube = e3 + w3.cross(lever) + across(w2, slot) * own;
        }
        let [xy, xz, yz] = &mut sums.products;
        match slot {
            0 => {
                *xy += across(w1, 1) * *by;
                *xz += across(w1, 2) * *bz;
            }
            1 => {
                *xy += across(w1, 0) * *bx;
                *yz += across(w1, 2) * *bz;
            }
            _ => {
                *xz += across(w1, 0) * *bx;
                *yz += across(w1, 1) * *by;
            }
        }
        if let (Some(slope), Some(powers)) = (sums.slopes.get_mut(slot), sums.powers.get_mut(slot)) {
            *slope = e1 + w1.cross(lever);
            *powers = [square, cube];
        }
    }
}
