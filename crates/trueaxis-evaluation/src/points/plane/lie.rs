//! How points lie: in a plane of two axes, along one axis, or inclined to the axes.

use super::model::PlanePoint;
use super::{LEAST, LEAST_ON_LINE, LINEAR, SET_UP};
use crate::circle::principal;
use crate::points::Points;
use crate::points::found::range;
use anyhow::{Result, bail};
use std::ops::Range;
use trueaxis::glam::DVec3;
use trueaxis_metrology::linear_fit::LinearFit;

/// Range of a coordinate below which it is constant, mm.
const CONSTANT_MM: f64 = 1e-3;
/// Share of the points' length below which their width is that of a line.
const LINE: f64 = 1e-3;
/// Share of the points' length below which their thickness is that of a plate that is not quite flat.
const PLATE: f64 = 5e-3;

/// How the points lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Lie {
    /// In the plane of two axes.
    Plane([usize; 2]),
    /// On a line along the first axis; its straightness is measured along the second.
    Line([usize; 2]),
    /// In a plane that two perpendicular directions span, each with the axis next to it.
    Inclined([usize; 2], [DVec3; 2]),
}

/// Where the points extend: directions of the largest extents.
enum Extent {
    Line(DVec3),
    /// The plane's normal.
    Plane(DVec3),
    Space,
}

fn extent(points: &Points) -> Extent {
    let at = || points.points.iter().map(|point| DVec3::from(point.command_mm));
    let mean = at().sum::<DVec3>() / points.points.len().max(1) as f64;
    let [(thin, normal), (wide, _), (long, along)] = principal(at().map(|at| at - mean));
    let is = |one: f64, share: f64| one <= share * share * long;
    match () {
        () if is(wide, LINE) => Extent::Line(along),
        () if is(thin, PLATE) => Extent::Plane(normal),
        () => Extent::Space,
    }
}

impl Points {
    /// Whether the points lie in a plane or on a line, so that [`identify_plane`](super::identify_plane) evaluates them.
    pub fn are_flat(&self) -> bool {
        !matches!(extent(self), Extent::Space)
    }

    /// Lines of the file.
    pub(super) fn lines(&self) -> Range<u32> {
        let [low, high] = range(self.points.iter().map(|point| f64::from(point.line)));
        low as u32..high as u32
    }

    /// Range of a coordinate of the commands or of the deviations.
    fn spread(&self, of: impl Fn(&super::super::Point) -> f64) -> f64 {
        let [low, high] = range(self.points.iter().map(of));
        high - low
    }

    /// How the points lie, if they determine a model.
    pub(super) fn lie(&self) -> Result<Lie> {
        let (count, Range { start, end }) = (self.points.len(), self.lines());
        let extent = extent(self);
        let (least, name) = match extent {
            Extent::Line(_) if count >= LEAST_ON_LINE => (LEAST_ON_LINE, "on a line"),
            _ => (LEAST, "in a plane"),
        };
        if count < least {
            bail!(
                "lines {start} to {end}: found {count} points {name}, needed at least {LEAST}, or {LEAST_ON_LINE} on a line \
                 along an axis"
            );
        }
        if self.tools_mm.len() > 1 {
            let found = self.tools_mm.len();
            bail!("column tool_x_mm: found {found} reflector offsets, needed one for points {name}");
        }
        match extent {
            Extent::Line(along) => self.line(along),
            Extent::Plane(normal) => Ok(plane(normal)),
            Extent::Space => bail!("lines {start} to {end}: found points throughout a volume, needed those of a plane"),
        }
    }

    fn line(&self, along: DVec3) -> Result<Lie> {
        let Range { start, end } = self.lines();
        let axis = largest(along);
        let away = (0..3).filter(|k| *k != axis).map(|k| along[k].powi(2)).sum::<f64>().sqrt();
        if away > SET_UP {
            let combination = super::inclined::along(self, along);
            bail!(
                "lines {start} to {end}: found all points on one line, inclined by {:.2}° to {}, which determines nothing but \
                 {combination}; needed a line along an axis, points in a plane, or several lines",
                away.min(1.0).asin().to_degrees(),
                LINEAR[axis].letter()
            );
        }
        let measured = |k: usize| self.spread(|point| point.deviation_mm[k]);
        let mut across: Vec<usize> = (0..3).filter(|k| *k != axis).collect();
        across.sort_by(|a, b| measured(*b).total_cmp(&measured(*a)));
        if measured(across[0]) == 0.0 {
            bail!(
                "lines {start} to {end}: found deviations along {} alone, needed those across the line too; for positions of one \
                 axis: tables import --from iso230-2",
                LINEAR[axis].letter()
            );
        }
        Ok(Lie::Line([axis, across[0]]))
    }
}

fn largest(of: DVec3) -> usize {
    (0..3).max_by(|a, b| of[*a].abs().total_cmp(&of[*b].abs())).unwrap_or_default()
}

fn plane(normal: DVec3) -> Lie {
    let across = largest(normal);
    let axes = match across {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    };
    if axes.map(|axis| normal[axis]).iter().map(|share| share * share).sum::<f64>().sqrt() <= SET_UP {
        return Lie::Plane(axes);
    }
    // The direction of the axis that is nearer to the plane first: an axis within the plane is one of both directions.
    let nearer = usize::from(normal[axes[1]].abs() < normal[axes[0]].abs());
    let unit = |axis: usize| DVec3::from([0, 1, 2].map(|k| f64::from(u8::from(k == axis))));
    let first = (unit(axes[nearer]) - normal * normal[axes[nearer]]).normalize();
    let other = normal.cross(first);
    let other = if other[axes[1 - nearer]] < 0.0 { -other } else { other };
    Lie::Inclined(axes, if nearer == 0 { [first, other] } else { [other, first] })
}

impl Lie {
    /// The axes of the plane, or that of the line and the one across it.
    pub(super) fn axes(self) -> [usize; 2] {
        let (Lie::Plane(axes) | Lie::Line(axes) | Lie::Inclined(axes, _)) = self;
        axes
    }

    /// The axes whose errors the points show.
    pub(super) fn free(&self) -> &[usize] {
        match self {
            Lie::Plane(axes) | Lie::Inclined(axes, _) => axes,
            Lie::Line(axes) => &axes[..1],
        }
    }

    /// Whether errors found from points that lie like this can be tested on points that lie like the other.
    pub(super) fn is_like(self, other: Lie) -> bool {
        match (self, other) {
            (Lie::Line([one, _]), Lie::Line([two, _])) => one == two,
            (Lie::Inclined(_, [a, b]), Lie::Inclined(_, [c, d])) => a.cross(b).cross(c.cross(d)).length() <= SET_UP,
            _ => self == other,
        }
    }

    /// In words.
    pub(super) fn sentence(self) -> String {
        let [u, v] = self.axes().map(|axis| LINEAR[axis].letter());
        match self {
            Lie::Plane(_) => format!("points over {u} and {v}"),
            Lie::Line(_) => format!("points on a line along {u}"),
            Lie::Inclined(_, [a, b]) => {
                let [x, y, z] = a.cross(b).to_array().map(|share| trueaxis_report::number::decimals(share, 3));
                format!("points in an inclined plane with the normal ({x}, {y}, {z})")
            }
        }
    }

    /// Largest share of the commands' range along the axes that the points have across their plane or line, besides these axes.
    pub(super) fn tilt(self, points: &Points) -> f64 {
        let spread = |k: usize| points.spread(|point| point.command_mm[k]);
        let length = self.free().iter().map(|k| spread(*k)).fold(0.0, f64::max);
        match self {
            Lie::Inclined(..) => 0.0,
            _ => self.others().map(spread).fold(0.0, f64::max) / length,
        }
    }

    /// The other direction across a line, if it was measured too.
    pub(super) fn unused(self, points: &Points) -> Option<usize> {
        let Lie::Line([_, across]) = self else { return None };
        self.others().find(|k| *k != across && points.spread(|point| point.deviation_mm[*k]) > 0.0)
    }

    fn others(self) -> impl Iterator<Item = usize> {
        (0..3).filter(move |k| !self.free().contains(k))
    }

    /// Coordinates of the points in the plane, and their deviations without `errors`, those of the rest of the machine.
    pub(super) fn readings(self, points: &Points, errors: &[[f64; 3]]) -> Vec<PlanePoint> {
        let offs: Vec<[f64; 3]> = points
            .points
            .iter()
            .zip(errors)
            .map(|(point, error)| [0, 1, 2].map(|k| point.deviation_mm[k] - error[k]))
            .collect();
        let reading = |line, at, off, sigma_mm: f64| PlanePoint { line, at, off, weight: sigma_mm.recip() };
        let axes = self.axes();
        if let Lie::Inclined(_, across) = self {
            let both = |of: [f64; 3]| across.map(|along| along.dot(DVec3::from(of)));
            let all = points.points.iter().zip(&offs);
            return all.map(|(of, off)| reading(of.line, both(of.command_mm), both(*off), of.sigma_mm)).collect();
        }
        let turned = self.turned(points, &offs);
        let mean = |k: usize| points.points.iter().map(|of| of.command_mm[k]).sum::<f64>() / points.points.len() as f64;
        let middle = mean(axes[1]);
        let all = points.points.iter().zip(offs).zip(turned);
        all.map(|((of, off), turned)| {
            let mut at = axes.map(|axis| of.command_mm[axis]);
            if let Lie::Line(_) = self {
                at[1] = middle;
            }
            reading(of.line, at, axes.map(|axis| off[axis] - turned[axis]), of.sigma_mm)
        })
        .collect()
    }

    /// Deviations in the plane that come from a rotation of the instrument about the axes of the plane, where the plane is tilted.
    /// The slopes of the deviations across the plane show this rotation.
    fn turned(self, points: &Points, offs: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mut turned = vec![[0.0; 3]; offs.len()];
        for across in self.others().filter(|k| points.spread(|point| point.command_mm[*k]) >= CONSTANT_MM) {
            let mut fit = LinearFit::new(1 + self.free().len());
            for (point, off) in points.points.iter().zip(offs) {
                let row: Vec<f64> =
                    [1.0].into_iter().chain(self.free().iter().map(|axis| point.command_mm[*axis])).collect();
                fit.add(&row, off[across], point.sigma_mm.recip());
            }
            let slopes = fit.solve().values;
            let mean = points.points.iter().map(|point| point.command_mm[across]).sum::<f64>() / offs.len() as f64;
            for (turned, point) in turned.iter_mut().zip(&points.points) {
                for (axis, slope) in self.free().iter().zip(&slopes[1..]) {
                    turned[*axis] -= slope * (point.command_mm[across] - mean);
                }
            }
        }
        turned
    }
}
