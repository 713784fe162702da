//! The machine's true geometric error, by exact products of homogeneous transforms.
//!
//! Written apart from the compensation in the `trueaxis` crate (own interpolation, own transforms): the simulator
//! would otherwise only prove that the code agrees with itself.
//!
//! From the bed outwards each axis adds to its carrier's frame, with e, w its three translations and rotations:
//!
//! ```text
//! linear axis     T ← T · Translation(±q u) · E(±e, ±w)      rotation about the moved origin
//! rotary axis     T ← T · E(±e, ±w) · Rotation(u, direction·q)
//! ```
//!
//! upper signs on the tool side, lower on the workpiece side: a table holds the error of the tool relative to the
//! workpiece, whichever side moves. All frames coincide at zero. With p_w the tool tip in workpiece coordinates and R_w
//! the nominal orientation of the workpiece, the tip error is `d = R_w (p_w,actual − p_w,ideal)`.
//!
//! Squareness tilts the travel only: `EXY −= C0Y·y`, `EXZ += B0Z·z`, `EYZ −= A0Z·z`. The location errors of a rotary
//! axis are constants added to its six errors. Translations are read at the tool tip with the other linear axes at
//! `measured_at_mm` and the rotary ones at zero; at the axis' own frame they are `e − w × lever` with the lever of then.

use glam::{DAffine3, DQuat, DVec3};
use trueaxis::machine::{Axis, AxisSettings, Interpolation, LocationErrors, Row};
use trueaxis_tables::Machine;

/// One axis of the chain.
#[derive(Clone, Debug)]
struct Link {
    /// Place among the positions: X 0, Y 1, Z 2, then the rotary axes.
    place: usize,
    axis: Axis,
    direction: f64,
    measured_at: [f64; 3],
    cubic: bool,
    rows: Vec<Row>,
    constant: [f64; 6],
}

/// The exact geometry of a machine.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// From the bed to the workpiece, from the bed to the tool.
    workpiece: Vec<Link>,
    tool: Vec<Link>,
    tool_tip: DVec3,
    location: LocationErrors,
}

/// The places of a machine's axes among the positions: X, Y, Z, then the rotary axes in alphabetical order.
pub fn place_of(machine: &Machine, axis: Axis) -> usize {
    if !axis.is_rotary() {
        return axis.index();
    }
    3 + machine.settings.axes.iter().filter(|a| a.axis.is_rotary() && a.axis < axis).count()
}

impl Geometry {
    /// The geometry that a machine's tables describe.
    pub fn new(machine: &Machine) -> Geometry {
        let chain = machine.settings.chain.as_str();
        let (workpiece, tool) = chain.split_once('b').unwrap_or(("", chain));
        let link = |axis: Axis| {
            let (settings, table): (&AxisSettings, _) = machine
                .axes()
                .find(|(settings, _)| settings.axis == axis)
                .expect("a checked machine has every axis of its chain");
            Link {
                place: place_of(machine, axis),
                axis,
                direction: f64::from(settings.direction),
                measured_at: settings.measured_at_mm,
                cubic: settings.interpolation == Interpolation::Cubic,
                rows: table.map(|t| t.rows.clone()).unwrap_or_default(),
                constant: if axis.is_rotary() { machine.settings.location.rotary[axis.index() - 3] } else { [0.0; 6] },
            }
        };
        let side = |letters: &str| letters.chars().filter_map(Axis::from_letter).map(link).collect::<Vec<_>>();
        let mut workpiece = side(workpiece);
        workpiece.reverse();
        Geometry {
            workpiece,
            tool: side(tool),
            tool_tip: DVec3::from_array(machine.settings.tool_mm),
            location: machine.settings.location,
        }
    }

    /// Error of the tool tip in machine axes, mm, at axis positions (mm, deg) and, per axis, how far its reversal has
    /// gone: 0 in positive travel, 1 in negative.
    pub fn tip_error<const N: usize>(&self, q: &[f64; N], reversed: &[f64; N]) -> DVec3 {
        let ideal = self.relative(q, |_, _| None);
        let actual = self.relative(q, |link, workpiece| Some(self.error_of(link, q, reversed, workpiece)));
        let orientation = self.workpiece.iter().fold(DQuat::IDENTITY, |r, link| r * nominal_turn(link, q));
        orientation * (actual - ideal)
    }

    /// Tool tip in workpiece coordinates with the given error motions.
    fn relative<const N: usize>(&self, q: &[f64; N], error: impl Fn(&Link, bool) -> Option<(DVec3, DVec3)>) -> DVec3 {
        let side = |links: &[Link], workpiece: bool| {
            let sign = if workpiece { -1.0 } else { 1.0 };
            links.iter().fold(DAffine3::IDENTITY, |frame, link| {
                let motion = nominal_motion(link, q, sign);
                match error(link, workpiece) {
                    None => frame * motion,
                    Some((e, w)) => {
                        let e = DAffine3::from_rotation_translation(DQuat::from_scaled_axis(sign * w), sign * e);
                        if link.axis.is_rotary() { frame * e * motion } else { frame * motion * e }
                    }
                }
            })
        };
        let tip = side(&self.tool, false).transform_point3(self.tool_tip);
        side(&self.workpiece, true).inverse().transform_point3(tip)
    }

    /// Translations and rotations of an axis at its own frame.
    fn error_of<const N: usize>(
        &self,
        link: &Link,
        q: &[f64; N],
        reversed: &[f64; N],
        workpiece: bool,
    ) -> (DVec3, DVec3) {
        let at = q[link.place];
        let mut error = interpolate(link, at, reversed[link.place]);
        for (error, constant) in error.iter_mut().zip(link.constant) {
            *error += constant;
        }
        match link.axis {
            Axis::Y => error[0] -= self.location.c0y * at,
            Axis::Z => {
                error[0] += self.location.b0z * at;
                error[1] -= self.location.a0z * at;
            }
            _ => {}
        }
        let [ex, ey, ez, wx, wy, wz] = error;
        let (e, w) = (DVec3::new(ex, ey, ez), DVec3::new(wx, wy, wz));
        if w == DVec3::ZERO {
            return (e, w);
        }
        (e - w.cross(self.lever_when_measured(link, at, workpiece)), w)
    }

    /// Tool tip from the moved origin of an axis while its table was measured, in the frame of its carrier.
    fn lever_when_measured(&self, link: &Link, at: f64, workpiece: bool) -> DVec3 {
        let [x, y, z] = link.measured_at;
        let mut q = [x, y, z, 0.0, 0.0, 0.0];
        q[link.place] = at;
        // Rotary axes stand at zero (an own angle does not move the origin), so all frames are parallel.
        let shift =
            |l: &Link, sign: f64| if l.axis.is_rotary() { DVec3::ZERO } else { sign * q[l.place] * unit(l.axis) };
        let tip = self.tool_tip + self.tool.iter().map(|l| shift(l, 1.0)).sum::<DVec3>();
        let (side, sign) = if workpiece { (&self.workpiece, -1.0) } else { (&self.tool, 1.0) };
        let inner = side.iter().position(|l| l.axis == link.axis).unwrap_or(0);
        let origin = side[..=inner].iter().map(|l| shift(l, sign)).sum::<DVec3>();
        tip - origin
    }
}

fn unit(axis: Axis) -> DVec3 {
    match axis.index() % 3 {
        0 => DVec3::X,
        1 => DVec3::Y,
        _ => DVec3::Z,
    }
}

fn nominal_turn<const N: usize>(link: &Link, q: &[f64; N]) -> DQuat {
    if link.axis.is_rotary() {
        DQuat::from_axis_angle(unit(link.axis), (link.direction * (q[link.place] % 360.0)).to_radians())
    } else {
        DQuat::IDENTITY
    }
}

fn nominal_motion<const N: usize>(link: &Link, q: &[f64; N], sign: f64) -> DAffine3 {
    if link.axis.is_rotary() {
        DAffine3::from_quat(nominal_turn(link, q))
    } else {
        DAffine3::from_translation(sign * q[link.place] * unit(link.axis))
    }
}

/// The table's six errors at a position, between its forward and reverse columns; edge values beyond the ends.
fn interpolate(link: &Link, at: f64, reversed: f64) -> [f64; 6] {
    let rows = &link.rows[..];
    let [first, .., last] = rows else { return [0.0; 6] };
    let length = last.position - first.position;
    let wraps = link.axis.is_rotary() && length == 360.0;
    let at = if wraps {
        first.position + (at - first.position).rem_euclid(360.0)
    } else {
        at.clamp(first.position, last.position)
    };
    let cell = rows.partition_point(|row| row.position <= at).clamp(1, rows.len() - 1) - 1;
    let value = |i: usize, k: usize| (1.0 - reversed) * rows[i].forward[k] + reversed * rows[i].reverse[k];
    let width = |i: usize| rows[i + 1].position - rows[i].position;
    let secant = |i: usize, k: usize| (value(i + 1, k) - value(i, k)) / width(i);
    let count = rows.len();
    let h = width(cell);
    let t = (at - rows[cell].position) / h;
    std::array::from_fn(|k| {
        let (v0, v1) = (value(cell, k), value(cell + 1, k));
        if !link.cubic {
            return v0 + t * (v1 - v0);
        }
        let slope = |i: usize| match (i, wraps) {
            _ if count == 2 => secant(0, k),
            (i, true) if i == 0 || i == count - 1 => {
                inner_slope(width(count - 2), secant(count - 2, k), width(0), secant(0, k))
            }
            (0, _) => outer_slope(width(0), secant(0, k), width(1), secant(1, k)),
            (i, _) if i == count - 1 => outer_slope(width(i - 1), secant(i - 1, k), width(i - 2), secant(i - 2, k)),
            (i, _) => inner_slope(width(i - 1), secant(i - 1, k), width(i), secant(i, k)),
        };
        // Hermite form.
        let (m0, m1) = (slope(cell) * h, slope(cell + 1) * h);
        let (t2, t3) = (t * t, t * t * t);
        v0 * (2.0 * t3 - 3.0 * t2 + 1.0) + m0 * (t3 - 2.0 * t2 + t) + v1 * (3.0 * t2 - 2.0 * t3) + m1 * (t3 - t2)
    })
}

/// Monotone slope between two cells (Fritsch and Butland 1984).
fn inner_slope(h0: f64, d0: f64, h1: f64, d1: f64) -> f64 {
    if d0 * d1 <= 0.0 { 0.0 } else { 3.0 * (h0 + h1) / ((2.0 * h1 + h0) / d0 + (h1 + 2.0 * h0) / d1) }
}

/// Monotone slope at an end, `h0`, `d0` the outermost cell.
fn outer_slope(h0: f64, d0: f64, h1: f64, d1: f64) -> f64 {
    let m = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
    if m.signum() != d0.signum() || d0 == 0.0 {
        0.0
    } else if d0.signum() != d1.signum() && m.abs() > (3.0 * d0).abs() {
        3.0 * d0
    } else {
        m
    }
}

#[cfg(test)]
mod tests;
