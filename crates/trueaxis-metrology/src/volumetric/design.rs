//! Rows of the fit.

use super::{AXES, Basis, COMPONENTS, Observation};
use std::string::{String, ToString};
use std::vec;
use std::vec::Vec;

/// Index layout of the unknowns.
pub(super) struct Design<'b> {
    pub(super) basis: &'b Basis,
    /// First unknown of each error, if it is observed.
    starts: [[Option<usize>; 6]; 3],
    /// First of A0Z, B0Z, C0Y.
    pub(super) squareness: usize,
    /// First unknown of the instrument's shift and rotation.
    pub(super) placement: usize,
    /// First of the reflector offsets.
    pub(super) offsets: usize,
    pub(super) unknowns: usize,
}

impl<'b> Design<'b> {
    pub(super) fn new(basis: &'b Basis) -> Design<'b> {
        let mut next = 0;
        let starts = std::array::from_fn(|axis| {
            std::array::from_fn(|component| {
                let seen: bool = component < 3 || basis.seen[axis][component];
                let start = next;
                next += if seen { basis.nodes_mm[axis].len() } else { 0 };
                seen.then_some(start)
            })
        });
        let (squareness, placement, offsets) = (next, next + 3, next + 9);
        let unknowns = offsets + 3 * basis.tools.saturating_sub(1);
        Design { basis, starts, squareness, placement, offsets, unknowns }
    }

    /// First unknown of an error.
    pub(super) fn start(&self, axis: usize, component: usize) -> Option<usize> {
        self.starts[axis][component]
    }

    /// Name of the error that an unknown belongs to.
    pub(super) fn name(&self, unknown: usize) -> String {
        for (axis, letter) in AXES.into_iter().enumerate() {
            for (component, of) in COMPONENTS.into_iter().enumerate() {
                let start = self.starts[axis][component];
                if start.is_some_and(|s| (s..s + self.basis.nodes_mm[axis].len()).contains(&unknown)) {
                    return std::format!("E{of}{letter}");
                }
            }
        }
        match unknown.checked_sub(self.squareness) {
            Some(k @ 0..3) => ["A0Z", "B0Z", "C0Y"][k].to_string(),
            Some(3..9) => "the instrument's placement".to_string(),
            _ => "the reflectors' offsets".to_string(),
        }
    }

    /// The three rows of an observation.
    pub(super) fn rows(&self, of: &Observation) -> [Vec<f64>; 3] {
        let mut rows = [0, 1, 2].map(|_| vec![0.0; self.unknowns]);
        let mut put = |unknown: usize, response: [f64; 3]| {
            for (row, value) in rows.iter_mut().zip(response) {
                row[unknown] += value;
            }
        };
        for axis in 0..3 {
            let hats = hats(&self.basis.nodes_mm[axis], of.position_mm[axis]);
            for component in 0..6 {
                let Some(start) = self.starts[axis][component] else { continue };
                let response = of.responses[axis][component];
                for (node, share) in hats {
                    put(start + node, response.map(|value| share * value));
                }
            }
        }
        for k in 0..3 {
            put(self.squareness + k, of.squareness[k]);
            put(self.placement + k, unit(k));
            put(self.placement + 3 + k, cross(unit(k), of.position_mm));
            if let Some(tool) = of.tool.checked_sub(1) {
                put(self.offsets + 3 * tool + k, unit(k));
            }
        }
        rows
    }

    /// Conditions that fix the freedoms the points do not determine, each with the scale of its unknowns (1 for lengths,
    /// `length_mm` for angles).
    pub(super) fn conventions(&self) -> Vec<(Vec<f64>, f64)> {
        let mut conditions = Vec::new();
        for axis in 0..3 {
            let nodes = &self.basis.nodes_mm[axis];
            let mean = nodes.iter().sum::<f64>() / nodes.len() as f64;
            let squares: f64 = nodes.iter().map(|q| (q - mean).powi(2)).sum();
            for component in 0..6 {
                let Some(start) = self.starts[axis][component] else { continue };
                let mut zero = vec![0.0; self.unknowns];
                for (node, share) in hats(nodes, self.basis.reference_mm[axis]) {
                    zero[start + node] += share;
                }
                conditions.push((zero, if component < 3 { 1.0 } else { self.basis.length_mm }));
                if component < 3 && component != axis {
                    let mut slope = vec![0.0; self.unknowns];
                    for (node, q) in nodes.iter().enumerate() {
                        slope[start + node] = (q - mean) / squares;
                    }
                    conditions.push((slope, self.basis.length_mm));
                }
            }
        }
        conditions
    }

    /// Second differences of neighbouring nodes, with the scale of their unknowns.
    pub(super) fn smoothing(&self) -> Vec<([(usize, f64); 3], f64)> {
        let mut rows = Vec::new();
        for axis in 0..3 {
            let nodes = &self.basis.nodes_mm[axis];
            for component in 0..6 {
                let Some(start) = self.starts[axis][component] else { continue };
                for (k, three) in nodes.windows(3).enumerate() {
                    let (before, after) = (three[1] - three[0], three[2] - three[1]);
                    // Deviation from the straight line through the neighbours.
                    let share = after / (before + after);
                    let row = [(start + k, share), (start + k + 1, -1.0), (start + k + 2, 1.0 - share)];
                    rows.push((row, if component < 3 { 1.0 } else { self.basis.length_mm }));
                }
            }
        }
        rows
    }
}

fn unit(k: usize) -> [f64; 3] {
    std::array::from_fn(|i| f64::from(u8::from(i == k)))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The two nodes around a position and their shares; beyond the ends, the end node.
pub fn hats(nodes: &[f64], q: f64) -> [(usize, f64); 2] {
    let above = nodes.partition_point(|node| *node <= q).clamp(1, nodes.len() - 1);
    let (low, high) = (nodes[above - 1], nodes[above]);
    let share = ((q - low) / (high - low)).clamp(0.0, 1.0);
    [(above - 1, 1.0 - share), (above, share)]
}
