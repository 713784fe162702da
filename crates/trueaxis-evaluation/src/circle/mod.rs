//! Reference circles of a plane trace after ISO 12181-1.

mod polar;

pub use polar::{Shown, polar};

use crate::record::{self, Channel};
use crate::rows::{Column, Rows};
use anyhow::{Result, anyhow};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use trueaxis_metrology::circles::{
    NoCircle, ReferenceCircle, least_squares, maximum_inscribed, minimum_circumscribed, minimum_zone,
};

/// Columns of the points.
pub const COLUMNS: [Column; 2] = [Column { name: "x_mm", needed: true }, Column { name: "y_mm", needed: true }];

/// A reference circle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Circle {
    /// Centre.
    pub centre_mm: [f64; 2],
    /// x of the centre.
    pub cx_mm: f64,
    /// y of the centre.
    pub cy_mm: f64,
    /// Radius: mean, inner or outer, as the circle has it.
    pub radius_mm: f64,
    /// Twice the radius.
    pub diameter_mm: f64,
    /// Smallest distance of a point from the centre.
    pub inner_mm: f64,
    /// Largest distance of a point from the centre.
    pub outer_mm: f64,
    /// Outer less inner.
    pub zone_mm: f64,
    /// The same in µm.
    pub zone_um: f64,
    /// Points that determine the circle, from 0.
    pub contacts: Vec<usize>,
}

impl From<ReferenceCircle> for Circle {
    fn from(circle: ReferenceCircle) -> Self {
        let [cx_mm, cy_mm] = circle.centre;
        Circle {
            centre_mm: circle.centre,
            cx_mm,
            cy_mm,
            radius_mm: circle.radius,
            diameter_mm: 2.0 * circle.radius,
            inner_mm: circle.inner,
            outer_mm: circle.outer,
            zone_mm: circle.zone,
            zone_um: 1e3 * circle.zone,
            contacts: circle.contacts,
        }
    }
}

/// The JSON document; a circle that does not exist is null.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Document {
    /// Number of points.
    pub points: usize,
    /// Least squares.
    pub lsc: Option<Circle>,
    /// Minimum zone.
    pub mzc: Option<Circle>,
    /// Maximum inscribed.
    pub mic: Option<Circle>,
    /// Minimum circumscribed.
    pub mcc: Option<Circle>,
    /// Why a circle is null.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub refused: BTreeMap<&'static str, String>,
}

/// A circle, or why there is none.
pub type Fitted = Result<ReferenceCircle, NoCircle>;

/// Points and the circles about them.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// x and y, mm.
    pub points: Vec<[f64; 2]>,
    /// Line of the file of every point.
    pub lines: Vec<u32>,
    /// LSC, MZC, MCC, MIC: the order of [`trueaxis_report::CIRCLES`].
    pub circles: [Fitted; 4],
}

impl Evaluation {
    /// Reads all rows of [`COLUMNS`] and finds the circles.
    ///
    /// # Errors
    /// A row that cannot be read, a coordinate that stands still half-way, or points that have no circumscribed circle: fewer
    /// than three, or on one line.
    pub fn read(rows: &mut Rows<'_, 2>) -> Result<Evaluation> {
        let (lines, points): (Vec<u32>, Vec<[f64; 2]>) = rows.all()?.iter().map(|row| (row.line, row.values)).unzip();
        let values = [0, 1].map(|c| points.iter().map(|point| point[c]).collect::<Vec<f64>>());
        let channels = [0, 1].map(|c| Channel { name: COLUMNS[c].name, values: &values[c], scale: 1.0 });
        record::alive(rows, &lines, &channels)?;
        Evaluation::of(points, lines, &rows.file)
    }

    /// Finds the circles of points, which stand on these lines of `file`: it is only named in errors.
    ///
    /// # Errors
    /// Points that have no circumscribed circle.
    pub fn of(points: Vec<[f64; 2]>, lines: Vec<u32>, file: &Path) -> Result<Evaluation> {
        // The circumscribed circle exists for all points that have any circle.
        let mcc = minimum_circumscribed(&points).map_err(|error| match error {
            NoCircle::Straight => {
                anyhow!(
                    "{}: found {} points on one straight line, needed three that are not",
                    file.display(),
                    points.len()
                )
            }
            error => anyhow!("{}: {error}", file.display()),
        })?;
        let circles = [least_squares(&points), minimum_zone(&points), Ok(mcc), maximum_inscribed(&points)];
        Ok(Evaluation { points, lines, circles })
    }

    /// The document.
    pub fn document(&self) -> Document {
        let mut refused = BTreeMap::new();
        let mut or_reason = |name, circle: &Fitted| match circle {
            Ok(circle) => Some(circle.clone().into()),
            Err(reason) => {
                refused.insert(name, reason.to_string());
                None
            }
        };
        let [lsc, mzc, mcc, mic] = &self.circles;
        let lsc = or_reason("lsc", lsc);
        let mzc = or_reason("mzc", mzc);
        let mic = or_reason("mic", mic);
        let mcc = or_reason("mcc", mcc);
        Document { points: self.points.len(), lsc, mzc, mic, mcc, refused }
    }
}
