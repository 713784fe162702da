//! Compensation tables.

mod accuracy;
mod additions;
mod axis_csv;
mod change;
mod collapse;
mod columns;
mod finding;
mod formats;
mod formats_five_axes;
mod golden_file;
mod grid;
mod keys;
mod lost_motion;
mod margins;
mod meshes;
mod ranges;
mod rates;
mod read;
mod roundness;
mod rtl;
mod servo;
mod small_machine;
mod tcomp;
mod uncertainty;
