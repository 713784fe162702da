//! The kinematic chain as the step traverses it: poses of the rotary axes, directions of all axes in the bed.

#![deny(clippy::indexing_slicing)]

use crate::compensation::trig::cos_sin_deg;
use crate::error::{ConfigError, Field};
use crate::machine::{Axis, AxisOrder, AxisSettings, Link, MachineSettings, links};
use crate::real::Real;
use crate::vector::{About, V3};

/// An axis in the chain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carriage<R> {
    pub(super) axis: Axis,
    /// Whether its errors act where its travel starts, not where it ends: see [`Carriages::build`].
    pub(super) fixed: bool,
    /// Slot of the axis.
    pub(super) slot: usize,
    /// Sense of its motion for a positive command: −1 for a slide that carries the workpiece; for a rotary axis its
    /// direction.
    pub(super) motion: R,
    /// Origin of a rotary axis' frame in its carrier's frame. A slide has none: see [`Carriages::build`].
    pub(super) offset: V3<R>,
    /// Whether the offset is not zero.
    pub(super) is_offset: bool,
    /// Position of its table's origin from machine zero.
    origin: R,
}

/// Both sides of the bed, each from its outermost axis inwards.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carriages<R, const N: usize> {
    carriages: [Option<Carriage<R>>; N],
    /// Number of carriages that carry the workpiece.
    workpiece: usize,
    /// Tool tip from the last tool-side frame; zero for three slides, whose tables include it.
    pub(super) tool: V3<R>,
    /// Unit vector along the tool, all axes at zero.
    tool_axis: V3<R>,
    /// Whether a rotary axis carries a slide, so that the slides' corrections are not along the bed's axes.
    pub(super) turned: bool,
    /// For each axis, 1 for the slides X, Y, Z between its frame and the tool.
    pub(super) beyond: [[R; 3]; N],
    /// Which of X, Y, Z exist.
    pub(super) present: [bool; 3],
}

/// Cosine and sine of each rotary axis' nominal rotation; slides have (1, 0).
pub(super) type Poses<R, const N: usize> = [(R, R); N];

/// Machine direction along or about which an axis moves.
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

/// `(I − Rot(angle · n)) y` to second order in a small angle, rad, without subtracting two near-equal vectors.
fn turned_back<R: Real>(n: V3<R>, angle: R, y: V3<R>) -> V3<R> {
    let once = n.cross(y) * angle;
    -once - n.cross(once) * (angle * R::HALF)
}

impl<R: Real> Carriage<R> {
    fn new(link: Link, settings: &AxisSettings, slot: usize) -> Self {
        let rotary = link.axis.is_rotary();
        let motion = match (rotary, link.carries_workpiece) {
            (true, _) => f64::from(settings.direction),
            (false, true) => -1.0,
            (false, false) => 1.0,
        };
        Carriage {
            axis: link.axis,
            // A workpiece slide measured along a line: the reading contains the lever of its travel.
            fixed: !rotary && link.carries_workpiece && settings.is_measured_along_a_line(),
            slot,
            motion: R::of(motion),
            offset: V3::ZERO,
            is_offset: false,
            origin: R::ZERO,
        }
    }
}

impl<R: Real, const N: usize> Carriages<R, N> {
    /// The carriages and, for every axis, the constant lever that its table carries.
    ///
    /// Slides do not turn, so the offsets of the slides between two rotary axes act as one, at the outer end of that run:
    /// in the next rotary axis' offset or the tool (without rotary axes the tool too is in the tables). Their
    /// contribution to the lever of a slide's own twist is constant and goes into its table, together with the line along
    /// which it was measured.
    pub(super) fn build(order: &AxisOrder<N>, machine: &MachineSettings) -> Result<(Self, [[f64; 3]; N]), ConfigError> {
        let found = links(&machine.chain)?;
        let axis = machine.kinematics.tool_axis;
        let length = libm::sqrt(axis.iter().map(|x| x * x).sum());
        let mut chain = Carriages {
            carriages: [None; N],
            workpiece: found.iter().filter(|link| link.carries_workpiece).count(),
            tool: V3::ZERO,
            tool_axis: V3::of(axis.map(|x| x / length)),
            turned: false,
            beyond: [[R::ZERO; 3]; N],
            present: [false; 3],
        };
        let mut levers = [[0.0; 3]; N];
        for (index, link) in found.iter().enumerate() {
            let needed = "only axes that the machine has";
            let absent = ConfigError::new(Field::Chain, index as f64, needed).on(link.axis);
            let settings = machine.axis(link.axis).ok_or(absent)?;
            let slot = order.slot(link.axis).ok_or(absent)?;
            let carriage = Carriage::new(*link, settings, slot);
            if let Some(lever) = levers.get_mut(slot) {
                *lever = chain.add(carriage, &found, index, settings);
            }
        }
        chain.add_offsets(machine, &mut levers);
        Ok((chain, levers))
    }

    /// Inserts the axis at `index` of the structural code `found`; returns the constant part of its lever at the point of
    /// measurement.
    fn add(&mut self, carriage: Carriage<R>, found: &[Link], index: usize, settings: &AxisSettings) -> [f64; 3] {
        let Carriage { axis, fixed, slot, .. } = carriage;
        let on_workpiece = index < self.workpiece;
        // The workpiece side is in code order, from the workpiece to the bed; the tool side is reversed, from the tool to
        // the bed.
        let position = if on_workpiece { index } else { self.workpiece + found.len() - 1 - index };
        if let Some(entry) = self.carriages.get_mut(position) {
            *entry = Some(carriage);
        }
        if let Some(present) = self.present.get_mut(slot) {
            *present = !axis.is_rotary();
        }
        let mut lever = [0.0; 3];
        let Some(slides) = self.beyond.get_mut(slot) else { return lever };
        // The slide's own travel lies between its moved frame and the tool.
        if !axis.is_rotary()
            && on_workpiece
            && !fixed
            && let Some(slide) = slides.get_mut(axis.index())
        {
            *slide = R::ONE;
        }
        for beyond in found.iter().skip(index + 1).filter(|beyond| !beyond.axis.is_rotary()) {
            let axis = beyond.axis.index();
            if let Some(slide) = slides.get_mut(axis) {
                *slide = R::ONE;
            }
            if let (Some(lever), Some(measured)) = (lever.get_mut(axis), settings.measured_at_mm.get(axis)) {
                *lever += measured;
            }
        }
        lever
    }

    /// Sums the offsets of every run of slides: see [`Carriages::build`].
    fn add_offsets(&mut self, machine: &MachineSettings, levers: &mut [[f64; 3]; N]) {
        let mut run = [0.0; 3];
        let (before, behind) = self.carriages.split_at_mut(self.workpiece);
        for side in [before, behind] {
            run = [0.0; 3];
            let mut carried_by_rotary = false;
            for carriage in side.iter_mut().rev().flatten() {
                let offset = machine.axis(carriage.axis).map_or([0.0; 3], |s| s.offset_mm);
                for (run, offset) in run.iter_mut().zip(offset) {
                    *run += offset;
                }
                if carriage.axis.is_rotary() {
                    carriage.offset = V3::of(run);
                    carriage.is_offset = run != [0.0; 3];
                    (run, carried_by_rotary) = ([0.0; 3], true);
                } else {
                    for (lever, run) in levers.get_mut(carriage.slot).into_iter().flatten().zip(run) {
                        *lever += run;
                    }
                    self.turned |= carried_by_rotary;
                }
            }
        }
        let [x, y, z] = run;
        let [tx, ty, tz] = machine.tool_mm;
        let tool = [x + tx, y + ty, z + tz];
        if N == 3 {
            // Without rotary axes it is a constant part common to all levers.
            for (lever, tool) in levers.iter_mut().flat_map(|lever| lever.iter_mut().zip(tool)) {
                *lever -= tool;
            }
        } else {
            self.tool = V3::of(tool);
        }
    }

    /// Whether a slide's own travel lengthens its lever.
    pub(super) fn carries_itself(&self) -> bool {
        self.beyond.iter().enumerate().any(|(slot, slides)| slides.get(slot).is_some_and(|there| *there != R::ZERO))
    }

    /// Sets the origin of the table of the axis at `slot`, from machine zero.
    pub(super) fn set_origin(&mut self, slot: usize, origin: f64) {
        for carriage in self.carriages.iter_mut().flatten().filter(|carriage| carriage.slot == slot) {
            carriage.origin = R::of(origin);
        }
    }

    /// The axes that carry the workpiece, from the workpiece to the bed.
    #[inline(always)]
    pub(super) fn workpiece_side(&self) -> impl DoubleEndedIterator<Item = &Carriage<R>> {
        self.carriages.get(..self.workpiece).unwrap_or(&[]).iter().flatten()
    }

    /// The axes that carry the tool, from the tool to the bed.
    #[inline(always)]
    pub(super) fn tool_side(&self) -> impl DoubleEndedIterator<Item = &Carriage<R>> {
        self.carriages.get(self.workpiece..).unwrap_or(&[]).iter().flatten()
    }

    /// The axes of one side, from its outer end to the bed.
    #[inline(always)]
    pub(super) fn side(&self, tool: bool) -> impl Iterator<Item = &Carriage<R>> {
        let (workpiece, of_tool) = self.carriages.split_at_checked(self.workpiece).unwrap_or((&[], &[]));
        if tool { of_tool } else { workpiece }.iter().flatten()
    }

    /// Cosine and sine of the rotary axes at a position in table coordinates.
    #[inline(always)]
    pub(super) fn poses(&self, at: &[R; N]) -> Poses<R, N> {
        let mut poses = [(R::ONE, R::ZERO); N];
        for carriage in self.carriages.iter().flatten().filter(|carriage| carriage.axis.is_rotary()) {
            if let (Some(pose), Some(at)) = (poses.get_mut(carriage.slot), at.get(carriage.slot)) {
                *pose = cos_sin_deg((*at + carriage.origin) * carriage.motion);
            }
        }
        poses
    }

    /// Unit vectors in the bed along which each axis moves the tool relative to the workpiece (for a rotary axis: about
    /// which it turns the tool), and the tool axis.
    pub(super) fn directions(&self, poses: &Poses<R, N>) -> ([V3<R>; N], V3<R>) {
        let mut directions = [V3::ZERO; N];
        let mut tool_axis = self.tool_axis;
        for (tool_side, index) in (0..self.workpiece).map(|i| (false, i)).chain((self.workpiece..N).map(|i| (true, i)))
        {
            let Some(Some(carriage)) = self.carriages.get(index) else { continue };
            let own = if carriage.axis.is_rotary() {
                let pose = poses.get(carriage.slot).copied().unwrap_or((R::ONE, R::ZERO));
                // Axes further out on the same side.
                let first = if tool_side { self.workpiece } else { 0 };
                for outer in self.carriages.get(first..index).unwrap_or(&[]).iter().flatten() {
                    if let Some(direction) = directions.get_mut(outer.slot) {
                        *direction = direction.turned(about(carriage.axis), pose);
                    }
                }
                if tool_side {
                    tool_axis = tool_axis.turned(about(carriage.axis), pose);
                }
                unit(carriage.axis) * if tool_side { carriage.motion } else { -carriage.motion }
            } else {
                unit(carriage.axis)
            };
            if let Some(direction) = directions.get_mut(carriage.slot) {
                *direction = own;
            }
        }
        (directions, tool_axis)
    }

    /// Motion of the tip relative to the workpiece when the rotary axes are `turned_deg` beyond `command`, mm in bed axes
    /// at their present pose. To third order in the rotations.
    pub(super) fn moved_tip(&self, command: &[R; N], poses: &Poses<R, N>, turned_deg: &[R; N]) -> V3<R> {
        let of = |carriage: &Carriage<R>| {
            let pose = poses.get(carriage.slot).copied().unwrap_or((R::ONE, R::ZERO));
            let turn = turned_deg.get(carriage.slot).copied().unwrap_or(R::ZERO);
            (pose, turn * carriage.motion * R::of(core::f64::consts::PI / 180.0))
        };
        let travel = |carriage: &Carriage<R>| {
            unit(carriage.axis)
                * ((command.get(carriage.slot).copied().unwrap_or(R::ZERO) + carriage.origin) * carriage.motion)
        };
        let (mut point, mut moved) = (self.tool, V3::ZERO);
        for carriage in self.tool_side() {
            if carriage.axis.is_rotary() {
                let (pose, turn) = of(carriage);
                moved += turned_back(unit(carriage.axis), -turn, point - moved);
                moved = moved.turned(about(carriage.axis), pose);
                point = point.turned(about(carriage.axis), pose) + carriage.offset;
            } else {
                point += travel(carriage);
            }
        }
        for carriage in self.workpiece_side().rev() {
            if carriage.axis.is_rotary() {
                let ((cos, sin), turn) = of(carriage);
                point -= carriage.offset;
                moved += turned_back(unit(carriage.axis), turn, point - moved);
                moved = moved.turned(about(carriage.axis), (cos, -sin));
                point = point.turned(about(carriage.axis), (cos, -sin));
            } else {
                point -= travel(carriage);
            }
        }
        for carriage in self.workpiece_side().filter(|carriage| carriage.axis.is_rotary()) {
            let (pose, _) = of(carriage);
            moved = moved.turned(about(carriage.axis), pose);
        }
        moved
    }
}
