//! Errors on a grid over two or three linear axes: multilinear between the nodes, added to either model.
//!
//! In a cell of the grid, with t = 0 … 1 along each of its axes and v the values at the corners,
//!
//! ```text
//! E = Σ over i, j, k in {0, 1} of  v_ijk  u_i(t_x) u_j(t_y) u_k(t_z)          u_0(t) = 1 − t, u_1(t) = t
//! ```
//!
//! The sum is continuous and exact for affine functions; beyond the first and the last node of an axis it has the edge
//! value. The nodes, 16-bit numbers, are read where the compiled file stores them. A fading grid has full weight up to
//! a height h1, none from h2 on, and a linearly decreasing weight between.
//!
//! **Rotations.** The translations e of a node are the errors of the tip of a tool of length zero, with the axes of the
//! grid at the node, the other linear axes at `measured_at_mm` and the rotary axes at zero. The rotations w turn the
//! tool's side of the machine about that point p_m, so that the tip p has
//!
//! ```text
//! d = e + w × (p − p_m)          orientation = w
//! ```
//!
//! The lever p − p_m consists of the tool and of the travel of those tool-carrying slides that the grid does not span.
//! The nine-term form has no levers and omits w.

#![deny(clippy::indexing_slicing)]

mod along;
mod cell;
mod cycle;
mod near;
#[cfg(test)]
mod tests;

use crate::compensation::key::Key;
use crate::machine::{Axis, GRIDS, GridData, MachineSettings, links};
use crate::part::{self, Presence};
use crate::real::Real;
use crate::vector::V3;
use cell::Cells;
pub(crate) use cycle::CycleGrids;
pub(crate) use near::{Near, NearGrids, Side};

/// Number of linear axes; grids span only these.
const LINEAR: usize = 3;

/// Largest error, mm, that a box may have beyond a node; [`MOST_OVERLAP_MM`] limits how far it extends.
const OVERLAP_MM: f64 = 0.1e-6;
const MOST_OVERLAP_MM: f64 = 0.02;
/// Largest travel of a slide, mm, in the lever that limits the overlap.
const LONGEST_MM: f64 = 2000.0;

/// Sum of all grids at a position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sum<R> {
    /// Error of the tip, mm.
    pub(crate) tip: V3<R>,
    /// Rotation of the tool, rad.
    pub(crate) turn: V3<R>,
    /// One bit for every axis beyond the nodes of a grid.
    pub(crate) edge: u8,
}

impl<R: Real> Sum<R> {
    fn nothing() -> Self {
        Sum { tip: V3::ZERO, turn: V3::ZERO, edge: 0 }
    }
}

/// Heights between which a grid fades.
#[derive(Clone, Copy, Debug)]
struct Fade<R> {
    whole: R,
    none: R,
    /// Per mm.
    rate: R,
}

impl<R: Real> Fade<R> {
    #[inline(always)]
    fn weight(&self, height: R) -> R {
        ((self.none - height) * self.rate).limit(R::ZERO, R::ONE)
    }
}

/// One grid.
#[derive(Clone, Copy, Debug)]
struct Grid<'a, R> {
    cells: Cells<'a, R>,
    fade: Option<Fade<R>>,
    /// Whether it has rotations that reach the tip.
    turns: bool,
    /// Extension of a box beyond a node, mm.
    overlap: R,
    /// Lever from the point where the translations are valid to the tip if only X, Y, Z move it: `lever` + `along` ·
    /// (X, Y, Z).
    lever: V3<R>,
    along: [R; LINEAR],
    /// The point where the translations are valid: `held` + `moves` · (X, Y, Z).
    held: V3<R>,
    moves: [R; LINEAR],
}

/// The grids of a machine in the form for the step: immutable, built once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grids<'a, R> {
    grids: [Option<Grid<'a, R>>; GRIDS],
    /// Whether one of them has rotations that reach the tip.
    turns: bool,
    /// Whether a rotary axis turns the lever of their rotations.
    swings: bool,
    key: u64,
    part: part::Grids,
}

/// Selects the slides that move the tip but that the grid does not span.
fn along_of(on_tool: &[f64; LINEAR], moves: &[f64; LINEAR]) -> [f64; LINEAR] {
    let mut along = *on_tool;
    for (along, moves) in along.iter_mut().zip(moves) {
        *along -= moves;
    }
    along
}

/// Extension of a box beyond a node, mm, with which the jump of the slopes causes at most [`OVERLAP_MM`] of error;
/// rotations act through a lever of `longest` mm.
fn overlap(data: &GridData<'_>, longest: f64) -> f64 {
    let slopes = data.extremes().slopes;
    let mut square = 0.0;
    for (component, slopes) in slopes.iter().enumerate() {
        let reach = if component < 3 { 1.0 } else { longest };
        square += slopes.iter().map(|slope| slope * slope * reach * reach).sum::<f64>();
    }
    // At a border a slope may change to its opposite.
    let jump = 2.0 * libm::sqrt(square);
    if jump * MOST_OVERLAP_MM > OVERLAP_MM { OVERLAP_MM / jump } else { MOST_OVERLAP_MM }
}

/// The axes that move the tip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reach {
    /// Three slides.
    Slides,
    /// Rotary axes too.
    Tip,
}

// Only with grids.
impl<'a, R: Real> Grids<'a, R> {
    /// Builds the grids of a machine, which stay where they are stored; `None` if it has no grids.
    ///
    /// The grids must have passed [`crate::check::grids`]; otherwise their values are meaningless.
    pub(crate) fn build(machine: &MachineSettings, grids: &[GridData<'a>]) -> Option<Self> {
        if grids.is_empty() {
            return None;
        }
        let part = part::GRIDS?;
        let links = links(&machine.chain).unwrap_or_default();
        let volumetric = machine.compensation.is_volumetric();
        let carries_tool = |axis: usize| {
            let own = |axis: Axis| axis.index();
            links.iter().any(|link| own(link.axis) == axis && !link.carries_workpiece)
        };
        let on_tool: [f64; LINEAR] = core::array::from_fn(|axis| f64::from(u8::from(carries_tool(axis))));
        let mut offsets = [0.0; 3];
        for link in links.iter().filter(|link| !link.carries_workpiece) {
            let own = machine.axis(link.axis).map_or([0.0; 3], |settings| settings.offset_mm);
            for (sum, own) in offsets.iter_mut().zip(own) {
                *sum += own;
            }
        }
        let mut built = Grids { grids: [None; GRIDS], turns: false, swings: false, key: 0, part };
        let mut key = Key(u64::from(volumetric));
        for (place, data) in built.grids.iter_mut().zip(grids) {
            let header = data.header();
            let turns = volumetric && header.given >> 3 != 0;
            let over: [bool; LINEAR] = core::array::from_fn(|k| header.axes.get(k).is_some_and(|axis| axis.is_there()));
            let of = |k: usize, numbers: &[f64; 3]| numbers.get(k).copied().unwrap_or(0.0);
            let moves: [f64; LINEAR] =
                core::array::from_fn(|k| if over.get(k) == Some(&true) { of(k, &on_tool) } else { 0.0 });
            let measured = |k: usize| (of(k, &on_tool) - of(k, &moves)) * of(k, &header.measured_at_mm);
            let held: [f64; 3] = core::array::from_fn(|k| of(k, &offsets) + measured(k));
            let lever: [f64; 3] = core::array::from_fn(|k| of(k, &machine.tool_mm) - measured(k));
            built.turns |= turns;
            let way = along_of(&on_tool, &moves).iter().sum::<f64>() * LONGEST_MM;
            let longest = libm::sqrt(lever.iter().map(|x| x * x).sum()) + way;
            *place = Some(Grid {
                cells: Cells::new(data, volumetric),
                fade: header.fade.map(|[whole, none]| Fade {
                    whole: R::of(whole),
                    none: R::of(none),
                    rate: R::of(1.0 / (none - whole)),
                }),
                turns,
                overlap: R::of(overlap(data, if turns { longest } else { 0.0 })),
                lever: V3::of(lever),
                along: along_of(&on_tool, &moves).map(R::of),
                held: V3::of(held),
                moves: moves.map(R::of),
            });
            key.add_all(&header.scales);
            key.add_all(&header.measured_at_mm);
            key.add_all(&header.fade.unwrap_or([f64::NAN; 2]));
            for (along, stored) in header.axes.iter().zip((0..LINEAR).map(|axis| data.stored(axis))) {
                key.add(u64::from(along.nodes));
                key.add_all(&along.ends);
                key.add_bytes(stored);
            }
            key.add_bytes(data.nodes());
        }
        key.add_all(&machine.tool_mm);
        key.add_all(&offsets);
        key.add_all(&on_tool);
        built.swings = built.turns && links.iter().any(|link| link.axis.is_rotary());
        built.key = key.0 | 1;
        Some(built)
    }

    /// Does nothing; unreachable in a build without grids.
    #[inline(always)]
    pub(crate) fn exist(&self) {
        self.part.exists();
    }

    /// Key that distinguishes these grids from others; never 0.
    #[inline(always)]
    pub(crate) fn key(&self) -> u64 {
        self.key
    }

    /// Whether one of them has rotations that reach the tip.
    #[inline(always)]
    pub(crate) fn turns(&self) -> bool {
        self.turns
    }

    /// Whether a rotary axis turns the lever of their rotations; the sum then needs the position of the tip.
    #[inline(always)]
    pub(crate) fn swings(&self) -> bool {
        self.swings
    }

    /// Sum of all grids at positions of X, Y, Z from machine zero, mm, if these axes alone move the tip.
    #[inline(never)]
    pub(crate) fn of_slides(&self, q: &[R; LINEAR]) -> Sum<R> {
        self.sum(q, Reach::Slides, V3::ZERO)
    }

    /// Sum of all grids at positions of X, Y, Z, with the tip at `tip` in bed axes.
    #[inline(never)]
    pub(crate) fn at_tip(&self, q: &[R; LINEAR], tip: V3<R>) -> Sum<R> {
        self.sum(q, Reach::Tip, tip)
    }

    #[inline(always)]
    fn sum(&self, q: &[R; LINEAR], reach: Reach, tip: V3<R>) -> Sum<R> {
        let [x, y, z] = *q;
        let mut sum = Sum::nothing();
        for grid in self.grids.iter().flatten() {
            let (twist, edge) = grid.cells.twist(q);
            let [ex, ey, ez, a, b, c] = twist;
            let (mut e, w) = (V3::new(ex, ey, ez), V3::new(a, b, c));
            if let Some(fade) = &grid.fade {
                // A fading grid has no rotations.
                e = e * fade.weight(z);
            } else if grid.turns {
                let [x_there, y_there, z_there] = if reach == Reach::Slides { grid.along } else { grid.moves };
                let way = V3::new(x_there * x, y_there * y, z_there * z);
                let lever = if reach == Reach::Slides { grid.lever + way } else { tip - grid.held - way };
                e += w.cross(lever);
                sum.turn += w;
            }
            sum.tip += e;
            sum.edge |= edge;
        }
        sum
    }
}
