//! Diagonal and step-diagonal displacement tests after ISO 230-6.
//!
//! A laser beam runs along each of the four body diagonals of the working volume. In the *diagonal test* the axes move
//! together and every target is on the diagonal; in the *step-diagonal (vector) test* they move one after the other, and the
//! displacement along the beam is read after every single step. Deviations x = actual − commanded displacement along the beam,
//! from the diagonal's first target.
//!
//! **Figures** ([`figures`]), for the targets on the diagonal D, in the terms of ISO 230-2:
//!
//! ```text
//! B(D) = max |x̄_i↑ − x̄_i↓|                         reversal value of the diagonal
//! E(D) = max(x̄_i↑, x̄_i↓) − min(x̄_i↑, x̄_i↓)         systematic deviation of positioning on it
//! M(D) = max x̄_i − min x̄_i                          range of the mean deviation
//! R(D) = max R_i                                     repeatability (two runs at least)
//! E_d, B_d, R_d, M_d: the largest of the four
//! ```
//!
//! **Errors of the machine** (submodule `volume`). With u the diagonal's unit vector and s the signs of its components, the
//! slope of its deviation is to first order
//!
//! ```text
//! m = u_x² s_x + u_y² s_y + u_z² s_z − u_x u_y C0Y + u_x u_z B0Z − u_y u_z A0Z        (s_i: scale of axis i)
//! ```
//!
//! Four slopes determine the three squarenesses and one weighted scale, whatever the mirror's alignment (to second order).
//!
//! **Information from the steps** (submodule `vector`). A step of axis j along diagonal k reads u_k · δ_j: four equations for
//! the three components of the step's error. But a flat mirror tilted by τ from the diagonal's normal adds D (τ·n_j) to the
//! reading of a step D of axis j, because the step moves it sideways; so does an error of the beam's direction. The four τ
//! take the place of the scales: the scales and the slopes of the straightnesses can only be determined if the alignment is
//! known (`alignment_rad`). The remaining shapes, slopes removed, do not depend on τ, but do contain angular errors with their
//! levers.
//!
//! Sources: ISO 230-6:2002; C. Wang, Rev. Sci. Instrum. 71 (2000) 3933 (the vector method); M. A. V. Chapman, Precis. Eng. 27
//! (2003) 401 and O. Svoboda, Precis. Eng. 30 (2006) 132 (its limits); J. A. Soons, Laser Metrology and Machine Performance VII
//! (2005) 126 (analysis of the step-diagonal test); S. Ibaraki et al., Precis. Eng. 33 (2009) 104 (set-up errors of it).

mod figures;
mod steps;
mod vector;
mod volume;

pub use figures::{Figures, figures};
pub use vector::{Shape, Vector};
pub use volume::{Term, Volume};

use crate::accuracy::Direction;
use core::fmt;
use std::vec::Vec;

/// A target farther from the diagonal than this share of its length is a step, not a target of the diagonal.
const OFF_DIAGONAL: f64 = 1e-4;
/// Least number of targets on a diagonal.
const LEAST: usize = 3;

/// One reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// The diagonal, 0 … 3.
    pub diagonal: usize,
    /// Run, from 1.
    pub run: u32,
    /// Away from the diagonal's first target, or back towards it.
    pub direction: Direction,
    /// Commanded position, mm.
    pub position_mm: [f64; 3],
    /// Actual − commanded displacement along the beam, mm.
    pub deviation_mm: f64,
}

/// A target of a diagonal with the mean of its readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Commanded position, mm.
    pub position_mm: [f64; 3],
    /// Distance along the diagonal, mm.
    pub along_mm: f64,
    /// Distance from the diagonal, mm.
    pub lateral_mm: f64,
    /// Mean deviation away and back, mm.
    pub mean_mm: [Option<f64>; 2],
}

impl Target {
    /// Returns the mean over the measured directions, mm.
    pub fn mean(&self) -> f64 {
        let known = self.mean_mm.iter().flatten();
        known.clone().sum::<f64>() / (known.count().max(1)) as f64
    }
}

/// A diagonal with its targets in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagonal {
    /// Unit vector from the first to the last target.
    pub unit: [f64; 3],
    /// Length of the diagonal, mm.
    pub length_mm: f64,
    /// Targets, in the order of `along_mm`.
    pub targets: Vec<Target>,
}

/// Four diagonals, and the scatter of a reading.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Test {
    /// The diagonals 1 … 4.
    pub diagonals: [Diagonal; 4],
    /// Readings of all diagonals.
    pub readings: Vec<Reading>,
    /// Whether some targets are off the diagonals.
    pub steps: bool,
    /// Standard deviation of a reading from repeated runs, mm; `None` without repeats.
    pub sigma_mm: Option<f64>,
}

/// Why a test is refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum DiagonalRefusal {
    /// A diagonal has no reading.
    Missing {
        /// Number of the diagonal, 1 … 4.
        diagonal: usize,
    },
    /// A target is repeated in the same run and direction.
    Twice {
        /// Index of the second reading.
        index: usize,
        /// Index of the first reading.
        first: usize,
    },
    /// A diagonal has too few targets.
    TooFew {
        /// Number of the diagonal, 1 … 4.
        diagonal: usize,
        /// Number of targets on it.
        found: usize,
    },
    /// A line is not a body diagonal: an axis hardly moves along it.
    NotABodyDiagonal {
        /// Number of the diagonal, 1 … 4.
        diagonal: usize,
        /// Travel of X, Y, Z along it, mm.
        travel_mm: [f64; 3],
    },
    /// The diagonals belong to different boxes, or one occurs twice.
    NotOneBox {
        /// Number of the diagonal, 1 … 4.
        diagonal: usize,
    },
}

impl fmt::Display for DiagonalRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DiagonalRefusal::Missing { diagonal } => {
                write!(f, "found no reading of diagonal {diagonal}, needed diagonals 1 to 4")
            }
            DiagonalRefusal::Twice { .. } => {
                write!(f, "found a target a second time, needed each once a run and direction")
            }
            DiagonalRefusal::TooFew { diagonal, found } => {
                write!(f, "targets on diagonal {diagonal}: found {found}, needed at least {LEAST}")
            }
            DiagonalRefusal::NotABodyDiagonal { diagonal, travel_mm: [x, y, z] } => write!(
                f,
                "diagonal {diagonal}: found a travel of {x}, {y}, {z} mm, needed a body diagonal on which all of X, Y, Z move"
            ),
            DiagonalRefusal::NotOneBox { diagonal } => write!(
                f,
                "diagonal {diagonal}: found another box, or a diagonal that is there already, needed the four body diagonals of one"
            ),
        }
    }
}

impl core::error::Error for DiagonalRefusal {}

impl Test {
    /// Sorts readings into diagonals and targets.
    ///
    /// The first target of a diagonal is the position of its first reading in the direction away. Cost: n log n of the
    /// readings.
    ///
    /// # Errors
    /// [`DiagonalRefusal`].
    pub fn new(readings: Vec<Reading>) -> Result<Test, DiagonalRefusal> {
        let mut diagonals = Vec::new();
        let (mut squares, mut freedom) = (0.0, 0);
        for number in 0..4 {
            let own: Vec<(usize, &Reading)> =
                readings.iter().enumerate().filter(|(_, reading)| reading.diagonal == number).collect();
            let (diagonal, scatter) = diagonal(number + 1, &own)?;
            squares += scatter.0;
            freedom += scatter.1;
            diagonals.push(diagonal);
        }
        for (k, one) in diagonals.iter().enumerate() {
            let reference = diagonals[0].unit;
            let same_box = (0..3).all(|c| (one.unit[c].abs() - reference[c].abs()).abs() < 1e-3);
            let doubled = diagonals[..k].iter().any(|other| dot(other.unit, one.unit).abs() > 1.0 - 1e-9);
            if !same_box || doubled || (one.length_mm / diagonals[0].length_mm - 1.0).abs() > 1e-3 {
                return Err(DiagonalRefusal::NotOneBox { diagonal: k + 1 });
            }
        }
        let diagonals: [Diagonal; 4] = diagonals.try_into().map_err(|_| DiagonalRefusal::Missing { diagonal: 4 })?;
        let steps = diagonals
            .iter()
            .flat_map(|own| own.targets.iter().map(move |t| (own, t)))
            .any(|(own, target)| target.lateral_mm > OFF_DIAGONAL * own.length_mm);
        let sigma_mm = (freedom > 0).then(|| (squares / freedom as f64).sqrt());
        Ok(Test { diagonals, readings, steps, sigma_mm })
    }

    /// Returns squareness and scale from the slopes of the diagonals.
    pub fn volume(&self) -> Volume {
        volume::volume(self)
    }

    /// Evaluates the steps; `None` without steps, or if an interval of an axis is missing on one of the four diagonals.
    ///
    /// `alignment_rad`: standard uncertainty of the mirror's alignment; without it the scales remain unknown.
    pub fn vector(&self, alignment_rad: Option<f64>) -> Option<Vector> {
        vector::vector(self, alignment_rad)
    }

    /// Returns the targets on a diagonal.
    pub fn on(&self, diagonal: usize) -> impl Iterator<Item = &Target> {
        let own = &self.diagonals[diagonal];
        own.targets.iter().filter(|target| target.lateral_mm <= OFF_DIAGONAL * own.length_mm)
    }
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn less(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

type Scatter = (f64, usize);

fn diagonal(number: usize, own: &[(usize, &Reading)]) -> Result<(Diagonal, Scatter), DiagonalRefusal> {
    let away = own.iter().find(|(_, reading)| reading.direction == Direction::Up).or(own.last());
    let Some((_, first)) = away else { return Err(DiagonalRefusal::Missing { diagonal: number }) };
    let from = first.position_mm;
    let far = own.iter().map(|(_, reading)| less(reading.position_mm, from));
    let to = far.fold([0.0; 3], |best, way| if dot(way, way) > dot(best, best) { way } else { best });
    let length_mm = dot(to, to).sqrt();
    if !(to.iter().all(|part| part.abs() > 0.05 * length_mm) && length_mm > 0.0) {
        return Err(DiagonalRefusal::NotABodyDiagonal { diagonal: number, travel_mm: to });
    }
    let unit = to.map(|part| part / length_mm);
    let mut sorted: Vec<(usize, &Reading, f64)> =
        own.iter().map(|&(index, reading)| (index, reading, dot(less(reading.position_mm, from), unit))).collect();
    crate::order::sort_by_number(&mut sorted, |one| one.2);
    let mut targets: Vec<Target> = Vec::new();
    let (mut squares, mut freedom) = (0.0, 0);
    for group in sorted.chunk_by(|one, other| other.2 - one.2 < 1e-6 * length_mm) {
        let mut mean_mm = [None; 2];
        for (way, direction) in [Direction::Up, Direction::Down].into_iter().enumerate() {
            let mut of: Vec<&(usize, &Reading, f64)> = group.iter().filter(|r| r.1.direction == direction).collect();
            of.sort_by_key(|r| r.0);
            for (i, second) in of.iter().enumerate() {
                if let Some(first) = of[..i].iter().find(|first| first.1.run == second.1.run) {
                    return Err(DiagonalRefusal::Twice { index: second.0, first: first.0 });
                }
            }
            if !of.is_empty() {
                let mean = of.iter().map(|r| r.1.deviation_mm).sum::<f64>() / of.len() as f64;
                squares += of.iter().map(|r| (r.1.deviation_mm - mean).powi(2)).sum::<f64>();
                freedom += of.len() - 1;
                mean_mm[way] = Some(mean);
            }
        }
        let (_, reading, along_mm) = group[0];
        let way = less(reading.position_mm, from);
        let lateral_mm = (dot(way, way) - along_mm * along_mm).max(0.0).sqrt();
        targets.push(Target { position_mm: reading.position_mm, along_mm, lateral_mm, mean_mm });
    }
    let found = targets.iter().filter(|target| target.lateral_mm <= OFF_DIAGONAL * length_mm).count();
    if found < LEAST {
        return Err(DiagonalRefusal::TooFew { diagonal: number, found });
    }
    Ok((Diagonal { unit, length_mm, targets }, (squares, freedom)))
}
