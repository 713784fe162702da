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

/// A box for which the polynomials are summed up, one slide a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Work<P: Position, const N: usize> {
    /// Position around which the box was laid.
    at: [P; N],
    low: [P; N],
    reach: [P::Reach; N],
    /// Slot of the next slide; [`Work::NOTHING`] if no work is under way.
    next: u8,
}

impl<P: Position, const N: usize> Work<P, N> {
    const NOTHING: u8 = u8::MAX;

    /// No work.
    pub(super) fn none() -> Self {
        let nowhere = [P::of(f64::NAN); N];
        Work { at: nowhere, low: nowhere, reach: [P::Reach::default(); N], next: Self::NOTHING }
    }

    /// Whether work is under way for a box that holds this position.
    pub(super) fn serves<R: Real>(&self, at: &[P; N]) -> bool {
        let ends = self.low.iter().zip(&self.reach);
        self.next != Self::NOTHING && at.iter().zip(ends).all(|(at, (low, reach))| at.steps_above::<R>(*low, *reach).1)
    }
}

// Only with volumetric.
impl<R: Real, P: Position, const N: usize> Volumetric<'_, R, P, N> {
    /// Lays the box around a position; the form has none until [`Volumetric::add_slide`] has added all slides.
    #[inline(never)]
    pub(super) fn begin_slides(
        &self,
        form: &mut Tangent<R, P, N>,
        work: &mut Work<P, N>,
        position: &[P; N],
        directions: &[Direction; N],
    ) {
        form.clear();
        (form.tip, form.tip_slopes, form.products) = (V3::ZERO, [V3::ZERO; N], [V3::ZERO; 3]);
        (form.edge, form.curved) = (0, self.curved);
        (work.at, work.next) = (*position, 0);
        let ahead = self.width * R::of(AHEAD);
        let behind = self.width - ahead;
        let ends = work.low.iter_mut().zip(&mut work.reach).zip(position.iter().zip(directions));
        for (slot, ((table, overlap), ((low, reach), (position, direction)))) in
            self.tables.iter().zip(&self.overlaps).zip(ends).enumerate()
        {
            let interval = table.interval(table.coordinate(*position), *direction);
            let (down, up) = if *direction == Direction::POSITIVE { (behind, ahead) } else { (ahead, behind) };
            let [below, above] = interval.rooms(*overlap);
            *low = position.moved_back(P::offset(below.min(down)));
            *reach = position.moved(P::offset(above.min(up))).apart(*low);
            form.edge |= u8::from(interval.edge) << (slot & 7);
        }
    }

    /// Adds the next slide's polynomials at the levers of the low corner, plus the errors outside its table; after the last
    /// one the form has its box. Returns whether it was the last.
    #[inline(never)]
    pub(super) fn add_slide(
        &self,
        form: &mut Tangent<R, P, N>,
        work: &mut Work<P, N>,
        directions: &[Direction; N],
        thermal: &[ThermalLine<R>; N],
    ) -> bool {
        let slot = usize::from(work.next);
        self.add(form, work, slot, directions, thermal);
        work.next = work.next.wrapping_add(1);
        if slot < 2 {
            return false;
        }
        work.next = Work::<P, N>::NOTHING;
        let step = R::of(P::STEP);
        for slope in &mut form.tip_slopes {
            *slope = *slope * step;
        }
        for product in &mut form.products {
            *product = *product * (step * step);
        }
        (form.low, form.reach) = (work.low, work.reach);
        true
    }

    #[inline(always)]
    fn add(
        &self,
        form: &mut Tangent<R, P, N>,
        work: &Work<P, N>,
        slot: usize,
        directions: &[Direction; N],
        thermal: &[ThermalLine<R>; N],
    ) {
        let (Some(table), Some(position), Some(low), Some(direction), Some(origin)) = (
            self.tables.get(slot),
            work.at.get(slot),
            work.low.get(slot),
            directions.get(slot),
            self.origins.get(slot),
        ) else {
            return;
        };
        let (Some(beyond @ [bx, by, bz]), Some(line), Some(datum)) =
            (self.chain.beyond.get(slot), thermal.get(slot), self.datum.get(slot))
        else {
            return;
        };
        let Some(own) = beyond.get(slot).copied() else { return };
        let [qx, qy, qz] = self.slides(&self.coordinates(&work.low));
        let at = table.coordinate(*position);
        let interval = table.interval(at, *direction);
        let back: R = position.since_near(*low);
        let at = at - back;
        let q = at + *origin;
        let lever = V3::new(*bx * qx, *by * qy, *bz * qz);
        let ([value, slope], bent) = interval.powers(interval.t - back * interval.per_mm);
        let ((mut e, w), (mut e1, w1)) = (halves(value), halves(slope));
        let (growth, rate) = (line.at(at - *datum), line.slope());
        match slot {
            0 => (e.x, e1.x) = (e.x + growth, e1.x + rate),
            1 => {
                let [x_slope, _] = self.squareness.slopes(1);
                (e.x, e1.x) = (e.x + self.squareness.of_y(q), e1.x + x_slope);
                (e.y, e1.y) = (e.y + growth, e1.y + rate);
            }
            _ => {
                let ([x, y], [x_slope, y_slope]) = (self.squareness.of_z(q), self.squareness.slopes(2));
                (e.x, e1.x) = (e.x + x, e1.x + x_slope);
                (e.y, e1.y) = (e.y + y, e1.y + y_slope);
                (e.z, e1.z) = (e.z + growth, e1.z + rate);
            }
        }
        form.tip += e + w.cross(lever);
        for (slide, (slope, there)) in form.tip_slopes.iter_mut().zip(beyond).enumerate() {
            *slope += across(w, slide) * *there;
        }
        if let Some(slope) = form.tip_slopes.get_mut(slot) {
            *slope += e1 + w1.cross(lever);
        }
        let [xy, xz, yz] = &mut form.products;
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
        if !self.curved {
            return;
        }
        let mut square = across(w1, slot) * own;
        let mut cube = V3::ZERO;
        if let Some([second, third]) = bent {
            let ((e2, w2), (e3, w3)) = (halves(second), halves(third));
            square += e2 + w2.cross(lever);
            cube = e3 + w3.cross(lever) + across(w2, slot) * own;
        }
        let step = R::of(P::STEP);
        if let Some(powers) = form.powers.get_mut(slot) {
            *powers = [square * (step * step), cube * (step * step * step)];
        }
    }
}
