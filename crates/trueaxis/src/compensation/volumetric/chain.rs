//! The kinematic chain as the step walks it: poses of the rotary axes, directions of all axes in the bed.

#![deny(clippy::indexing_slicing)]

use crate::compensation::trig::cos_sin_deg;
use crate::error::{ConfigError, Field};
use crate::machine::{Axis, MachineSettings};
use crate::real::Real;
use crate::vector::{About, V3};

/// An axis in its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link<R> {
    pub(super) axis: Axis,
    /// Its errors act where its travel starts, not where it ends: see [`Chain::build`].
    pub(super) fixed: bool,
    /// Its place among the step's axes.
    pub(super) place: usize,
    /// Sense of its motion for a positive command: −1 for a slide that carries the workpiece, a rotary axis' direction.
    pub(super) motion: R,
    /// Origin of a rotary axis' frame in its carrier's. A slide has none: see [`Chain::build`].
    pub(super) offset: V3<R>,
    /// It is not zero.
    pub(super) is_offset: bool,
    /// Position of its table's origin from machine zero.
    origin: R,
}

/// Both sides of the bed, each from its outermost axis inwards.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chain<R, const N: usize> {
    links: [Option<Link<R>>; N],
    /// How many of them carry the workpiece.
    workpiece: usize,
    /// Tool tip from the last tool-side frame.
    pub(super) tool: V3<R>,
    /// Unit vector along the tool, all axes at zero.
    tool_axis: V3<R>,
    /// A rotary axis carries a slide: corrections of the slides are not along the bed's axes.
    pub(super) turned: bool,
    /// Of each axis 1 for the slides X, Y, Z that stand between its frame and the tool.
    pub(super) beyond: [[R; 3]; N],
    /// Which of X, Y, Z the machine has.
    pub(super) present: [bool; 3],
}

/// Cosine and sine of each rotary axis' nominal turn; slides have (1, 0).
pub(super) type Poses<R, const N: usize> = [(R, R); N];

/// What direction a rotary axis turns about.
#[inline(always)]
pub(super) fn about(axis: Axis) -> About {
    match axis {
        Axis::X | Axis::A => About::X,
        Axis::Y | Axis::B => About::Y,
        Axis::Z | Axis::C => About::Z,
    }
}

fn unit<R: Real>(axis: Axis) -> V3<R> {
    match about(axis) {
        About::X => V3::new(R::ONE, R::ZERO, R::ZERO),
        About::Y => V3::new(R::ZERO, R::ONE, R::ZERO),
        About::Z => V3::new(R::ZERO, R::ZERO, R::ONE),
    }
}

/// `(I − Rot(angle · n)) y` to second order in a small angle, rad, without the difference of two near vectors.
fn turned_back<R: Real>(n: V3<R>, angle: R, y: V3<R>) -> V3<R> {
    let once = n.cross(y) * angle;
    -once - n.cross(once) * (angle * R::HALF)
}

impl<R: Real, const N: usize> Chain<R, N> {
    /// The chain and, for every axis, the constant lever that its table carries.
    ///
    /// Slides do not turn, so the offsets of the slides between two rotary axes act as one, at the outer end of that
    /// run: in the next rotary axis' offset or the tool. What they would have added to the lever of a slide's own twist
    /// is constant and goes into its table, beside the line along which it was measured.
    pub(super) fn build(machine: &MachineSettings, axes: &[Axis; N]) -> Result<(Self, [[f64; 3]; N]), ConfigError> {
        let found = crate::machine::links(&machine.chain)?;
        let workpiece = found.iter().filter(|link| link.carries_workpiece).count();
        let mut levers = [[0.0; 3]; N];
        let mut chain = Chain {
            links: [None; N],
            workpiece,
            tool: V3::ZERO,
            tool_axis: V3::ZERO,
            turned: false,
            beyond: [[R::ZERO; 3]; N],
            present: [false; 3],
        };
        for (index, link) in found.iter().enumerate() {
            let needed = "only axes that the machine has";
            let absent = ConfigError::new(Field::Chain, index as f64, needed).on(link.axis);
            let settings = machine.axes.iter().find(|a| a.axis == link.axis).ok_or(absent)?;
            let place = axes.iter().position(|a| *a == link.axis).ok_or(absent)?;
            let rotary = link.axis.is_rotary();
            let sense = match (rotary, link.carries_workpiece) {
                (true, _) => f64::from(settings.direction),
                (false, true) => -1.0,
                (false, false) => 1.0,
            };
            // A slide that carries the workpiece, measured along a line: the reading contains the lever of its travel.
            let fixed = !rotary && link.carries_workpiece && settings.is_measured_along_a_line();
            let built = Link {
                fixed,
                axis: link.axis,
                place,
                motion: R::of(sense),
                offset: V3::ZERO,
                is_offset: false,
                origin: R::ZERO,
            };
            // From the workpiece to the bed as they stand; from the tool to the bed is the code backwards.
            let slot = if link.carries_workpiece { index } else { workpiece + found.len() - 1 - index };
            if let Some(slot) = chain.links.get_mut(slot) {
                *slot = Some(built);
            }
            if let Some(present) = chain.present.get_mut(place) {
                *present = !rotary;
            }
            let beyond = found.iter().skip(index + 1).filter(|beyond| !beyond.axis.is_rotary());
            if let (Some(lever), Some(slides)) = (levers.get_mut(place), chain.beyond.get_mut(place)) {
                // Its own travel lies between the frame that it moves and the tool.
                if !rotary
                    && link.carries_workpiece
                    && !fixed
                    && let Some(slide) = slides.get_mut(link.axis.index())
                {
                    *slide = R::ONE;
                }
                for axis in beyond.map(|beyond| beyond.axis.index()) {
                    if let Some(slide) = slides.get_mut(axis) {
                        *slide = R::ONE;
                    }
                    if let (Some(lever), Some(measured)) = (lever.get_mut(axis), settings.measured_at_mm.get(axis)) {
                        *lever += measured;
                    }
                }
            }
        }
        let mut run = [0.0; 3];
        let (before, behind) = chain.links.split_at_mut(workpiece);
        for side in [before, behind] {
            run = [0.0; 3];
            let mut carried_by_rotary = false;
            for link in side.iter_mut().rev().flatten() {
                let settings = machine.axes.iter().find(|a| a.axis == link.axis);
                let offset = settings.map_or([0.0; 3], |s| s.offset_mm);
                for (run, offset) in run.iter_mut().zip(offset) {
                    *run += offset;
                }
                if link.axis.is_rotary() {
                    link.offset = V3::of(run);
                    link.is_offset = run != [0.0; 3];
                    (run, carried_by_rotary) = ([0.0; 3], true);
                } else {
                    for (lever, run) in levers.get_mut(link.place).into_iter().flatten().zip(run) {
                        *lever += run;
                    }
                    chain.turned |= carried_by_rotary;
                }
            }
        }
        let [x, y, z] = run;
        let [tx, ty, tz] = machine.tool_mm;
        chain.tool = V3::of([x + tx, y + ty, z + tz]);
        let axis = machine.kinematics.tool_axis;
        let length = libm::sqrt(axis.iter().map(|x| x * x).sum());
        chain.tool_axis = V3::of(axis.map(|x| x / length));
        Ok((chain, levers))
    }

    /// Tells the axis at a place its table's origin, from machine zero.
    pub(super) fn set_origin(&mut self, place: usize, origin: f64) {
        for link in self.links.iter_mut().flatten().filter(|link| link.place == place) {
            link.origin = R::of(origin);
        }
    }

    /// The axes that carry the workpiece, from the workpiece to the bed.
    #[inline(always)]
    pub(super) fn workpiece_side(&self) -> impl DoubleEndedIterator<Item = &Link<R>> {
        self.links.get(..self.workpiece).unwrap_or(&[]).iter().flatten()
    }

    /// The axes that carry the tool, from the tool to the bed.
    #[inline(always)]
    pub(super) fn tool_side(&self) -> impl DoubleEndedIterator<Item = &Link<R>> {
        self.links.get(self.workpiece..).unwrap_or(&[]).iter().flatten()
    }

    /// The rotary axes' turns at a position in table coordinates.
    #[inline(always)]
    pub(super) fn poses(&self, at: &[R; N]) -> Poses<R, N> {
        let mut poses = [(R::ONE, R::ZERO); N];
        for link in self.links.iter().flatten().filter(|link| link.axis.is_rotary()) {
            if let (Some(pose), Some(at)) = (poses.get_mut(link.place), at.get(link.place)) {
                *pose = cos_sin_deg((*at + link.origin) * link.motion);
            }
        }
        poses
    }

    /// Direction in the bed in which each axis moves the tool relative to the workpiece: unit vectors, of a rotary axis
    /// the one it turns the tool about; and the tool axis.
    pub(super) fn directions(&self, poses: &Poses<R, N>) -> ([V3<R>; N], V3<R>) {
        let mut directions = [V3::ZERO; N];
        let mut tool_axis = self.tool_axis;
        for (tool_side, index) in (0..self.workpiece).map(|i| (false, i)).chain((self.workpiece..N).map(|i| (true, i)))
        {
            let Some(Some(link)) = self.links.get(index) else { continue };
            let own = if link.axis.is_rotary() {
                let pose = poses.get(link.place).copied().unwrap_or((R::ONE, R::ZERO));
                // What stands further out on the same side.
                let first = if tool_side { self.workpiece } else { 0 };
                for outer in self.links.get(first..index).unwrap_or(&[]).iter().flatten() {
                    if let Some(direction) = directions.get_mut(outer.place) {
                        *direction = direction.turned(about(link.axis), pose);
                    }
                }
                if tool_side {
                    tool_axis = tool_axis.turned(about(link.axis), pose);
                }
                unit(link.axis) * if tool_side { link.motion } else { -link.motion }
            } else {
                unit(link.axis)
            };
            if let Some(direction) = directions.get_mut(link.place) {
                *direction = own;
            }
        }
        (directions, tool_axis)
    }

    /// How far the tip has moved relative to the workpiece because the rotary axes stand `turned_deg` further than at
    /// `command`, mm in bed axes at the pose where they stand now. To third order in the turns.
    pub(super) fn moved_tip(&self, command: &[R; N], poses: &Poses<R, N>, turned_deg: &[R; N]) -> V3<R> {
        let of = |link: &Link<R>| {
            let pose = poses.get(link.place).copied().unwrap_or((R::ONE, R::ZERO));
            let turn = turned_deg.get(link.place).copied().unwrap_or(R::ZERO);
            (pose, turn * link.motion * R::of(core::f64::consts::PI / 180.0))
        };
        let travel = |link: &Link<R>| {
            unit(link.axis) * ((command.get(link.place).copied().unwrap_or(R::ZERO) + link.origin) * link.motion)
        };
        let (mut point, mut moved) = (self.tool, V3::ZERO);
        for link in self.tool_side() {
            if link.axis.is_rotary() {
                let (pose, turn) = of(link);
                moved += turned_back(unit(link.axis), -turn, point - moved);
                moved = moved.turned(about(link.axis), pose);
                point = point.turned(about(link.axis), pose) + link.offset;
            } else {
                point += travel(link);
            }
        }
        for link in self.workpiece_side().rev() {
            if link.axis.is_rotary() {
                let ((cos, sin), turn) = of(link);
                point -= link.offset;
                moved += turned_back(unit(link.axis), turn, point - moved);
                moved = moved.turned(about(link.axis), (cos, -sin));
                point = point.turned(about(link.axis), (cos, -sin));
            } else {
                point -= travel(link);
            }
        }
        for link in self.workpiece_side().filter(|link| link.axis.is_rotary()) {
            let (pose, _) = of(link);
            moved = moved.turned(about(link.axis), pose);
        }
        moved
    }
}
