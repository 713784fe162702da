//! Pages, figures, tables of data.

mod columnar;
mod pages;
mod thinning;
