//! G2 and G3: from words to centre, normal and turns.

use super::curve::Curve;
use super::error::Refusal;
use super::limits::MOST_TURNS;

/// Largest difference in mm between the radii at start and end of an arc given by its centre. LinuxCNC accepts as much in
/// small arcs, and a thousandth of the radius in large ones.
const RADIUS_TOLERANCE: f64 = 2.0e-2;

/// Amount by which twice R may fall short of the chord, mm; a smaller radius or chord is invalid.
const CHORD_TOLERANCE: f64 = 2.0e-3;

/// Start and end of a full turn agree within this, mm.
const SAME_PLACE: f64 = 1.0e-9;

/// Active plane: the axes that span it (first, second) and its normal follow the cyclic order of X, Y, Z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Plane {
    /// G17.
    #[default]
    Xy,
    /// G18.
    Zx,
    /// G19.
    Yz,
}

impl Plane {
    /// Indices of the first and second axis and of the normal.
    pub(super) fn axes(self) -> [usize; 3] {
        match self {
            Plane::Xy => [0, 1, 2],
            Plane::Zx => [2, 0, 1],
            Plane::Yz => [1, 2, 0],
        }
    }

    pub(super) fn normal(self) -> [f64; 3] {
        let mut normal = [0.0; 3];
        normal[self.axes()[2]] = 1.0;
        normal
    }

    pub(super) fn code(self) -> &'static str {
        match self {
            Plane::Xy => "G17",
            Plane::Zx => "G18",
            Plane::Yz => "G19",
        }
    }
}

/// Words of a block about an arc, mm.
pub(super) struct ArcWords {
    pub(super) line: u32,
    pub(super) clockwise: bool,
    pub(super) plane: Plane,
    pub(super) start: [f64; 3],
    pub(super) end: [f64; 3],
    /// I, J, K.
    pub(super) center: [Option<f64>; 3],
    /// G90.1: I J K are coordinates; otherwise they count from the start.
    pub(super) absolute_center: bool,
    pub(super) radius: Option<f64>,
    /// P.
    pub(super) turns: Option<f64>,
}

impl ArcWords {
    fn refuse<T>(&self, found: impl Into<String>, needed: impl Into<String>) -> Result<T, Refusal> {
        Err(Refusal::new(self.line, found, needed))
    }

    pub(super) fn curve(&self) -> Result<Curve, Refusal> {
        let given = self.center.iter().any(Option::is_some);
        let center = match (self.radius, given) {
            (Some(_), true) => return self.refuse("R together with I, J or K", "either R or a centre"),
            (None, false) => return self.refuse("an arc without centre", "I J K of the plane, or R"),
            (Some(radius), false) => self.center_by_radius(radius)?,
            (None, true) => self.center_by_offsets()?,
        };
        let turns = match self.turns {
            None => 0,
            Some(p) if p.fract() == 0.0 && (1.0..=f64::from(MOST_TURNS)).contains(&p) => p as u32 - 1,
            Some(p) => {
                return self
                    .refuse(format!("P{p} with an arc"), format!("a whole number of turns from 1 to {MOST_TURNS}"));
            }
        };
        let normal = self.plane.normal().map(|n| if self.clockwise { -n } else { n });
        let mut end = self.end;
        let [a, b, _] = self.plane.axes();
        // Rounding from adding and subtracting offsets must not turn a full turn into a tiny one.
        if [a, b].into_iter().all(|axis| (end[axis] - self.start[axis]).abs() < SAME_PLACE) {
            (end[a], end[b]) = (self.start[a], self.start[b]);
        }
        Ok(Curve::Arc { start: self.start, end, center, normal, turns })
    }

    fn center_by_offsets(&self) -> Result<[f64; 3], Refusal> {
        let [a, b, n] = self.plane.axes();
        // Posts write K0 beside I and J.
        if self.center[n].is_some_and(|offset| offset != 0.0) {
            let letter = ["I", "J", "K"][n];
            return self.refuse(format!("{letter} in plane {}", self.plane.code()), "the centre words of the plane");
        }
        let mut center = self.start;
        for axis in [a, b] {
            center[axis] = match (self.center[axis], self.absolute_center) {
                (Some(value), true) => value,
                (Some(value), false) => self.start[axis] + value,
                (None, false) => self.start[axis],
                (None, true) => return self.refuse("one centre word with G90.1", "both centre words of the plane"),
            };
        }
        let radius = |point: [f64; 3]| libm::hypot(point[a] - center[a], point[b] - center[b]);
        let (first, last) = (radius(self.start), radius(self.end));
        if first < CHORD_TOLERANCE || last < CHORD_TOLERANCE {
            return self.refuse(format!("an arc of radius {:.4} mm", first.min(last)), "a centre away from the arc");
        }
        if (first - last).abs() > RADIUS_TOLERANCE {
            return self.refuse(
                format!("an arc of radius {first:.4} mm at its start and {last:.4} mm at its end"),
                format!("radii that agree within {RADIUS_TOLERANCE} mm"),
            );
        }
        Ok(center)
    }

    /// R > 0: the arc of at most half a turn; R < 0: the other arc.
    fn center_by_radius(&self, radius: f64) -> Result<[f64; 3], Refusal> {
        let [a, b, _] = self.plane.axes();
        let (da, db) = (self.end[a] - self.start[a], self.end[b] - self.start[b]);
        let chord = libm::hypot(da, db);
        if chord < CHORD_TOLERANCE {
            return self.refuse("R where start and end are the same", "a centre by I J K");
        }
        let half = 0.5 * chord;
        if radius.abs() < half - CHORD_TOLERANCE || radius == 0.0 {
            return self.refuse(
                format!("R {:.4} mm for points {chord:.4} mm apart", radius.abs()),
                "a radius of at least half that distance",
            );
        }
        // Left of the chord for a short counter-clockwise arc.
        let side = if self.clockwise == (radius > 0.0) { -1.0 } else { 1.0 };
        let distance = side * (radius * radius - half * half).max(0.0).sqrt();
        let mut center = self.start;
        center[a] += 0.5 * da - distance * db / chord;
        center[b] += 0.5 * db + distance * da / chord;
        Ok(center)
    }
}
