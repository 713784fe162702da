//! End-to-end tests and cross-checks.

mod committed;
mod faults;
mod naca2415;
mod nine_terms_against_exact_geometry;
mod robustness;
mod scripts;
mod spare_slots;
mod stability;
mod telemetry;
mod trial;
mod volumetric_against_exact_geometry;
mod walk;
