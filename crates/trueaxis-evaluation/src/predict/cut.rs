//! What a feature consists of: the points that are cut, with the axes where the drives bring them.

use super::circle::Circle;
use super::gear::GearFlank;
use super::kinds::{FeatureKind, Side};
use super::temperature::Lines;
use crate::positions::in_order;
use crate::uncertainty::terms::Along;
use glam::{DMat3, DVec3};
use trueaxis::machine::AXES;
use trueaxis_sim::program::Move;
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;

/// A point of a feature.
#[derive(Clone, Debug)]
pub(super) struct Point {
    /// Programmed point, mm: in workpiece coordinates from the zero of the first set-up's program. With the rotary axes at
    /// zero these are the program's.
    pub(super) nominal: DVec3,
    /// Direction of the pass at a point of a profile; zero on other features.
    pub(super) tangent: DVec3,
    /// Of a profile with a side: how a tool larger in radius moves the surface, for each mm.
    pub(super) larger: DVec3,
    /// Whether two straight moves meet there.
    pub(super) joint: bool,
    /// Commands of the axes by [`Axis::index`].
    pub(super) command: [f64; AXES],
    pub(super) uncorrected: Reached,
    pub(super) corrected: Reached,
    /// With the servo, and everything that the machine configures against its error; as `corrected` without it.
    pub(super) everything: Reached,
    /// With the servo: what one standard uncertainty of each uncertain figure of the drives adds to `everything`.
    pub(super) drives: Vec<Followed>,
    /// Programmed point from the origin of the workpiece's frame, mm.
    pub(super) ideal: DVec3,
    /// Move of the program, and parameter on its curve.
    pub(super) place: (usize, f64),
    /// What the correction of the growth adds to that of the cold machine, as far as the limits of the axes admit.
    pub(super) warm: [f64; AXES],
    /// Growth of the axes when it is cut.
    pub(super) growth: Lines,
    /// Direction from the tip of the tool to the spindle.
    pub(super) pointing: DVec3,
}

/// Where the drives bring the axes at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    /// Positions by [`Axis::index`], mm.
    pub(super) sent: [f64; AXES],
    /// 1 for an axis in negative travel, else 0; with the servo in between while it traverses its lost motion.
    pub(super) reverse: [f64; AXES],
}

/// Which command reaches the drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    Uncorrected,
    Corrected,
    Everything,
}

/// A feature in the program.
#[derive(Clone, Debug)]
pub(super) struct Cut {
    pub(super) kind: FeatureKind,
    pub(super) points: Vec<Point>,
    /// First and last of its moves in the order of the program.
    pub(super) moves: [usize; 2],
    /// Normal of the plane that is active where it is cut, in workpiece coordinates.
    pub(super) normal: DVec3,
    /// Centre and radius of a circle.
    pub(super) circle: Option<Circle>,
    /// Set-up, if not the first, and the directions of its program on the part.
    pub(super) setup: Option<usize>,
    pub(super) to_part: DMat3,
    /// Zero of its program on the part, mm.
    pub(super) zero: DVec3,
    pub(super) tool: Option<usize>,
    pub(super) side: Option<Side>,
    pub(super) gear: Option<GearFlank>,
    /// Of a profile: normals at its points.
    pub(super) normals: Vec<DVec3>,
}

impl Cut {
    /// Leaves at most so many of the ends of a circle's chords.
    pub(super) fn thin(&mut self, most: usize) {
        if self.kind == FeatureKind::Circle && self.circle.is_none() {
            let every = self.points.len().div_ceil(most).max(1);
            self.points = self.points.iter().step_by(every).cloned().collect();
        }
    }

    /// Moves the feature from the coordinates of its set-up's program to those of the part.
    pub(super) fn place(&mut self, to_part: DMat3, zero: DVec3) {
        for point in &mut self.points {
            point.nominal = zero + to_part * point.nominal;
            point.pointing = to_part * point.pointing;
            point.tangent = to_part * point.tangent;
        }
        self.normal = to_part * self.normal;
        if let Some(circle) = &mut self.circle {
            circle.centre = zero + to_part * circle.centre;
        }
        (self.to_part, self.zero) = (to_part, zero);
    }

    /// Whether only the end of a move lies on the feature, as for a chord of a circle or a step over a flank.
    pub(super) fn is_chord(&self, step: &Move) -> bool {
        match self.kind {
            FeatureKind::Circle => self.circle.is_none() && step.keeps_its_curve(),
            kind => kind == FeatureKind::Flank,
        }
    }
}

/// What a run of the servo adds to the commands of the axes, and how far each is in negative travel, 0 to 1.
pub(super) type Followed = [[f64; AXES]; 2];

impl Point {
    /// Moves the axes from the commands by what runs of the servo add to them: uncorrected, corrected and everything on. The
    /// runs are those of a cold machine.
    pub(super) fn follow(&mut self, [uncorrected, corrected, everything]: [Followed; 3]) {
        [self.corrected, self.everything] = [corrected, everything].map(|of| self.after(of));
        let ([errors, reverse], command) = (uncorrected, self.command);
        self.uncorrected = Reached { sent: std::array::from_fn(|axis| command[axis] + errors[axis]), reverse };
    }

    /// Where a run with the correction of the growth brings the axes.
    pub(super) fn after(&self, [errors, reverse]: Followed) -> Reached {
        let sent = std::array::from_fn(|axis| self.command[axis] + errors[axis] + self.warm[axis]);
        Reached { sent, reverse }
    }

    /// With everything on and these figures of the drives.
    fn with_drives(&self, drives: &[f64]) -> Reached {
        let Reached { mut sent, mut reverse } = self.everything;
        for ([by, back], z) in self.drives.iter().zip(drives).filter(|(_, z)| **z != 0.0) {
            sent.iter_mut().zip(by).for_each(|(to, by)| *to += z * by);
            reverse.iter_mut().zip(back).for_each(|(to, by)| *to = (*to + z * by).clamp(0.0, 1.0));
        }
        Reached { sent, reverse }
    }

    /// Error of the point that is cut, in directions of the workpiece's frame, mm; `along`: errors of the axes along themselves;
    /// `drives`: how far the uncertain figures of the drives are off, in standard uncertainties.
    pub(super) fn error<'a>(
        &self,
        machine: &Machine,
        geometry: &Geometry,
        state: State,
        along: impl Iterator<Item = &'a Along>,
        drives: &[f64],
    ) -> DVec3 {
        let reached = match state {
            State::Uncorrected => self.uncorrected,
            State::Corrected => self.corrected,
            State::Everything => self.with_drives(drives),
        };
        let mut sent = reached.sent;
        for one in along {
            let index = one.axis.index();
            sent[index] += one.moves(reached.sent[index], reached.reverse[index]);
        }
        sent.iter_mut().zip(reached.sent).zip(&self.growth).for_each(|((to, at), growth)| *to += growth.at(at));
        let slots = |by_axis| in_order(machine.settings.axes.iter().map(|own| own.axis), by_axis);
        let tip = DVec3::from(geometry.actual_pose(&slots(&sent), &slots(&reached.reverse)).tip_mm);
        tip - self.ideal
    }
}
