#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod colour;
mod deviations;
mod draw;
mod error_bars;
mod figure;
mod heat_map;
mod histogram;
mod isometric;
mod legend;
mod mark;
pub mod number;
mod page;
mod polar;
mod render;
mod scale;
mod size;
mod stroke;
mod svg;
mod table;
mod thinner;

pub use colour::Colour;
pub use deviations::{Deviated, View};
pub use error_bars::{BARS, error_bars, residuals};
pub use figure::Figure;
pub use heat_map::heat_map;
pub use histogram::columns;
pub use isometric::{Edge, isometric};
pub use mark::Mark;
pub use page::{Page, missing, side_by_side, summary};
pub use polar::{CIRCLES, Circle, PolarTrace, polar, polar_traces};
pub use scale::Scale;
pub use stroke::Stroke;
pub use table::{Row, Table};
pub use thinner::{Thinner, decimate, thin};
