//! Checks of grids, and bounds on the effect of their errors on the inverse.

use super::bounds::reach;
use super::need;
use crate::error::{ConfigError, Field};
use crate::machine::{Axis, GRID_NODES, GRIDS, GridAxis, GridData, GridExtremes, MachineSettings, Rows, links};
use crate::part::{self, Part};
use crate::range;
use heapless::Vec;

/// Checks every grid of a machine: two or three of its linear axes with 2 to 1000 nodes each, ascending positions,
/// every error in its physical range, and a fade only over X and Y and without rotations.
///
/// # Errors
/// The first fault found, with the number of the grid as its index.
pub fn grids(machine: &MachineSettings, grids: &[GridData<'_>]) -> Result<(), ConfigError> {
    let found = grids.len() as f64;
    need(grids.len() <= GRIDS, ConfigError::new(Field::GridTable, found, "at most 4 grids"))?;
    if part::GRIDS.is_none() {
        return need(grids.is_empty(), ConfigError::left_out(Part::Grids, Field::GridTable));
    }
    grids.iter().enumerate().try_for_each(|(index, grid)| one(machine, grid).map_err(|error| error.at(index)))
}

fn one(machine: &MachineSettings, grid: &GridData<'_>) -> Result<(), ConfigError> {
    let header = grid.header();
    let letters = [Axis::X, Axis::Y, Axis::Z];
    let over = header.letters().count();
    need(over >= 2, ConfigError::new(Field::GridAxes, over as f64, "two or three of the linear axes X, Y, Z"))?;
    for (slot, (axis, along)) in letters.into_iter().zip(&header.axes).enumerate() {
        if along.is_there() {
            let known = machine.axis(axis).is_some();
            need(known, ConfigError::new(Field::GridAxes, slot as f64, "axes that the machine has").on(axis))?;
            nodes(grid, slot, axis, along)?;
        } else {
            let unused = *along == GridAxis::default();
            need(unused, ConfigError::new(Field::GridAxes, slot as f64, "no data of an axis without nodes").on(axis))?;
        }
    }
    given(header.given, &header.scales)?;
    fade(machine, grid)?;
    for ((axis, along), at) in letters.into_iter().zip(&header.axes).zip(header.measured_at_mm) {
        range::LENGTH.check(at, Field::GridMeasuredAt, Some(axis))?;
        let needed = "0 for an axis that the grid covers";
        need(!along.is_there() || at == 0.0, ConfigError::new(Field::GridMeasuredAt, at, needed).on(axis))?;
    }
    for (component, values) in grid.extremes().values.into_iter().enumerate() {
        let range = if component < 3 { range::GRID_TRANSLATION } else { range::ROTATION };
        for value in values {
            range.check(value, Field::GridTable, None)?;
        }
    }
    Ok(())
}

/// Checks the nodes along an axis.
fn nodes(grid: &GridData<'_>, slot: usize, axis: Axis, along: &GridAxis) -> Result<(), ConfigError> {
    let wrong = |found, needed| ConfigError::new(Field::GridTable, found, needed).on(axis);
    let count = usize::from(along.nodes);
    need((2..=GRID_NODES).contains(&count), wrong(count as f64, "2 to 1000 nodes along an axis"))?;
    let mut before = None;
    for index in 0..count {
        let at = grid.position(slot, index).unwrap_or(f64::NAN);
        range::POSITION.linear.check(at, Field::GridTable, Some(axis))?;
        let ascends = before.is_none_or(|before| at >= before + range::LEAST_PITCH * (1.0 - 1e-6));
        need(ascends, wrong(at, "a node above the one before, by at least 0.001 mm"))?;
        before = Some(at);
        let [first, last] = along.ends;
        let ends = [(0, first), (count - 1, last)];
        let at_end = ends.iter().all(|(end, position)| *end != index || *position == at);
        need(at_end, wrong(at, "the first and the last node at the ends that the grid states"))?;
    }
    Ok(())
}

/// Checks which errors the nodes give, and their resolution.
fn given(given: u8, scales: &[f64; 6]) -> Result<(), ConfigError> {
    let wrong = |found| ConfigError::new(Field::GridTable, found, "at least one of EX EY EZ EA EB EC");
    need(given != 0 && given < 64, wrong(f64::from(given)))?;
    for (component, scale) in scales.iter().enumerate() {
        let is_given = given >> component & 1 == 1;
        let range = if component < 3 { range::GRID_STEP } else { range::GRID_TURN };
        if is_given {
            range.check(*scale, Field::GridResolution, None)?;
        } else {
            need(*scale == 0.0, ConfigError::new(Field::GridResolution, *scale, "0 for errors that are not given"))?;
        }
    }
    Ok(())
}

fn fade(machine: &MachineSettings, grid: &GridData<'_>) -> Result<(), ConfigError> {
    let header = grid.header();
    let Some([whole, none]) = header.fade else { return Ok(()) };
    range::POSITION.linear.all(&[whole, none], Field::GridFade, None)?;
    let wrong = |needed| ConfigError::new(Field::GridFade, whole, needed);
    need(none >= whole + range::LEAST_PITCH, wrong("two heights, the second above the first by at least 0.001 mm"))?;
    let [_, _, z] = header.axes;
    need(!z.is_there(), wrong("a grid over X and Y: it fades along Z"))?;
    need(machine.axis(Axis::Z).is_some(), wrong("an axis Z, along which the grid fades"))?;
    need(header.given >> 3 == 0, wrong("a grid without rotations"))
}

/// Bounds of one grid.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bound {
    over: [bool; 3],
    measured_at: [f64; 3],
    extremes: GridExtremes,
}

/// Bounds on all grids of a machine: values and slopes of their errors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridBounds(Vec<Bound, GRIDS>);

impl GridBounds {
    /// Bounds without any grid.
    pub const NONE: Self = GridBounds(Vec::new());

    /// Finds the bounds of these grids; reads every node once.
    pub fn of(grids: &[GridData<'_>]) -> Self {
        let mut bounds = Self::NONE;
        if part::GRIDS.is_none() {
            return bounds;
        }
        for grid in grids {
            let header = grid.header();
            let mut extremes = grid.extremes();
            if let Some([whole, none]) = header.fade {
                for (slopes, values) in extremes.slopes.iter_mut().zip(&mut extremes.values) {
                    let [_, _, height] = slopes;
                    let [least, most] = *values;
                    *height = least.abs().max(most.abs()) / (none - whole);
                    *values = [least.min(0.0), most.max(0.0)];
                }
            }
            let over = header.axes.map(|along| along.is_there());
            // The capacity is the permitted number of grids: [`grids`] refuses more.
            let _ = bounds.0.push(Bound { over, measured_at: header.measured_at_mm, extremes });
        }
        bounds
    }

    /// Largest |∂E/∂q| of an error along a linear axis, summed over all grids, mm or rad per mm; zero along a rotary
    /// one.
    pub fn slope(&self, axis: Axis, component: usize) -> f64 {
        if part::GRIDS.is_none() {
            return 0.0;
        }
        let of = |bound: &Bound| bound.extremes.slopes.get(component)?.get(axis.index()).copied();
        self.0.iter().filter_map(of).sum()
    }

    /// Smallest and largest value of an error, summed over all grids, mm or rad.
    pub fn values(&self, component: usize) -> [f64; 2] {
        if part::GRIDS.is_none() {
            return [0.0; 2];
        }
        let of = |bound: &Bound| bound.extremes.values.get(component).copied();
        self.0.iter().filter_map(of).fold([0.0; 2], |[low, high], [least, most]| [low + least, high + most])
    }

    /// Bounds at the tip, including rotations with their levers.
    pub(super) fn of_tip<'r, T: Rows + ?Sized + 'r>(
        &self,
        machine: &MachineSettings,
        rows: &impl Fn(Axis) -> Option<&'r T>,
    ) -> TipBounds {
        let mut sum = TipBounds::default();
        if part::GRIDS.is_none() {
            return sum;
        }
        for bound in &self.0 {
            sum.add(machine, rows, bound);
        }
        sum
    }
}

/// Bounds on the effect of grids on tip and direction in the volumetric model.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TipBounds {
    /// Largest |rotation|, rad.
    pub(super) turn: f64,
    /// Largest |error| that the rotations cause through their levers along X, Y, Z, mm.
    pub(super) swing: [f64; 3],
    /// Largest |∂d/∂q| (per mm) and |∂w/∂q| (rad per mm) along X, Y and Z.
    pub(super) rates: [[f64; 2]; 3],
}

impl TipBounds {
    fn add<'r, T: Rows + ?Sized + 'r>(
        &mut self,
        machine: &MachineSettings,
        rows: &impl Fn(Axis) -> Option<&'r T>,
        bound: &Bound,
    ) {
        let lever = lever(machine, rows, bound);
        let largest = bound.extremes.values.map(|[least, most]| least.abs().max(most.abs()));
        let [_, _, _, a, b, c] = largest;
        let turn = length(&[a, b, c]);
        self.turn += turn;
        for (sum, part) in self.swing.iter_mut().zip(swing([a, b, c], lever)) {
            *sum += part;
        }
        let links = links(&machine.chain).unwrap_or_default();
        for (slot, rates) in self.rates.iter_mut().enumerate() {
            let slopes = bound.extremes.slopes.map(|slopes| slopes.get(slot).copied().unwrap_or(0.0));
            let [ex, ey, ez, a, b, c] = slopes;
            let carries = links.iter().any(|link| link.axis.index() == slot && !link.carries_workpiece);
            // A slide between the measured point and the tool lengthens the lever.
            let longer = if carries && bound.over.get(slot) == Some(&false) { turn } else { 0.0 };
            let [tip, turning] = rates;
            *tip += length(&[ex, ey, ez]) + length(&swing([a, b, c], lever)) + longer;
            *turning += length(&[a, b, c]);
        }
    }
}

/// Largest |component| of the distance from the point where a grid's translations apply to the tip, mm.
fn lever<'r, T: Rows + ?Sized + 'r>(
    machine: &MachineSettings,
    rows: &impl Fn(Axis) -> Option<&'r T>,
    bound: &Bound,
) -> [f64; 3] {
    let links = links(&machine.chain).unwrap_or_default();
    let on_tool = || links.iter().filter(|link| !link.carries_workpiece).filter_map(|link| machine.axis(link.axis));
    let turned = on_tool().any(|own| own.axis.is_rotary());
    let mut along = machine.tool_mm.map(f64::abs);
    let mut anywhere = length(&machine.tool_mm);
    for own in on_tool() {
        // After a turn, the vector to the tip may point opposite to the one in the zero pose.
        anywhere += 2.0 * length(&own.offset_mm);
        if own.axis.is_rotary() {
            continue;
        }
        let slot = own.axis.index();
        let [low, high] = reach(own, rows(own.axis));
        let at = bound.measured_at.get(slot).copied().unwrap_or(0.0);
        let over = bound.over.get(slot) == Some(&true);
        let way = if over { 0.0 } else { (low - at).abs().max((high - at).abs()) };
        if let Some(along) = along.get_mut(slot) {
            *along += way;
        }
        let carried = crate::machine::is_turned(&links, own.axis);
        anywhere += way + if carried { 2.0 * low.abs().max(high.abs()) } else { 0.0 };
    }
    if turned { [anywhere; 3] } else { along }
}

fn length(v: &[f64]) -> f64 {
    libm::sqrt(v.iter().map(|x| x * x).sum())
}

/// Largest tip error along X, Y, Z that rotations cause through a lever, mm.
fn swing([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z + c * y, c * x + a * z, a * y + b * x]
}
