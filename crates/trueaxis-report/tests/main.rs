//! Pages and figures.

mod pages;
mod thinning;
