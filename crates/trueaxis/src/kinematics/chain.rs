//! Reduces a machine's structural code to two turns and three shifts.

use super::in_frame;
use crate::error::{ConfigError, Field};
use crate::machine::links;
use crate::machine::{Axis, MachineSettings};
use crate::real::Real;
use crate::vector::{About, V3};

/// A second rotary axis must have at least this lever on the tool axis, rad.
const LEAST_LEVER: f64 = 1e-3;

/// A rotary axis in the frame of the workpiece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rotary<R> {
    pub(super) axis: Axis,
    pub(super) about: About,
    /// +1 or −1: sense in which a positive command turns the tool relative to the workpiece.
    pub(super) sense: R,
    pub(super) carries_workpiece: bool,
    /// Travel, degrees.
    pub(super) travel: [R; 2],
}

/// The part between two rotary axes: a constant shift, and the linear axes in it (1 for each one present, else 0).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Section<R> {
    pub(super) offset: V3<R>,
    pub(super) moves: V3<R>,
}

impl<R: Real> Section<R> {
    /// Shift at the positions of X, Y, Z.
    #[inline(always)]
    pub(super) fn shift(&self, travel: V3<R>) -> V3<R> {
        let (k, m) = (self.offset, self.moves);
        V3::new(k.x + m.x * travel.x, k.y + m.y * travel.y, k.z + m.z * travel.z)
    }
}

/// The chain from the workpiece to the tool: section, turn, section, turn, section.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chain<R> {
    pub(super) turns: [Option<Rotary<R>>; 2],
    pub(super) sections: [Section<R>; 3],
    /// Travel of X, Y, Z, mm.
    pub(super) travel: [[R; 2]; 3],
    /// Section that contains all of X, Y and Z, if any.
    pub(super) together: Option<u8>,
    /// Angle of the tool axis about the second rotary axis, measured from the first one, rad: atan2(c, a) of the inverse.
    pub(super) tool_turn: R,
}

impl<R: Real> Chain<R> {
    pub(super) fn new(machine: &MachineSettings, tool_axis: [f64; 3]) -> Result<Self, ConfigError> {
        let mut chain = Chain {
            turns: [None; 2],
            sections: [Section::default(); 3],
            travel: [[R::ZERO; 2]; 3],
            together: None,
            tool_turn: R::ZERO,
        };
        let mut offsets = [V3::<f64>::ZERO; 3];
        let (mut linear, mut rotary) = (0, 0);
        let links = links(&machine.chain)?;
        for link in &links {
            let Some(settings) = machine.axis(link.axis) else {
                let count = machine.axes.len() as f64;
                return Err(ConfigError::new(Field::Axes, count, "every axis that the chain names").on(link.axis));
            };
            if let Some(bad) = settings.offset_mm.iter().find(|value| !value.is_finite()) {
                return Err(ConfigError::new(Field::Offset, *bad, "finite numbers").on(link.axis));
            }
            let travel = settings.travel.map(R::of);
            let offset = V3::of(settings.offset_mm);
            // On the workpiece side the carrier lies behind the axis, and the transformation goes back through it.
            let offset = if link.carries_workpiece { -offset } else { offset };
            let about = match link.axis {
                Axis::X | Axis::Y | Axis::Z => {
                    let here = if let Some(section) = chain.sections.get_mut(rotary) { section } else { continue };
                    let component = match link.axis {
                        Axis::X => &mut here.moves.x,
                        Axis::Y => &mut here.moves.y,
                        _ => &mut here.moves.z,
                    };
                    *component = R::ONE;
                    if let Some(place) = chain.travel.get_mut(link.axis.index()) {
                        *place = travel;
                    }
                    if let Some(sum) = offsets.get_mut(rotary) {
                        *sum += offset;
                    }
                    linear += 1;
                    continue;
                }
                Axis::A => About::X,
                Axis::B => About::Y,
                Axis::C => About::Z,
            };
            let direction = f64::from(settings.direction);
            if direction.abs() != 1.0 {
                return Err(ConfigError::new(Field::Direction, direction, "1 or -1").on(link.axis));
            }
            let Some(turn) = chain.turns.get_mut(rotary) else {
                return Err(ConfigError::new(Field::Chain, 3.0, "at most two rotary axes").on(link.axis));
            };
            let sense = R::of(if link.carries_workpiece { -direction } else { direction });
            *turn = Some(Rotary { axis: link.axis, about, sense, carries_workpiece: link.carries_workpiece, travel });
            // p = Rot⁻¹(p − o) on the workpiece side: the offset lies behind the turn; Rot(p) + o on the tool side: before.
            let place = if link.carries_workpiece { rotary + 1 } else { rotary };
            if let Some(sum) = offsets.get_mut(place) {
                *sum += offset;
            }
            rotary += 1;
        }
        if linear < 3 {
            let needed = "X, Y and Z in the chain: three linear axes hold the tip in place";
            return Err(ConfigError::new(Field::Chain, f64::from(linear), needed));
        }
        if let [_, Some(second)] = chain.turns {
            let [x, y, z] = tool_axis;
            let lever = match second.about {
                About::X => y * y + z * z,
                About::Y => x * x + z * z,
                About::Z => x * x + y * y,
            };
            if lever < LEAST_LEVER * LEAST_LEVER {
                let needed = "a tool_axis that the rotary axis nearest the tool can turn, not one along it";
                return Err(ConfigError::new(Field::ToolAxis, libm::sqrt(lever), needed).on(second.axis));
            }
        }
        for (number, (section, offset)) in (0..).zip(chain.sections.iter_mut().zip(offsets)) {
            section.offset = V3::of(offset.array());
            if section.moves == V3::new(R::ONE, R::ONE, R::ONE) {
                chain.together = Some(number);
            }
        }
        if let [Some(first), Some(second)] = &chain.turns {
            let [a, _, c] =
                in_frame(first.about, second.about, V3::<f64> { x: tool_axis[0], y: tool_axis[1], z: tool_axis[2] });
            chain.tool_turn = R::of(libm::atan2(c, a));
        }
        Ok(chain)
    }
}
