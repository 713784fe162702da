//! Error of the tip in a box, three slides and no rotary axis.
//!
//! With e and w of the tables as polynomials of t, the distances from the low corner of the box, L the levers at that corner,
//! and n_j the directions of the slides that stand between an axis and the tool,
//!
//! ```text
//! d = Σ_k  e_k(t_k) + w_k(t_k) × L_k  +  Σ_k Σ_j  w_k(t_k) × n_j t_j
//! ```
//!
//! The first sum is a polynomial of each t alone. Of the second the terms w_k(0), w_k' t_k are taken, which is all of a linear
//! table. With |w_k''| the largest in the table, T the width of the box and m other slides beyond, a cubic table's
//! rest is at most `|w_k''| T³ (√m/2 + 1/3)`, the third part where the own travel counts: T keeps the sum below
//! [`TOLERANCE_MM`]. In the direction of travel the box reaches [`AHEAD`] of its width.

use super::tangent::{TOLERANCE_MM, Tangent};
use super::{Volumetric, halves};
use crate::compensation::reversal::Direction;
use crate::compensation::thermal::ThermalLine;
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;

/// Largest box, mm: 32-bit floats still count its nanometres.
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

impl<R: Real, P: Position, const N: usize> Volumetric<'_, R, P, N> {
    /// The form about a position.
    #[inline(never)]
    pub(super) fn of_slides(
        &self,
        position: &[P; N],
        directions: &[Direction; N],
        thermal: &[ThermalLine<R>; N],
    ) -> Tangent<R, P, N> {
        let mut form = Tangent::nowhere();
        let ahead = self.width * R::of(AHEAD);
        let behind = self.width - ahead;
        let mut powers = [[[R::ZERO; 6]; 4]; N];
        let mut place = [R::ZERO; N];
        for slot in 0..N {
            let (Some(table), Some(position), Some(direction), Some(line)) =
                (self.tables.get(slot), position.get(slot), directions.get(slot), thermal.get(slot))
            else {
                continue;
            };
            let (Some(overlap), Some(origin), Some(datum)) =
                (self.overlaps.get(slot), self.origins.get(slot), self.datum.get(slot))
            else {
                continue;
            };
            let at = table.coordinate(*position);
            let interval = table.interval(at, *direction);
            let (down, up) = if *direction == Direction::POSITIVE { (behind, ahead) } else { (ahead, behind) };
            let [below, above] = interval.rooms(*overlap);
            let low = position.moved_back(P::offset(below.min(down)));
            let high = position.moved(P::offset(above.min(up)));
            let back: R = position.since_near(low);
            let mut own = interval.powers(interval.t - back * interval.per_mm);
            self.complete(slot, at - back, at - back - *datum, line, &mut own);
            form.edge |= u8::from(interval.edge) << (slot & 7);
            if let (Some(corner), Some(reach), Some(powers), Some(place)) =
                (form.low.get_mut(slot), form.reach.get_mut(slot), powers.get_mut(slot), place.get_mut(slot))
            {
                (*corner, *reach, *powers, *place) = (low, high.apart(low), own, at - back + *origin);
            }
        }
        self.sum_powers(&powers, &place, &mut form);
        form
    }

    /// Adds what does not stand in the table of a slide: growth, and squareness, which is linear in its position.
    #[inline(always)]
    fn complete(&self, slot: usize, at: R, from_datum: R, line: &ThermalLine<R>, powers: &mut [[R; 6]; 4]) {
        let [value, slope, ..] = powers;
        if let (Some(value), Some(slope)) = (value.get_mut(slot), slope.get_mut(slot)) {
            *value += line.at(from_datum);
            *slope += line.slope();
        }
        let [c0y, b0z, a0z] = self.squareness;
        let (tilt_x, tilt_y) = match slot {
            1 => (-c0y, R::ZERO),
            2 => (b0z, -a0z),
            _ => return,
        };
        let q = at + self.origins.get(slot).copied().unwrap_or(R::ZERO);
        let ([x, y, ..], [along_x, along_y, ..]) = (value, slope);
        *x += tilt_x * q;
        *y += tilt_y * q;
        *along_x += tilt_x;
        *along_y += tilt_y;
    }

    /// Sums the tables' polynomials up, at the levers of the low corner.
    #[inline(always)]
    fn sum_powers(&self, powers: &[[[R; 6]; 4]; N], place: &[R; N], form: &mut Tangent<R, P, N>) {
        let [qx, qy, qz, ..] = place.as_slice() else { return };
        let mut slopes = [V3::ZERO; 3];
        for (slot, (powers, [bx, by, bz])) in powers.iter().zip(&self.chain.beyond).enumerate() {
            let lever = self.chain.tool + V3::new(*bx * *qx, *by * *qy, *bz * *qz);
            let [zeroth, first, second, third] = powers.map(|twist| {
                let (e, w) = halves(twist);
                (e + w.cross(lever), w)
            });
            form.tip += zeroth.0;
            let mut curve = [second.0, third.0];
            for (slide, (there, along)) in [*bx, *by, *bz].into_iter().zip(&mut slopes).enumerate() {
                if slide == slot {
                    *along += first.0;
                }
                if there == R::ZERO {
                    continue;
                }
                *along += across(zeroth.1, slide);
                if slide == slot {
                    let [square, cube] = &mut curve;
                    *square += across(first.1, slide);
                    *cube += across(second.1, slide);
                } else if let Some(product) = form.products.get_mut((slide + slot).wrapping_sub(1)) {
                    *product += across(first.1, slide);
                }
            }
            if let Some(of_slot) = form.powers.get_mut(slot) {
                *of_slot = curve;
            }
        }
        let step = R::of(P::STEP);
        for (slope, sum) in form.tip_slopes.iter_mut().zip(slopes) {
            *slope = sum * step;
        }
        form.products = form.products.map(|product| product * (step * step));
        form.curved = self.curved;
        if form.curved {
            form.powers = form.powers.map(|[square, cube]| [square * (step * step), cube * (step * step * step)]);
        }
    }
}
