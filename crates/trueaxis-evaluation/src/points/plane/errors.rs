//! Errors of the machine in a fitted model, without the placement of the plate.

use super::model::{Fitted, Model, PlanePoint};

/// Cells of a grid along each axis that are tried, until the grid follows the map.
const CELLS: [usize; 5] = [8, 12, 16, 24, 32];
/// Largest difference between grid and map at the points, as a share of the noise.
const FOLLOWS: f64 = 0.05;

/// The errors over the two free axes.
#[derive(Clone, Debug, PartialEq)]
pub enum PlaneErrors {
    /// None that the held-out points confirm: the placement alone.
    None,
    /// Functions of one axis each, and squareness.
    Tables(Box<Tables>),
    /// A map over both axes.
    Grid(Grid),
}

/// Positioning and straightness of the two axes in their plane. Zero at machine zero (or the nearest end), straightness without
/// slope.
#[derive(Clone, Debug, PartialEq)]
pub struct Tables {
    /// Nodes of each axis, mm.
    pub nodes_mm: [Vec<f64>; 2],
    /// Errors at the nodes, mm: of axis `[0]` along direction `[1]`.
    pub errors: [[Vec<f64>; 2]; 2],
    /// Their standard errors, mm.
    pub standard_errors: [[Vec<f64>; 2]; 2],
    /// Deviation along the first axis for a unit of the second beyond the rotation of the plate, rad, and its standard error.
    pub shear: [f64; 2],
    /// Slope of each positioning error over the nodes, and its standard error.
    pub scale: [[f64; 2]; 2],
}

/// Errors along both axes at the nodes of a grid. Zero at machine zero (or the nearest end); the rotation is that of the plate
/// by least squares.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Nodes of each axis, mm.
    pub nodes_mm: [Vec<f64>; 2],
    /// Errors of the nodes, mm: the first axis outermost.
    pub values: Vec<[f64; 2]>,
    /// Largest difference of the grid's interpolation from the map at the points, mm.
    pub off_mm: f64,
}

/// Errors and placement (shifts at machine zero, mm; rotation, rad). `rigid`: the fit of the placement alone.
pub(super) fn errors(fitted: &Fitted, rigid: &Fitted, points: &[PlanePoint]) -> (PlaneErrors, [f64; 3]) {
    let shift = rigid.at([0.0; 2]);
    let turn = rigid.at([1.0, 0.0])[1] - shift[1];
    let reference = fitted.ends.map(|[low, high]| 0.0_f64.clamp(low, high));
    match &fitted.model {
        Model::Rigid => (PlaneErrors::None, [shift[0], shift[1], turn]),
        Model::Map(1) => tables(fitted, fitted.ends.map(Vec::from), reference),
        Model::Tables(nodes) => tables(fitted, nodes.clone(), reference),
        Model::Map(_) => {
            let zero = fitted.at(reference);
            let error = |at: [f64; 2], of: [f64; 2]| {
                [of[0] - zero[0] + turn * (at[1] - reference[1]), of[1] - zero[1] - turn * (at[0] - reference[0])]
            };
            let shift = [zero[0] + turn * reference[1], zero[1] - turn * reference[0]];
            (PlaneErrors::Grid(grid(fitted, points, error)), [shift[0], shift[1], turn])
        }
    }
}

fn combine<'a>(parts: impl IntoIterator<Item = (f64, &'a Vec<f64>)>) -> Vec<f64> {
    let mut sum = Vec::new();
    for (share, terms) in parts {
        sum.resize(terms.len(), 0.0);
        sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += share * term);
    }
    sum
}

/// The four functions of an additive model: differences from the reference along each axis, with the slopes taken apart.
fn tables(fitted: &Fitted, nodes_mm: [Vec<f64>; 2], reference: [f64; 2]) -> (PlaneErrors, [f64; 3]) {
    let zero = fitted.model.terms(reference, fitted.ends);
    // For each axis: combinations of the unknowns that are its function at the nodes, and that are its slope over them.
    let functions = [0, 1].map(|k| {
        let terms: Vec<Vec<f64>> = nodes_mm[k]
            .iter()
            .map(|&node| {
                let mut at = reference;
                at[k] = node;
                combine([(1.0, &fitted.model.terms(at, fitted.ends)), (-1.0, &zero)])
            })
            .collect();
        let mean = nodes_mm[k].iter().sum::<f64>() / nodes_mm[k].len() as f64;
        let squares: f64 = nodes_mm[k].iter().map(|node| (node - mean).powi(2)).sum();
        // The one node across a line has no slope.
        let share = |node: &f64| if squares > 0.0 { (node - mean) / squares } else { 0.0 };
        let slope = combine(nodes_mm[k].iter().map(share).zip(&terms));
        (terms, slope)
    });
    let (mut errors, mut standard_errors) = ([0, 1].map(|_| [vec![], vec![]]), [0, 1].map(|_| [vec![], vec![]]));
    let slope = |axis: usize, direction: usize| fitted.combined(direction, &functions[axis].1);
    for axis in 0..2 {
        for direction in 0..2 {
            for (&node, terms) in nodes_mm[axis].iter().zip(&functions[axis].0) {
                // Straightness without its slope, which is squareness or rotation.
                let arm = if axis == direction { 0.0 } else { reference[axis] - node };
                let [value, error] = fitted.combined(direction, &combine([(1.0, terms), (arm, &functions[axis].1)]));
                errors[axis][direction].push(value);
                standard_errors[axis][direction].push(error);
            }
        }
    }
    let ([along_v, u_v], [along_u, u_u]) = (slope(0, 1), slope(1, 0));
    let (turn, shear) = (along_v, [along_u + along_v, u_v.hypot(u_u)]);
    let at = [0, 1].map(|k| fitted.combined(k, &zero)[0]);
    let shift = [at[0] - along_u * reference[1], at[1] - turn * reference[0]];
    let scale = [slope(0, 0), slope(1, 1)];
    (
        PlaneErrors::Tables(Box::new(Tables { nodes_mm, errors, standard_errors, shear, scale })),
        [shift[0], shift[1], turn],
    )
}

/// The coarsest grid that follows the map at the points. `error` takes the placement off the model's value at a position.
fn grid(fitted: &Fitted, points: &[PlanePoint], error: impl Fn([f64; 2], [f64; 2]) -> [f64; 2]) -> Grid {
    let mut found = Grid { nodes_mm: [vec![], vec![]], values: vec![], off_mm: f64::INFINITY };
    for cells in CELLS {
        let nodes_mm = fitted.ends.map(|[low, high]| {
            (0..=cells).map(|node| low + (high - low) * node as f64 / cells as f64).collect::<Vec<f64>>()
        });
        // A cell at the edge of the points has nodes outside: the map is followed across that cell, and held from there on.
        let cell = (nodes_mm[0][1] - nodes_mm[0][0]).hypot(nodes_mm[1][1] - nodes_mm[1][0]);
        let at = nodes_mm[0].iter().flat_map(|u| nodes_mm[1].iter().map(|v| [*u, *v]));
        let values = at.map(|at| error(at, fitted.followed(at, cell))).collect();
        found = Grid { nodes_mm, values, off_mm: 0.0 };
        let off = points.iter().map(|point| {
            let (grid, map) = (found.at(point.at), error(point.at, fitted.at(point.at)));
            (grid[0] - map[0]).hypot(grid[1] - map[1])
        });
        found.off_mm = off.fold(0.0, f64::max);
        let mean_weight = points.iter().map(|point| point.weight).sum::<f64>() / points.len() as f64;
        if found.off_mm <= FOLLOWS * fitted.sigma / mean_weight {
            break;
        }
    }
    found
}

impl Grid {
    /// The error at a position, bilinear between the nodes, mm.
    pub fn at(&self, at: [f64; 2]) -> [f64; 2] {
        let [u, v] = [0, 1].map(|k| trueaxis_metrology::volumetric::hats(&self.nodes_mm[k], at[k]));
        let mut sum = [0.0; 2];
        for (i, share_u) in u {
            for (j, share_v) in v {
                let value = self.values[i * self.nodes_mm[1].len() + j];
                sum = [0, 1].map(|k| sum[k] + share_u * share_v * value[k]);
            }
        }
        sum
    }
}
