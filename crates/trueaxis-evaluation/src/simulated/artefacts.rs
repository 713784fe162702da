//! True positions and sizes of a task's artefacts.
//!
//! Sizes are drawn within the stated standard uncertainty, once per artefact; positions and orientations deviate as in a
//! manual set-up. The result is the true surfaces (blocks, balls and bores), which the solution never sees.

use crate::calibrate::stylus::tool_mm;
use crate::calibrate::{ANGLES, Artefact as Described, Block, Grid, Ideal, Kind, Place, Task, directions};
use anyhow::Result;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;
use trueaxis::machine::Axis;
use trueaxis_sim::calibration::Artefact;
use trueaxis_tables::Machine;

/// Angular error of a square without a stated uncertainty: standard deviation from a right angle, rad.
const UNKNOWN_ANGLE: f64 = 50e-6;
/// Deviation of a block of unknown length: standard deviation, mm.
const UNKNOWN_LENGTH: f64 = 0.02;
/// Places and diameters of a plate of unknown places: standard deviations from the nominal ones, mm.
const UNKNOWN_PLACE: f64 = 0.03;
const UNKNOWN_DIAMETER: f64 = 0.01;
/// Misalignment of such a plate in its plane and across it, over that of an artefact: 2 mrad and 0.1 mrad of 0.5.
const PUT_DOWN: f64 = 4.0;
const FLAT: f64 = 0.2;
/// Share of the other extents that a face of a block has, so that no pair of faces protrudes beyond another.
const OF_THE_FACE: f64 = 0.95;
/// The base of a block, mm: by how much it is wider than the block on every side, and half its thickness.
const BASE: [f64; 2] = [20.0, 5.0];
/// Half the size of a gauge face, along and across it, mm.
const HALF_FACE: f64 = 6.0;
/// Maximum thickness of a gauge's step along the gauge, mm.
const STEP: f64 = 5.0;
/// Width of a square's arm in its plane, and half its thickness, mm.
const ARM: [f64; 2] = [25.0, 8.0];
/// Start of a square's arm, from the corner, as a share of its length, so that neither arm protrudes beyond the other's face.
const RELIEF: f64 = 0.01;

/// Set-up errors of artefacts, standard deviations.
#[derive(Clone, Copy, Debug)]
pub(in crate::simulated) struct SetUp {
    /// Position error in each direction, mm.
    pub(in crate::simulated) misplaced_mm: f64,
    /// Misalignment about each direction, rad.
    pub(in crate::simulated) askew: f64,
}

/// All artefacts on the machine in every set-up of a task: the set-up's own artefact, and the reference in all of them.
pub(in crate::simulated) fn placed(
    task: &Task,
    nominal: &Machine,
    set_up: SetUp,
    normal: &mut impl FnMut() -> f64,
) -> Result<Vec<Vec<Artefact>>> {
    let is_reference = |index: usize| task.reference.as_ref().is_some_and(|reference| reference.artefact == index);
    let mut reference = Vec::new();
    let mut places = Vec::new();
    let mut reals: Vec<Real> = Vec::new();
    for (index, artefact) in task.artefacts.iter().enumerate() {
        let real = Real::new(artefact, &reals, normal);
        for place in &artefact.places {
            let [x, y, z] = place.at_mm;
            let at: [f64; 3] = std::array::from_fn(|k| [x, y, z][k] + set_up.misplaced_mm * normal().clamp(-2.0, 2.0));
            let mut machine = nominal.clone();
            machine.settings.tool_mm = tool_mm(&nominal.settings, place.stylus_mm);
            let tip = Ideal::new(&machine)?.tip(&[at[0], at[1], at[2], 0.0, 0.0, 0.0]).into();
            let surfaces = real.surfaces(place, tip, task.probe.tip_radius_mm, set_up.askew, normal);
            if is_reference(index) {
                reference.clone_from(&surfaces);
            }
            places.push((index, surfaces));
        }
        reals.push(real);
    }
    let with_reference = |(index, surfaces): (usize, Vec<Artefact>)| {
        let also = if is_reference(index) { &[][..] } else { &reference };
        also.iter().copied().chain(surfaces).collect()
    };
    Ok(places.into_iter().map(with_reference).collect())
}

/// The tool in every set-up of a task.
pub(in crate::simulated) fn tools_mm(task: &Task, nominal: &Machine) -> Vec<[f64; 3]> {
    let places = task.artefacts.iter().flat_map(|artefact| &artefact.places);
    places.map(|place| tool_mm(&nominal.settings, place.stylus_mm)).collect()
}

/// An artefact with its true sizes.
enum Real {
    Ring {
        diameter: f64,
    },
    Ball {
        diameter: f64,
    },
    /// Ball centres relative to the first ball's nominal position, along the plate.
    Plate {
        diameter: f64,
        centres: Vec<DVec3>,
    },
    /// Faces relative to the first one's nominal position.
    Gauge {
        faces: Vec<f64>,
        thick: f64,
    },
    Square {
        angle: f64,
        arms: [f64; 2],
    },
    Block(RealBlock),
    Grid(RealGrid),
}

impl Real {
    fn new(artefact: &Described, before: &[Real], normal: &mut impl FnMut() -> f64) -> Real {
        let off = artefact.uncertainty.unwrap_or(UNKNOWN_ANGLE);
        let longer = 1.0 + artefact.length_uncertainty.map_or(0.0, |uncertainty| uncertainty * normal());
        match &artefact.kind {
            Kind::Ring { diameter_mm, .. } => Real::Ring { diameter: diameter_mm + off * normal() },
            Kind::Ball { diameter_mm, .. } => Real::Ball { diameter: diameter_mm + off * normal() },
            Kind::Plate { diameter_mm, balls_mm, .. } => Real::Plate {
                diameter: diameter_mm + off * normal(),
                centres: balls_mm
                    .iter()
                    .map(|centre| DVec3::from(centre.map(|q| longer * q + off * normal())))
                    .collect(),
            },
            Kind::Gauge { steps_mm } => {
                let least = steps_mm.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
                let faces = steps_mm.iter().map(|step| longer * step + off * normal()).collect();
                Real::Gauge { faces, thick: STEP.min(0.25 * least) }
            }
            Kind::Square { angle_deg, arms_mm, .. } => {
                Real::Square { angle: angle_deg.to_radians() + off * normal(), arms: *arms_mm }
            }
            // Without places.
            Kind::Dial(_) => Real::Ball { diameter: 0.0 },
            Kind::Grid(grid) => Real::Grid(RealGrid::new(grid, normal)),
            Kind::Block(block) => {
                let off = artefact.uncertainty.unwrap_or(UNKNOWN_LENGTH);
                Real::Block(RealBlock::new(block, before, (off, longer), normal))
            }
        }
    }

    /// The artefact's surfaces at a place; `tip`: the tip's centre at the artefact's origin, with the set-up's position error.
    fn surfaces(
        &self,
        place: &Place,
        tip: DVec3,
        radius: f64,
        askew: f64,
        normal: &mut impl FnMut() -> f64,
    ) -> Vec<Artefact> {
        match self {
            Real::Grid(grid) => grid.surfaces(place, tip, askew, normal),
            Real::Ball { diameter } => vec![Artefact::Ball { centre: tip, diameter: *diameter }],
            Real::Ring { diameter } => {
                let mut axis: [f64; 3] = std::array::from_fn(|_| askew * normal());
                axis[place.normal.index() % 3] = 1.0;
                vec![Artefact::Ring { centre: tip, axis: DVec3::from(axis).normalize(), diameter: *diameter }]
            }
            Real::Plate { diameter, centres } => {
                let across = match place.normal {
                    Axis::X => [DVec3::Y, DVec3::Z],
                    Axis::Y => [DVec3::Z, DVec3::X],
                    _ => [DVec3::X, DVec3::Y],
                };
                let frame = turned(askew, normal) * DMat3::from_cols(across[0], across[1], unit(place.normal));
                centres
                    .iter()
                    .map(|centre| Artefact::Ball { centre: tip + frame * *centre, diameter: *diameter })
                    .collect()
            }
            Real::Gauge { faces, thick } => {
                let (along, up) = (downwards(place.along), unit(place.normal));
                let frame = turned(askew, normal) * DMat3::from_cols(along, up.cross(along), up);
                let half = DVec3::new(0.5 * thick, HALF_FACE, HALF_FACE);
                let first = tip + radius * along;
                let middle = |face: &f64| first + frame * DVec3::new(face + half.x, 0.0, 0.0);
                faces.iter().map(|face| Artefact::Block { centre: middle(face), directions: frame, half }).collect()
            }
            Real::Square { angle, arms: [first, second] } => {
                let (along, up) = (downwards(place.along), unit(place.normal));
                let across = up.cross(along);
                let across = if across.z > 0.5 { -across } else { across };
                // Turned over about its second arm: a rotation by 180°, not a mirror image.
                let over = if place.reversed { -1.0 } else { 1.0 };
                let frame = turned(askew, normal) * DMat3::from_cols(over * along, across, over * up);
                let [width, thick] = ARM;
                let arm = |to: DVec3, inwards: DVec3, length: f64| {
                    let directions = frame * DMat3::from_cols(to, inwards, DVec3::Z);
                    let middle = tip + frame * (0.5 * (1.0 + RELIEF) * length * to + 0.5 * width * inwards);
                    let half = DVec3::new(0.5 * (1.0 - RELIEF) * length, 0.5 * width, thick);
                    Artefact::Block { centre: middle, directions, half }
                };
                let (sin, cos) = angle.sin_cos();
                vec![
                    arm(DVec3::X, DVec3::Y, *first),
                    arm(DVec3::new(cos, sin, 0.0), DVec3::new(sin, -cos, 0.0), *second),
                ]
            }
            Real::Block(block) => block.surfaces(place, tip - radius * unit(place.normal), turned(askew, normal)),
        }
    }
}

/// A block with its true lengths, and the true normals of its faces in its own directions.
struct RealBlock {
    lengths: [f64; 3],
    normals: [DVec3; 3],
}

impl RealBlock {
    /// Draws lengths within `off` mm, all longer by a factor.
    fn new(block: &Block, before: &[Real], (off, longer): (f64, f64), normal: &mut impl FnMut() -> f64) -> RealBlock {
        let mut lengths = block.size_mm.map(|mm| longer * mm + off * normal());
        if let Some((other, difference)) = block.like
            && let Some(Real::Block(other)) = before.get(other)
        {
            lengths = other.lengths.map(|mm| longer * mm + difference * normal());
        }
        let mut normals = [DVec3::X, DVec3::Y, DVec3::Z];
        if block.measured == 3 {
            for [i, j] in ANGLES {
                normals[j][i] += block.angles.unwrap_or(UNKNOWN_ANGLE) * normal();
            }
        }
        RealBlock { lengths, normals: normals.map(DVec3::normalize) }
    }

    /// Every pair of faces is a block that is smaller across them; the base is a plate. `top`: the middle of the upper face.
    fn surfaces(&self, place: &Place, top: DVec3, askew: DMat3) -> Vec<Artefact> {
        let [axes, senses] = directions(place);
        let mut frame = DMat3::ZERO;
        for pair in 0..3 {
            frame.col_mut(pair)[axes[pair] as usize] = f64::from(senses[pair]);
        }
        let frame = askew * frame;
        let up = axes.iter().position(|axis| *axis as usize == place.normal.index() % 3).unwrap_or(2);
        let upwards = f64::from(senses[up]) * (frame * self.normals[up]);
        let centre = top - 0.5 * self.lengths[up] * upwards;
        let mut surfaces: Vec<Artefact> = (0..3)
            .map(|pair| {
                let directions = beside(frame, pair, frame * self.normals[pair]);
                let extent = |k: usize| 0.5 * self.lengths[k] * if k == pair { 1.0 } else { OF_THE_FACE };
                Artefact::Block { centre, directions, half: DVec3::new(extent(0), extent(1), extent(2)) }
            })
            .collect();
        if place.base {
            let directions = beside(frame, up, upwards);
            let [wider, half] = BASE;
            let centre = top - (self.lengths[up] + half) * upwards;
            let extent = |k: usize| if k == up { half } else { 0.5 * self.lengths[k] + wider };
            let half = DVec3::new(extent(0), extent(1), extent(2));
            surfaces.push(Artefact::Block { centre, directions, half });
        }
        surfaces
    }
}

/// A plate with its true places and diameters.
struct RealGrid {
    holes: bool,
    /// From the plate's middle, along its columns and rows.
    centres: Vec<DVec2>,
    diameters: Vec<f64>,
}

impl RealGrid {
    /// Draws places and diameters; the known length is the stated one within its uncertainty.
    fn new(grid: &Grid, normal: &mut impl FnMut() -> f64) -> RealGrid {
        let mut draw = |size: f64| size * normal();
        let mut centres: Vec<DVec2> = (0..grid.count())
            .map(|ball| DVec2::from(grid.offset(ball)) + DVec2::new(draw(UNKNOWN_PLACE), draw(UNKNOWN_PLACE)))
            .collect();
        let diameters = (0..grid.count()).map(|_| grid.diameter_mm + draw(UNKNOWN_DIAMETER)).collect();
        if let Some([mm, uncertainty]) = grid.length_mm {
            let [from, to] = grid.ends.map(|ball| centres[ball]);
            let scale = (mm + draw(uncertainty)) / from.distance(to);
            centres.iter_mut().for_each(|centre| *centre *= scale);
        }
        RealGrid { holes: grid.holes, centres, diameters }
    }

    fn surfaces(&self, place: &Place, tip: DVec3, askew: f64, normal: &mut impl FnMut() -> f64) -> Vec<Artefact> {
        let up = unit(place.normal);
        let [first, second] = match place.normal {
            Axis::X => [DVec3::Y, DVec3::Z],
            Axis::Y => [DVec3::Z, DVec3::X],
            _ => [DVec3::X, DVec3::Y],
        };
        // A plate lies flat; in its plane it is put down by eye.
        let flat = turned(FLAT * askew, normal);
        let by = PUT_DOWN * askew * normal().clamp(-2.0, 2.0) + 0.5 * PI * f64::from(place.turn);
        let frame = flat * DMat3::from_axis_angle(up, by);
        let at = |centre: &DVec2| tip + frame * (centre.x * first + centre.y * second);
        let surface = |(centre, diameter): (&DVec2, &f64)| match self.holes {
            true => Artefact::Ring { centre: at(centre), axis: frame * up, diameter: *diameter },
            false => Artefact::Ball { centre: at(centre), diameter: *diameter },
        };
        self.centres.iter().zip(&self.diameters).map(surface).collect()
    }
}

/// The frame with one column replaced, and the others at right angles to it.
fn beside(frame: DMat3, column: usize, normal: DVec3) -> DMat3 {
    let [next, last] = [(column + 1) % 3, (column + 2) % 3];
    let mut turned = frame;
    let first = (frame.col(next) - frame.col(next).dot(normal) * normal).normalize();
    *turned.col_mut(column) = normal;
    *turned.col_mut(next) = first;
    *turned.col_mut(last) = normal.cross(first);
    turned
}

fn unit(axis: Axis) -> DVec3 {
    [DVec3::X, DVec3::Y, DVec3::Z][axis.index() % 3]
}

/// Direction of an artefact along an axis; along Z it points down, since an upright artefact is touched from above.
fn downwards(axis: Axis) -> DVec3 {
    if axis == Axis::Z { -DVec3::Z } else { unit(axis) }
}

/// A small random rotation about all three directions.
fn turned(askew: f64, normal: &mut impl FnMut() -> f64) -> DMat3 {
    let by = DVec3::new(normal(), normal(), normal()) * askew;
    DMat3::from_quat(glam::DQuat::from_scaled_axis(by))
}
