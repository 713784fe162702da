//! One axis' carriage: its motion and its errors.

use super::rotation::about;
use super::table::ErrorTable;
use crate::Table;
use glam::{DMat3, DVec3};
use trueaxis::machine::{Axis, AxisSettings, LocationErrors, PeriodicSettings, Twist};

/// One axis' carriage.
#[derive(Clone, Debug)]
pub(super) struct Carriage {
    pub(super) slot: usize,
    pub(super) rotary: bool,
    pub(super) along: DVec3,
    /// Origin of the frame from the carrier's at position zero, in the carrier's directions.
    pub(super) offset: DVec3,
    /// Sense of the carriage's motion for a positive command.
    pub(super) motion: f64,
    /// −1 if the carriage carries the workpiece.
    pub(super) sign: f64,
    table: Option<ErrorTable>,
    periods: Vec<Period>,
    constant: Twist,
    per_position: Twist,
    /// Component of the axis' own positioning error, and its change in negative travel (mm, rad).
    pub(super) own: usize,
    backlash: f64,
    pub(super) lever: DVec3,
    own_lever: f64,
}

/// Error that repeats within a period: `[a, b]` of the harmonics of both directions, mm or rad.
#[derive(Clone, Debug)]
struct Period {
    length: f64,
    forward: Vec<[f64; 2]>,
    reverse: Vec<[f64; 2]>,
}

impl Period {
    fn new(settings: &PeriodicSettings) -> Period {
        let unit = if settings.axis.is_rotary() { 1f64.to_radians() } else { 1.0 };
        let of = |pairs: &[[f64; 2]]| pairs.iter().map(|pair| pair.map(|figure| figure * unit)).collect::<Vec<_>>();
        let forward = of(&settings.harmonics);
        let reverse = if settings.reverse.is_empty() { forward.clone() } else { of(&settings.reverse) };
        let turn = 360.0 / (360.0 / settings.period).round();
        let length = if settings.axis.is_rotary() { turn } else { settings.period };
        Period { length, forward, reverse }
    }

    fn at(&self, q: f64, reverse: f64) -> f64 {
        let turn = (q / self.length).rem_euclid(1.0) * std::f64::consts::TAU;
        let wave = |pairs: &[[f64; 2]]| {
            let terms = pairs.iter().zip(1..).map(|([a, b], h)| {
                let (sin, cos) = (turn * f64::from(h)).sin_cos();
                a * cos + b * sin
            });
            terms.sum::<f64>()
        };
        wave(&self.forward) * (1.0 - reverse) + wave(&self.reverse) * reverse
    }
}

impl Carriage {
    pub(super) fn new(slot: usize, settings: &AxisSettings, table: Option<&Table>, on_workpiece: bool) -> Carriage {
        let rotary = settings.axis.is_rotary();
        let sign = if on_workpiece { -1.0 } else { 1.0 };
        Carriage {
            slot,
            rotary,
            along: unit(settings.axis),
            offset: DVec3::from_array(settings.offset_mm),
            motion: if rotary { f64::from(settings.direction) } else { sign },
            sign,
            table: table.map(|table| ErrorTable::new(settings, &table.rows)),
            periods: Vec::new(),
            constant: [0.0; 6],
            per_position: [0.0; 6],
            own: settings.axis.index(),
            backlash: if rotary { settings.backlash.to_radians() } else { settings.backlash },
            lever: DVec3::ZERO,
            own_lever: if on_workpiece && !rotary && settings.is_measured_along_a_line() { 1.0 } else { 0.0 },
        }
    }

    pub(super) fn add_location_errors(&mut self, axis: Axis, location: &LocationErrors) {
        match axis {
            Axis::X => {}
            Axis::Y => self.per_position[0] -= location.c0y,
            Axis::Z => {
                self.per_position[0] += location.b0z;
                self.per_position[1] -= location.a0z;
            }
            Axis::A => self.constant = location.rotary[0],
            Axis::B => self.constant = location.rotary[1],
            Axis::C => self.constant = location.rotary[2],
        }
    }

    pub(super) fn add_period(&mut self, settings: &PeriodicSettings) {
        self.periods.push(Period::new(settings));
    }

    pub(super) fn add_thermal_growth(&mut self, settings: &AxisSettings, rise_k: f64) {
        let growth = &settings.thermal;
        let unit = if self.rotary { 1f64.to_radians() } else { 1.0 };
        let slope = unit * rise_k * growth.expansion_per_k;
        self.per_position[self.own] += slope;
        self.constant[self.own] += unit * rise_k * growth.offset_per_k - slope * growth.datum;
    }

    /// Nominal motion at `q`: the travel from the carrier's origin and, for a rotary axis, the rotation.
    pub(super) fn nominal(&self, q: f64) -> (DVec3, Option<DMat3>) {
        if self.rotary {
            (self.offset, Some(about(self.along, (self.motion * q).to_radians())))
        } else {
            (self.offset + self.along * (self.motion * q), None)
        }
    }

    /// Translations (mm) and rotations (rad) at the axis frame's origin, tool relative to workpiece.
    pub(super) fn errors(&self, q: f64, reverse: f64) -> (DVec3, DVec3) {
        let table = self.table.as_ref().map_or([0.0; 6], |table| table.at(q, reverse));
        let turn = DVec3::new(table[3], table[4], table[5]);
        let shift = turn.cross(self.lever + self.along * (self.own_lever * q));
        let mut sum: Twist = std::array::from_fn(|i| table[i] + self.constant[i] + self.per_position[i] * q);
        sum[self.own] += reverse * self.backlash;
        sum[self.own] += self.periods.iter().map(|period| period.at(q, reverse)).sum::<f64>();
        let [ex, ey, ez, ea, eb, ec] = sum;
        (DVec3::new(ex, ey, ez) - shift, DVec3::new(ea, eb, ec))
    }
}

pub(super) fn unit(axis: Axis) -> DVec3 {
    match axis {
        Axis::X | Axis::A => DVec3::X,
        Axis::Y | Axis::B => DVec3::Y,
        Axis::Z | Axis::C => DVec3::Z,
    }
}
