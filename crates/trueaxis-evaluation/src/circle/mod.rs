//! Reference circles of a plane trace after ISO 12181-1.

mod plane;
mod polar;
mod shown;

pub use plane::Plane;
pub(crate) use plane::principal;
pub use polar::{Drawn, polar};
pub(crate) use shown::NAMES;

use crate::record::{self, Channel};
use crate::rows::{Column, Rows};
use anyhow::{Result, anyhow};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use trueaxis_metrology::circles::{
    NoCircle, ReferenceCircle, least_squares, maximum_inscribed, minimum_circumscribed, minimum_zone,
};

/// Columns of the points, two or three of them.
pub const COLUMNS: [Column; 3] = [
    Column { name: "x_mm", needed: false },
    Column { name: "y_mm", needed: false },
    Column { name: "z_mm", needed: false },
];

/// Where the points of a section lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Section {
    /// In the plane of two coordinates, given by their indices in [`COLUMNS`].
    Coordinates([usize; 2]),
    /// In space, in the plane fitted to them.
    Space(Plane),
}

impl Section {
    /// Coordinates of a centre, by index in [`COLUMNS`].
    pub fn centre(&self, centre: [f64; 2]) -> Vec<(usize, f64)> {
        match self {
            Section::Coordinates(of) => of.iter().copied().zip(centre).collect(),
            Section::Space(plane) => plane.at(centre).into_iter().enumerate().collect(),
        }
    }

    /// Letters of the section's coordinates.
    pub fn letters(&self) -> Vec<char> {
        let letter = |(index, _): (usize, f64)| ['x', 'y', 'z'].get(index).copied().unwrap_or('?');
        self.centre([0.0; 2]).into_iter().map(letter).collect()
    }
}

/// A reference circle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Circle {
    /// Centre: two coordinates, or three for points in space.
    pub centre_mm: Vec<f64>,
    /// x of the centre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cx_mm: Option<f64>,
    /// y of the centre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cy_mm: Option<f64>,
    /// z of the centre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cz_mm: Option<f64>,
    /// Radius: mean, inner or outer, depending on the circle.
    pub radius_mm: f64,
    /// Twice the radius.
    pub diameter_mm: f64,
    /// Smallest distance of a point from the centre.
    pub inner_mm: f64,
    /// Largest distance of a point from the centre.
    pub outer_mm: f64,
    /// Outer minus inner radius.
    pub zone_mm: f64,
    /// `zone_mm` in µm.
    pub zone_um: f64,
    /// Points that determine the circle, from 0.
    pub contacts: Vec<usize>,
}

impl Circle {
    fn of(circle: ReferenceCircle, section: &Section) -> Self {
        let centre = section.centre(circle.centre);
        let [cx_mm, cy_mm, cz_mm] =
            [0, 1, 2].map(|index| centre.iter().find(|(own, _)| *own == index).map(|(_, mm)| *mm));
        Circle {
            centre_mm: centre.into_iter().map(|(_, mm)| mm).collect(),
            cx_mm,
            cy_mm,
            cz_mm,
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

/// The plane of points in space, as written to the document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaneDocument {
    /// Unit normal.
    pub normal: [f64; 3],
    /// Largest minus smallest distance of the points from the plane.
    pub flatness_um: f64,
}

/// The JSON document; a circle that does not exist is null.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CircleDocument {
    /// Number of points.
    pub points: usize,
    /// The plane fitted to points in space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plane: Option<PlaneDocument>,
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

/// A circle, or the reason why the points have none.
pub type Fitted = Result<ReferenceCircle, NoCircle>;

/// Points and the circles about them.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// Points in their plane, mm.
    pub points: Vec<[f64; 2]>,
    /// The plane of the points.
    pub section: Section,
    /// Line of the file for every point.
    pub lines: Vec<u32>,
    /// LSC, MZC, MCC, MIC: the order of [`trueaxis_report::CIRCLES`].
    pub circles: [Fitted; 4],
}

impl Evaluation {
    /// Reads all rows of [`COLUMNS`] and fits the circles; points with three coordinates are first projected onto their fitted
    /// plane.
    ///
    /// # Errors
    /// A row that cannot be read, a coordinate that stops changing half-way, or points without a circumscribed circle: fewer
    /// than three, or all on one line.
    pub fn read(rows: &mut Rows<'_, 3>) -> Result<Evaluation> {
        let there: Vec<usize> = (0..3).filter(|index| rows.present[*index]).collect();
        if there.len() < 2 {
            let only = rows.header.join(", ");
            return Err(rows.error(1, &only, "no other coordinate", "two or three of x_mm, y_mm, z_mm"));
        }
        let (lines, points): (Vec<u32>, Vec<[f64; 3]>) = rows.all()?.iter().map(|row| (row.line, row.values)).unzip();
        let values: Vec<Vec<f64>> =
            there.iter().map(|index| points.iter().map(|point| point[*index]).collect()).collect();
        let channels = there.iter().zip(&values);
        let channels = channels.map(|(index, values)| Channel { name: COLUMNS[*index].name, values, scale: 1.0 });
        record::alive(rows, &lines, &channels.collect::<Vec<_>>())?;
        let (section, points) = match there.as_slice() {
            [first, second] => (
                Section::Coordinates([*first, *second]),
                points.iter().map(|point| [point[*first], point[*second]]).collect(),
            ),
            _ => {
                let (plane, points) = Plane::of(&points);
                (Section::Space(plane), points)
            }
        };
        Ok(Evaluation { section, ..Evaluation::of(points, lines, &rows.file)? })
    }

    /// Fits the circles to points from these lines of `file`, which is only named in errors.
    ///
    /// # Errors
    /// Points without a circumscribed circle.
    pub fn of(points: Vec<[f64; 2]>, lines: Vec<u32>, file: &Path) -> Result<Evaluation> {
        // If any circle exists, the circumscribed one does.
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
        Ok(Evaluation { points, section: Section::Coordinates([0, 1]), lines, circles })
    }

    /// The document.
    pub fn document(&self) -> CircleDocument {
        let mut refused = BTreeMap::new();
        let mut or_reason = |name, circle: &Fitted| match circle {
            Ok(circle) => Some(Circle::of(circle.clone(), &self.section)),
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
        let plane = match &self.section {
            Section::Coordinates(_) => None,
            Section::Space(plane) => Some(PlaneDocument { normal: plane.normal, flatness_um: 1e3 * plane.flatness_mm }),
        };
        CircleDocument { points: self.points.len(), plane, lsc, mzc, mic, mcc, refused }
    }
}
