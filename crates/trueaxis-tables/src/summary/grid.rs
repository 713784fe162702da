//! Grids of a compiled file.

use crate::text::short;
use serde::Serialize;
use std::fmt;
use trueaxis::machine::{Axis, GridData};

/// Summary of a grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GridSummary {
    /// The axes that it covers, with their nodes.
    pub axes: Vec<GridAxisSummary>,
    /// Total number of nodes.
    pub nodes: usize,
    /// Bytes of the nodes and of positions that are not equidistant, in flash.
    pub bytes: usize,
    /// Heights Z, mm, between which it fades.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fade_mm: Option<[f64; 2]>,
    /// Position of X, Y, Z during the measurement, mm; zero for the axes that it covers.
    pub measured_at_mm: [f64; 3],
    /// The given errors.
    pub errors: Vec<GridErrorSummary>,
}

/// Nodes along an axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GridAxisSummary {
    /// X, Y or Z.
    pub axis: char,
    /// Number of nodes.
    pub nodes: u16,
    /// First and last node, mm.
    pub range_mm: [f64; 2],
    /// Whether the nodes are equidistant.
    pub equidistant: bool,
}

/// An error of the nodes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GridErrorSummary {
    /// EX and so on.
    pub name: String,
    /// um or urad.
    pub unit: &'static str,
    /// Largest |value|, in `unit`.
    pub max_abs: f64,
    /// Resolution: a value is off by at most half of it, in `unit`.
    pub resolution: f64,
}

pub(super) fn grid(data: &GridData<'_>) -> GridSummary {
    let header = data.header();
    let letters = Axis::ALL.into_iter().zip(&header.axes).filter(|(_, along)| along.is_there());
    let values = data.extremes().values;
    let errors = Axis::ALL.into_iter().enumerate().filter(|(component, _)| header.given >> component & 1 == 1);
    GridSummary {
        axes: letters
            .map(|(axis, along)| GridAxisSummary {
                axis: axis.letter(),
                nodes: along.nodes,
                range_mm: along.ends,
                equidistant: !along.free,
            })
            .collect(),
        nodes: header.count().unwrap_or(0),
        bytes: data.size(),
        fade_mm: header.fade,
        measured_at_mm: header.measured_at_mm,
        errors: errors
            .map(|(component, direction)| {
                let scale = if component < 3 { 1e3 } else { 1e6 };
                let [least, most] = values[component];
                GridErrorSummary {
                    name: format!("E{}", direction.letter()),
                    unit: if component < 3 { "um" } else { "urad" },
                    max_abs: least.abs().max(most.abs()) * scale,
                    resolution: header.scales[component] * scale,
                }
            })
            .collect(),
    }
}

impl fmt::Display for GridSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letters: Vec<String> = self.axes.iter().map(|along| along.axis.to_string()).collect();
        let counts: Vec<String> = self.axes.iter().map(|along| along.nodes.to_string()).collect();
        let (over, by) = (letters.join(" "), counts.join(" × "));
        write!(f, "\n\nGrid over {over}   {by} nodes, {:.1} KiB in flash", self.bytes as f64 / 1024.0)?;
        for GridAxisSummary { axis, range_mm, equidistant, .. } in &self.axes {
            let [low, high] = range_mm.map(short);
            write!(f, "\n  {axis}          {low} to {high} mm{}", if *equidistant { "" } else { ", free" })?;
        }
        if let Some([whole, none]) = self.fade_mm {
            write!(f, "\n  fades      from Z {} to nothing at Z {} mm", short(whole), short(none))?;
        }
        if self.measured_at_mm != [0.0; 3] {
            let [x, y, z] = self.measured_at_mm.map(short);
            write!(f, "\n  measured   at {x} {y} {z} mm")?;
        }
        write!(f, "\n  max |E|   ")?;
        for error in &self.errors {
            let micro = if error.unit == "um" { "µm" } else { "µrad" };
            write!(f, " {} {:.2} {micro} (in steps of {})", error.name, error.max_abs, short(error.resolution))?;
        }
        Ok(())
    }
}
