//! Values in a cell of a grid, from the stored numbers at its corners.

use super::LINEAR;
use super::along::{Along, Place};
use crate::machine::{GridData, Twist};
use crate::real::Real;

/// Factors of 1, t, u, tu, v, tv, uv, tuv; t, u, v from 0 to 1 along the axes of the grid in the order of [`Cells::along`].
pub(super) type Corners<R> = [R; 8];

/// The cells of one grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells<'a, R> {
    /// The axes that the grid spans come first; the third may be one that it does not span.
    pub(super) along: [Along<'a, R>; LINEAR],
    nodes: &'a [[u8; 2]],
    /// Which error each stored number of a node is, and the value of a stored 1; only for numbers that are read.
    components: [u8; 6],
    scales: [R; 6],
    given: u8,
}

impl<'a, R: Real> Cells<'a, R> {
    /// `rotations`: whether to read them too, if the grid has them.
    pub(super) fn new(data: &GridData<'a>, rotations: bool) -> Self {
        let header = data.header();
        let count = |axis: usize| header.axes.get(axis).map_or(1, |along| usize::from(along.nodes.max(1)));
        let columns = header.columns();
        let strides = [columns * count(1) * count(2), columns * count(2), columns];
        let mut order = [0, 1, 2];
        order.sort_unstable_by_key(|axis| !header.axes.get(*axis).is_some_and(|along| along.is_there()));
        let along = order.map(|axis| Along::new(data, axis, strides.get(axis).copied().unwrap_or(0)));
        let mut built =
            Cells { along, nodes: data.nodes().as_chunks().0, components: [0; 6], scales: [R::ZERO; 6], given: 0 };
        let kept = if rotations { 6 } else { 3 };
        let given = (0..kept).filter(|component| header.given >> component & 1 == 1);
        for (component, (own, scale)) in given.zip(built.components.iter_mut().zip(&mut built.scales)) {
            *own = component as u8;
            *scale = R::of(header.scales.get(component).copied().unwrap_or(0.0));
            built.given += 1;
        }
        built
    }

    /// The errors that are read, and the value of a stored 1 of each.
    #[inline(always)]
    fn columns(&self) -> impl Iterator<Item = (usize, R)> + '_ {
        let columns = self.components.iter().zip(&self.scales).take(usize::from(self.given));
        columns.map(|(component, scale)| (usize::from(*component), *scale))
    }

    /// The stored number at an index.
    #[inline(always)]
    fn stored(&self, place: usize) -> i32 {
        self.nodes.get(place).map_or(0, |bytes| i32::from(i16::from_le_bytes(*bytes)))
    }

    /// Index of the first number of a cell's first corner.
    #[inline(always)]
    fn corner(&self, [a, b, c]: [usize; LINEAR]) -> usize {
        let [x, y, z] = &self.along;
        a * x.stride() + b * y.stride() + c * z.stride()
    }

    /// Polynomial of the column's stored numbers in a cell; exact.
    #[inline(always)]
    fn polynomial(&self, first: usize) -> Corners<R> {
        let [x, y, z] = &self.along;
        let face = |at: usize| {
            let (v00, v10) = (self.stored(at), self.stored(at + x.stride()));
            let (v01, v11) = (self.stored(at + y.stride()), self.stored(at + x.stride() + y.stride()));
            [v00, v10 - v00, v01 - v00, v11 - v10 - v01 + v00]
        };
        let near = face(first);
        let [a, b, c, d] = near.map(R::of_i32);
        if !z.is_there() {
            return [a, b, c, d, R::ZERO, R::ZERO, R::ZERO, R::ZERO];
        }
        let far = face(first + z.stride());
        let [n0, n1, n2, n3] = near;
        let [f0, f1, f2, f3] = far;
        let [e, f, g, h] = [f0 - n0, f1 - n1, f2 - n2, f3 - n3].map(R::of_i32);
        [a, b, c, d, e, f, g, h]
    }

    /// Places of X, Y, Z, in the order of the grid's axes, and one bit for every axis beyond its nodes.
    #[inline(always)]
    pub(super) fn places(&self, q: &[R; LINEAR]) -> ([Place<R>; LINEAR], u8) {
        let mut edge = 0;
        let places = self.along.map(|along| {
            let place = along.place(q.get(along.axis()).copied().unwrap_or(R::ZERO));
            edge |= u8::from(place.edge) << (along.axis() & 7);
            place
        });
        (places, edge)
    }

    /// Calls `take` with every error that is read and its polynomial in the cell.
    #[inline(always)]
    pub(super) fn polynomials(&self, index: [usize; LINEAR], mut take: impl FnMut(usize, Corners<R>)) {
        let corner = self.corner(index);
        for (place, (component, scale)) in self.columns().enumerate() {
            let stored = self.polynomial(corner + place);
            take(component, stored.map(|number| number * scale));
        }
    }

    /// The six errors at X, Y, Z, mm and rad, and one bit for every axis beyond its nodes.
    #[inline(always)]
    pub(super) fn twist(&self, q: &[R; LINEAR]) -> (Twist<R>, u8) {
        let ([x, y, z], edge) = self.places(q);
        let corner = self.corner([x.index, y.index, z.index]);
        let [_, _, third] = &self.along;
        let mut twist = [R::ZERO; 6];
        for (place, (component, scale)) in self.columns().enumerate() {
            let [a, b, c, d, e, f, g, h] = self.polynomial(corner + place);
            let mut value = a + b * x.t + (c + d * x.t) * y.t;
            if third.is_there() {
                value += (e + f * x.t + (g + h * x.t) * y.t) * z.t;
            }
            if let Some(error) = twist.get_mut(component) {
                *error = value * scale;
            }
        }
        (twist, edge)
    }
}
