//! Axis-wise geometric error compensation: nine one-dimensional functions, one per direction and moving axis.
//!
//! Error at a position, tool relative to workpiece, actual − ideal (ISO 230-1:2012), in mm and bed axes:
//!
//! ```text
//! dx = EXX(x) + EXY(y) + EXZ(z) − C0Y·y + B0Z·z
//! dy = EYX(x) + EYY(y) + EYZ(z) − A0Z·z
//! dz = EZX(x) + EZY(y) + EZZ(z)
//! ```
//!
//! The error of each linear axis also includes thermal growth `K0 + k·(q − q0)` and, in negative travel, its backlash,
//! with or without a table. A rotary axis adds its three translations (turned by the nominal pose of the rotary axes that
//! carry it), and its own angular error is corrected in its own position. Lever arms of angular errors are not part of
//! this form.
//!
//! Source: Zhang Chong et al., geometric error compensation on an open CNC (2013); the direction of travel, the exact
//! inverse and the lookup at the feedback are extensions.

use super::query::Query;
use super::reversal::Direction;
use super::table::{AxisTable, Contribution, own_component, requirement_of_all};
use super::thermal::ThermalLine;
use super::trig::cos_sin_deg;
use super::{Errors, PASSES_MASK, Squareness};
use crate::error::{ConfigError, Field};
use crate::machine::{
    AXES, Axis, AxisOrder, Lines, Lookup, MOST_CARRIERS, MachineSettings, Rows, carries_workpiece, links,
};
use crate::position::Position;
use crate::real::Real;

/// A rotary axis that turns the carrier of another one.
#[derive(Clone, Copy, Debug)]
struct Parent<R> {
    /// Slot among the step's axes.
    index: usize,
    /// Machine axis about which it turns: 0, 1, 2 for X, Y, Z.
    about: usize,
    /// Sense of the rotation.
    sense: R,
}

/// Tables of a machine in the nine-term form, and how they are looked up: immutable, built once.
///
/// `N` axes: X, Y, Z first (an absent linear axis is a zero table), then the rotary axes of the chain.
#[derive(Clone, Copy, Debug)]
pub struct NineTerms<'a, R, P, const N: usize> {
    pub(super) tables: [AxisTable<'a, R, P>; N],
    /// Position of each table's origin from machine zero.
    pub(super) origins: [R; N],
    /// Whether to look up at the feedback: the axis' own error, its cross terms.
    at_feedback: [(bool, bool); N],
    parents: [[Option<Parent<R>>; 2]; N],
    own: [usize; N],
    pub(super) squareness: Squareness<R>,
    constant: [[R; 3]; N],
    pub(super) datum: [R; N],
    kind: Kind,
}

/// Kind of the tables, which selects the lookup loop: three axes at the command with tables of one kind, or anything
/// else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Equidistant and linear.
    Plain,
    /// Linear, some of them on free grids.
    Linear,
    /// Cubic, on any grid.
    Cubic,
    /// Mixed, with rotary axes, or looked up at the feedback.
    Any,
}

/// Loops of [`NineTerms::sum_of`].
const PLAIN: u8 = 0;
const LINEAR: u8 = 1;
const CUBIC: u8 = 2;

/// Selects the lookup by a constant and is always inlined. A function argument would be called through a shim, with its
/// result in memory.
#[cfg_attr(feature = "fast", inline(always))]
fn look_up<const KIND: u8, R: Real, P: Position>(
    table: &AxisTable<'_, R, P>,
    at: R,
    reverse: Direction,
) -> (Contribution<R>, bool) {
    match KIND {
        PLAIN => table.at_plain(at, reverse),
        LINEAR => table.at_linear(at, reverse),
        _ => table.at_cubic(at, reverse),
    }
}

/// The rotary axes between the bed and an axis, from the bed outwards; at most two are permitted.
fn parents_of<R: Real, const N: usize>(
    machine: &MachineSettings,
    order: &AxisOrder<N>,
    axis: Axis,
) -> Result<[Option<Parent<R>>; 2], ConfigError> {
    let links = links(&machine.chain)?;
    let primed = carries_workpiece(&machine.chain, axis);
    let mut side: heapless::Vec<Axis, AXES> =
        links.iter().filter(|link| link.carries_workpiece == primed).map(|link| link.axis).collect();
    if primed {
        side.reverse();
    }
    let mut parents = [None; 2];
    let mut free = parents.iter_mut();
    for carrier in side.into_iter().take_while(|a| *a != axis).filter(|a| a.is_rotary()) {
        let entry = free.next().ok_or(ConfigError::new(Field::Chain, 3.0, MOST_CARRIERS).on(axis))?;
        let settings = machine.axis(carrier);
        *entry = order.slot(carrier).map(|index| Parent {
            index,
            about: carrier.index() - Axis::A.index(),
            sense: R::of(settings.map_or(1.0, |s| f64::from(s.direction))),
        });
    }
    Ok(parents)
}

impl<'a, R: Real, P: Position, const N: usize> NineTerms<'a, R, P, N> {
    /// Memory that [`NineTerms::build`] needs, in scalars.
    pub fn requirement<'r, T: Rows + ?Sized + 'r>(
        machine: &MachineSettings,
        rows: impl Fn(Axis) -> Option<&'r T>,
    ) -> usize {
        requirement_of_all::<4, T>(machine, rows)
    }

    /// Builds the tables of a machine in borrowed memory.
    ///
    /// # Errors
    /// A table with fewer than two points or not ascending, memory too small, more axes than `N`.
    pub fn build<'r, T: Rows + ?Sized + 'r>(
        order: &AxisOrder<N>,
        machine: &MachineSettings,
        rows: impl Fn(Axis) -> Option<&'r T>,
        mut memory: &'a mut [R],
    ) -> Result<Self, ConfigError> {
        let axes = order.axes();
        let location = &machine.location;
        let mut built = NineTerms {
            tables: [AxisTable::zero(); N],
            origins: [R::ZERO; N],
            at_feedback: [(false, false); N],
            parents: [[None; 2]; N],
            own: axes.map(own_component),
            squareness: Squareness::of(location),
            constant: [[R::ZERO; 3]; N],
            datum: [R::ZERO; N],
            kind: Kind::Any,
        };
        let [mut plain, mut linear, mut cubic] = [N == 3; 3];
        for (slot, axis) in axes.into_iter().enumerate() {
            let Some(settings) = machine.axis(axis) else { continue };
            let sense =
                f64::from(settings.direction) * if carries_workpiece(&machine.chain, axis) { -1.0 } else { 1.0 };
            let table: AxisTable<'a, R, P> = match Lines::of(machine, &rows, settings) {
                Some((lines, settings)) => AxisTable::build(&settings, &lines, sense, &mut memory)?,
                None if axis.is_rotary() && machine.periods_of(axis).next().is_some() => AxisTable::zero_around(),
                None => AxisTable::zero(),
            };
            let feedback = (settings.lookup == Lookup::Feedback, settings.cross_lookup == Lookup::Feedback);
            let at_command = feedback == (false, false);
            plain &= table.is_plain() && at_command;
            linear &= table.is_linear() && at_command;
            cubic &= table.is_cubic() && at_command;
            let set = |entry: Option<&mut R>, value| {
                if let Some(entry) = entry {
                    *entry = R::of(value);
                }
            };
            set(built.origins.get_mut(slot), table.origin().to_f64());
            set(built.datum.get_mut(slot), settings.thermal.datum);
            if let (Some(t), Some(f), Some(p), Some(c)) = (
                built.tables.get_mut(slot),
                built.at_feedback.get_mut(slot),
                built.parents.get_mut(slot),
                built.constant.get_mut(slot),
            ) {
                *t = table;
                *f = feedback;
                *p = parents_of(machine, order, axis)?;
                if let Some([x, y, z, ..]) = location.of(axis) {
                    *c = [*x, *y, *z].map(R::of);
                }
            }
        }
        built.kind = match (plain, linear, cubic) {
            (true, ..) => Kind::Plain,
            (_, true, _) => Kind::Linear,
            (.., true) => Kind::Cubic,
            _ => Kind::Any,
        };
        Ok(built)
    }

    /// For three axes looked up at the command, which can use cells: whether their tables are cubic. Otherwise `None`.
    pub(crate) fn cells(&self) -> Option<bool> {
        (self.kind != Kind::Any).then_some(self.kind == Kind::Cubic)
    }

    /// Calls `take` with every number that distinguishes these tables from others, for tables that can use cells.
    pub(crate) fn numbers(&self, mut take: impl FnMut(f64)) {
        self.tables.iter().for_each(|table| table.numbers(&mut take));
        let squareness = self.squareness.angles();
        let scalars = squareness.iter().chain(&self.datum).chain(&self.origins);
        scalars.for_each(|number| take(number.to_f64()));
    }

    /// Converts positions to table coordinates.
    #[cfg_attr(feature = "fast", inline(always))]
    pub fn coordinates(&self, positions: &[P; N]) -> [R; N] {
        let mut at = [R::ZERO; N];
        for ((at, table), position) in at.iter_mut().zip(&self.tables).zip(positions) {
            *at = table.coordinate(*position);
        }
        at
    }

    /// X, Y, Z from machine zero, mm, from table coordinates.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn slides(&self, at: &[R; N]) -> [R; 3] {
        let mut slides = [R::ZERO; 3];
        for ((q, at), origin) in slides.iter_mut().zip(at).zip(&self.origins) {
            *q = *at + *origin;
        }
        slides
    }

    /// Returns the error of the nine terms alone at table coordinates, for plain tables: the inner loop of the step.
    ///
    /// Sets a bit in `clamped` for every axis whose edge value is used.
    #[cfg_attr(feature = "fast", inline(always))]
    pub fn plain_terms(&self, at: &[R; N], reverse: &[Direction; N], clamped: &mut u8) -> Errors<R, N> {
        self.sum_of::<PLAIN>(at, reverse, clamped)
    }

    /// Returns the error of the nine terms alone, for linear tables on any grid; separate from
    /// [`NineTerms::plain_terms`], so that equidistant tables do not carry the search.
    #[inline(never)]
    pub fn linear_terms(&self, at: &[R; N], reverse: &[Direction; N], clamped: &mut u8) -> Errors<R, N> {
        self.sum_of::<LINEAR>(at, reverse, clamped)
    }

    /// Error of the nine terms alone, for cubic tables on any grid.
    #[inline(never)]
    fn cubic_terms(&self, at: &[R; N], reverse: &[Direction; N], clamped: &mut u8) -> Errors<R, N> {
        self.sum_of::<CUBIC>(at, reverse, clamped)
    }

    /// Sum of the translations of all tables, all looked up at one position.
    #[cfg_attr(feature = "fast", inline(always))]
    fn sum_of<const KIND: u8>(&self, at: &[R; N], reverse: &[Direction; N], clamped: &mut u8) -> Errors<R, N> {
        let mut sum = [R::ZERO; 3];
        if let ([of_x, of_y, of_z, ..], [x, y, z, ..], [reverse_x, reverse_y, reverse_z, ..]) =
            (&self.tables[..], &at[..], &reverse[..])
        {
            let ([xx, yx, zx, _], edge_x) = look_up::<KIND, R, P>(of_x, *x, *reverse_x);
            let ([xy, yy, zy, _], edge_y) = look_up::<KIND, R, P>(of_y, *y, *reverse_y);
            let ([xz, yz, zz, _], edge_z) = look_up::<KIND, R, P>(of_z, *z, *reverse_z);
            sum = [xx + xy + xz, yx + yy + yz, zx + zy + zz];
            *clamped |= u8::from(edge_x) | u8::from(edge_y) << 1 | u8::from(edge_z) << 2;
        }
        let mut errors = [R::ZERO; N];
        for (error, sum) in errors.iter_mut().zip(sum) {
            *error = sum;
        }
        errors
    }

    /// Error of any tables, each looked up at the command or the feedback as configured.
    ///
    /// Takes no [`Query`]: passed to a function that is not inlined, a `Query` would have to be in memory in every cycle.
    #[inline(never)]
    fn general_terms(
        &self,
        command: &[R; N],
        feedback: &[R; N],
        reverse: &[Direction; N],
        clamped: &mut u8,
    ) -> Errors<R, N> {
        let mut tip = [R::ZERO; 3];
        let mut errors = [R::ZERO; N];
        for slot in 0..N {
            let (Some(table), Some(at_command), Some(at_feedback), Some(reverse)) =
                (self.tables.get(slot), command.get(slot), feedback.get(slot), reverse.get(slot))
            else {
                continue;
            };
            let (Some(own_cross), Some(own), Some(parents), Some(constant)) =
                (self.at_feedback.get(slot), self.own.get(slot), self.parents.get(slot), self.constant.get(slot))
            else {
                continue;
            };
            let (own_feedback, cross_feedback) = *own_cross;
            let (cross, edge) = table.at(if cross_feedback { *at_feedback } else { *at_command }, *reverse);
            if edge {
                *clamped |= 1 << (slot & 7);
            }
            let mut contribution = cross;
            if own_feedback != cross_feedback {
                let (own_at, edge) = table.at(if own_feedback { *at_feedback } else { *at_command }, *reverse);
                if edge {
                    *clamped |= 1 << (slot & 7);
                }
                if let (Some(to), Some(from)) = (contribution.get_mut(*own), own_at.get(*own)) {
                    *to = *from;
                }
            }
            let [x, y, z, turn] = contribution;
            let [cx, cy, cz] = *constant;
            let mut shift = [x + cx, y + cy, z + cz];
            // From the innermost carrier outwards to the bed.
            for parent in parents.iter().rev().flatten() {
                let angle = command.get(parent.index).copied().unwrap_or(R::ZERO)
                    + self.origins.get(parent.index).copied().unwrap_or(R::ZERO);
                shift = turned(shift, parent.about, angle * parent.sense);
            }
            for (sum, part) in tip.iter_mut().zip(shift) {
                *sum += part;
            }
            if slot >= 3
                && let Some(error) = errors.get_mut(slot)
            {
                *error = turn;
            }
        }
        for (error, sum) in errors.iter_mut().zip(tip) {
            *error = sum;
        }
        errors
    }

    /// Squareness and thermal growth: linear in the position, and not clamped at a table's edge.
    #[cfg_attr(feature = "fast", inline(always))]
    fn add_linear(&self, at: &[R; N], thermal: &[ThermalLine<R>; N], errors: &mut Errors<R, N>) {
        let mut position = [R::ZERO; N];
        for ((q, at), origin) in position.iter_mut().zip(at).zip(&self.origins) {
            *q = *at + *origin;
        }
        for (((error, q), line), datum) in errors.iter_mut().zip(&position).zip(thermal).zip(&self.datum) {
            *error += line.at(*q - *datum);
        }
        if let ([_, y, z, ..], [dx, dy, ..]) = (&position[..], &mut errors[..]) {
            let [x_tilt, y_tilt] = self.squareness.error(*y, *z);
            *dx += x_tilt;
            *dy += y_tilt;
        }
    }

    /// Returns the errors at a position: modelled deviation of the tip from the axis positions, and of the rotary axes.
    ///
    /// Sets a bit in `clamped` for every axis whose edge value is used.
    #[cfg_attr(feature = "fast", inline(always))]
    pub fn errors(&self, query: &Query<'_, R, N>, clamped: &mut u8) -> Errors<R, N> {
        let Query { command, feedback, directions, thermal } = *query;
        let mut errors = if self.kind == Kind::Plain {
            self.plain_terms(command, directions, clamped)
        } else if self.kind == Kind::Linear {
            self.linear_terms(command, directions, clamped)
        } else if self.kind == Kind::Cubic {
            self.cubic_terms(command, directions, clamped)
        } else {
            self.general_terms(command, feedback, directions, clamped)
        };
        self.add_linear(command, thermal, &mut errors);
        errors
    }

    /// [`NineTerms::errors`] at one position of X, Y, Z, for tables that can use cells.
    #[inline(never)]
    pub(crate) fn errors_at(
        &self,
        [x, y, z]: &[P; 3],
        directions: &[Direction; N],
        thermal: &[ThermalLine<R>; N],
    ) -> ([R; 3], u8) {
        let (
            [of_x, of_y, of_z, ..],
            [origin_x, origin_y, origin_z, ..],
            [datum_x, datum_y, datum_z, ..],
            [growth_x, growth_y, growth_z, ..],
        ) = (&self.tables[..], &self.origins[..], &self.datum[..], &thermal[..])
        else {
            return ([R::ZERO; 3], 0);
        };
        let mut at = [R::ZERO; N];
        for (at, coordinate) in at.iter_mut().zip([of_x.coordinate(*x), of_y.coordinate(*y), of_z.coordinate(*z)]) {
            *at = coordinate;
        }
        let mut clamped = 0;
        let sum = match self.kind {
            Kind::Plain => self.sum_of::<PLAIN>(&at, directions, &mut clamped),
            Kind::Cubic => self.sum_of::<CUBIC>(&at, directions, &mut clamped),
            _ => self.sum_of::<LINEAR>(&at, directions, &mut clamped),
        };
        let ([ex, ey, ez, ..], [x, y, z, ..]) = (&sum[..], &at[..]) else { return ([R::ZERO; 3], 0) };
        let (qx, qy, qz) = (*x + *origin_x, *y + *origin_y, *z + *origin_z);
        let [tilt_x, tilt_y] = self.squareness.error(qy, qz);
        let errors = [
            *ex + growth_x.at(qx - *datum_x) + tilt_x,
            *ey + growth_y.at(qy - *datum_y) + tilt_y,
            *ez + growth_z.at(qz - *datum_z),
        ];
        (errors, clamped)
    }

    /// Returns the wanted correction: `r` with `q + r + E(q + r) = q`, by `passes` lookups `r ← −E(q + r)` from `r = 0`.
    ///
    /// mm, rotary axes in degrees. Errors looked up at the feedback need no inverse and are used as read.
    #[cfg_attr(feature = "fast", inline(always))]
    pub fn correction(&self, query: &Query<'_, R, N>, passes: u8, clamped: &mut u8) -> [R; N] {
        let command = query.command;
        let mut at = *command;
        let mut correction = [R::ZERO; N];
        // At most 8 rounds: more passes are refused when the tables are built.
        for _ in 0..passes & PASSES_MASK {
            let errors = self.errors(&Query { command: &at, ..*query }, clamped);
            for (((r, at), q), error) in correction.iter_mut().zip(&mut at).zip(command).zip(errors) {
                *r = -error;
                *at = *q - error;
            }
        }
        correction
    }
}

/// Rotates a vector about X (0), Y (1) or Z (2) by an angle in degrees.
#[cfg_attr(feature = "fast", inline(always))]
fn turned<R: Real>([x, y, z]: [R; 3], about: usize, angle: R) -> [R; 3] {
    let (c, s) = cos_sin_deg(angle);
    match about {
        0 => [x, c * y - s * z, s * y + c * z],
        1 => [c * x + s * z, y, c * z - s * x],
        _ => [c * x - s * y, s * x + c * y, z],
    }
}
