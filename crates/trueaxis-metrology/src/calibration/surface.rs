//! Surfaces of the artefacts.

use std::vec::Vec;

/// A contribution to the position of a face: an unknown times a factor and, with a direction, times the distance along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Index of the unknown.
    pub unknown: usize,
    /// Factor.
    pub factor: f64,
    /// Direction a of the lever a · p; `None` for a lever of 1.
    pub along: Option<[f64; 3]>,
}

/// A surface of an artefact, with the indices of its unknowns.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// Inside of a cylinder.
    Bore {
        /// Index of the diameter.
        diameter: usize,
        /// Index of the first of the centre's two coordinates, along `plane`.
        centre: usize,
        /// Two unit vectors across the bore's axis.
        plane: [[f64; 3]; 2],
    },
    /// A sphere, single or on a plate.
    Ball {
        /// Index of the diameter.
        diameter: usize,
        /// Index of the first of three coordinates of the artefact's origin.
        origin: usize,
        /// Position of the ball on the artefact, mm, in the artefact's directions as set up.
        offset: [f64; 3],
        /// Index of the first of three components of the artefact's rotation (axis times angle), rad.
        turn: Option<usize>,
        /// Indices of the deviations of the ball's position along X, Y and Z, mm: which of the artefact's own directions lie
        /// there depends on how it is set up.
        own: Option<[usize; 3]>,
        /// Index of the relative elongation of the whole artefact, 1.
        length: Option<usize>,
    },
    /// Centre of a ball or a hole, from touches on its opposite sides: `tip_mm` is their middle.
    Centre(Centre),
    /// A plane face.
    Face {
        /// Unit vector across the face.
        normal: [f64; 3],
        /// +1 if the outward side of the material is along the normal, −1 if against it.
        outward: f64,
        /// Known part of the face's position along the normal, mm.
        known_mm: f64,
        /// Unknown parts.
        parts: Vec<Part>,
    },
}

/// Centre of a ball or a hole on a plate of unknown places, in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Centre {
    /// Unit vectors along the plate's columns and rows as set up.
    pub plane: [[f64; 3]; 2],
    /// Index of the first of the plate's two coordinates along `plane`; its rotation from the first to the second direction
    /// follows, rad.
    pub origin: usize,
    /// Nominal position on the plate, mm.
    pub offset: [f64; 2],
    /// Index of the first of two deviations from it, mm; `None` at the two places that define the plate's directions.
    pub own: Option<usize>,
    /// Index of the relative elongation of the whole plate, 1.
    pub length: usize,
    /// Unit vector in the plane along which the opposite sides were touched.
    pub along: [f64; 3],
    /// Square root of the number of touches.
    pub weight: f64,
}

/// A trip of the probe.
#[derive(Clone, Debug, PartialEq)]
pub struct Touch {
    /// Centre of the tip as the machine reports it, in workpiece coordinates, mm.
    pub tip_mm: [f64; 3],
    /// The touched surface.
    pub surface: Surface,
    /// Movement of the tip per unit of each machine term, mm.
    pub response: Vec<[f64; 3]>,
    /// Knots of the drift with their weights: indices of the first of three components, mm.
    pub drift: Vec<(usize, f64)>,
    /// Index of the radius of a tip other than the network's.
    pub own_tip: Option<usize>,
    /// Way of the tip along its travel for a way of 1 across the surface: a probe scatters along its travel, which at an oblique
    /// touch counts less across the surface. 1 where it is touched at right angles.
    pub weight: f64,
}

/// Equation of a touch at the present values of the unknowns: the residual, mm, and its derivatives.
pub(super) struct Row {
    pub(super) residual: f64,
    pub(super) derivatives: Vec<(usize, f64)>,
    /// Derivative with respect to the tip's position.
    pub(super) across: [f64; 3],
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A vector rotated by an axis times its angle (Rodrigues): a tilted plate keeps its length.
fn turned(vector: [f64; 3], turn: [f64; 3]) -> [f64; 3] {
    let angle = dot(turn, turn).sqrt();
    let half = 0.5 * angle;
    let sinc = |angle: f64| if angle > 1e-9 { angle.sin() / angle } else { 1.0 };
    let (once, twice) = (cross(turn, vector), cross(turn, cross(turn, vector)));
    std::array::from_fn(|k| vector[k] + sinc(angle) * once[k] + 0.5 * sinc(half) * sinc(half) * twice[k])
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

impl Centre {
    /// Residual and gradient of a point; its derivatives are added to `derivatives`.
    ///
    /// ```text
    /// w n · (p − Σ u_k (o + R ((1 + λ) a + b))_k)      a nominal, b its deviation, R the rotation, λ the elongation, w the weight
    /// ```
    fn row(&self, point: [f64; 3], of: impl Fn(usize) -> f64, derivatives: &mut Vec<(usize, f64)>) -> (f64, [f64; 3]) {
        let Centre { plane, origin, offset, own, length, along, weight } = self;
        let (sin, cos) = of(origin + 2).sin_cos();
        let turned = |[a, b]: [f64; 2]| [cos * a - sin * b, sin * a + cos * b];
        let at = |k: usize| (1.0 + of(*length)) * offset[k] + own.map_or(0.0, |own| of(own + k));
        let [x, y] = turned([at(0), at(1)]);
        let across = [0, 1].map(|k| weight * dot(*along, plane[k]));
        let projected = |[a, b]: [f64; 2]| across[0] * a + across[1] * b;
        derivatives.extend([
            (*origin, -across[0]),
            (origin + 1, -across[1]),
            (origin + 2, -projected([-y, x])),
            (*length, -projected(turned(*offset))),
        ]);
        if let Some(own) = *own {
            derivatives.extend([(own, -projected([cos, sin])), (own + 1, -projected([-sin, cos]))]);
        }
        let residual = projected([0, 1].map(|k| dot(point, plane[k]) - of(origin + k))) - projected([x, y]);
        (residual, along.map(|part| weight * part))
    }
}

impl Touch {
    /// The row of the touch; `tip` is the index of the radius of the network's tip.
    pub(super) fn row(&self, values: &[f64], tip: usize) -> Row {
        let of = |index: usize| values.get(index).copied().unwrap_or_default();
        let tip = self.own_tip.unwrap_or(tip);
        let mut point = self.tip_mm;
        for (term, response) in self.response.iter().enumerate() {
            (0..3).for_each(|k| point[k] += of(term) * response[k]);
        }
        for (knot, weight) in &self.drift {
            (0..3).for_each(|k| point[k] -= weight * of(knot + k));
        }
        let mut derivatives = Vec::with_capacity(self.response.len() + 16);
        let (residual, gradient) = match &self.surface {
            Surface::Bore { diameter, centre, plane } => {
                let across = [0, 1].map(|k| dot(point, plane[k]) - of(centre + k));
                let distance = across[0].hypot(across[1]).max(f64::MIN_POSITIVE);
                let unit = across.map(|part| part / distance);
                derivatives.extend([(*centre, -unit[0]), (centre + 1, -unit[1]), (*diameter, -0.5), (tip, 1.0)]);
                let gradient = std::array::from_fn(|k| unit[0] * plane[0][k] + unit[1] * plane[1][k]);
                (distance + of(tip) - 0.5 * of(*diameter), gradient)
            }
            Surface::Ball { diameter, origin, offset, turn, own, length } => {
                let [x, y, z] = match *turn {
                    Some(turn) => turned(*offset, [of(turn), of(turn + 1), of(turn + 2)]),
                    None => *offset,
                };
                let longer = 1.0 + length.map_or(0.0, of);
                let mut centre: [f64; 3] = std::array::from_fn(|k| of(origin + k) + longer * [x, y, z][k]);
                if let Some(own) = *own {
                    (0..3).for_each(|k| centre[k] += of(own[k]));
                }
                let from: [f64; 3] = std::array::from_fn(|k| point[k] - centre[k]);
                let distance = dot(from, from).sqrt().max(f64::MIN_POSITIVE);
                let unit = from.map(|part| part / distance);
                for k in 0..3 {
                    derivatives.push((origin + k, -unit[k]));
                    derivatives.extend(own.map(|own| (own[k], -unit[k])));
                }
                if let Some(turn) = *turn {
                    let [u, v, w] = unit;
                    derivatives.extend([
                        (turn, -(v * -z + w * y)),
                        (turn + 1, -(u * z - w * x)),
                        (turn + 2, -(v * x - u * y)),
                    ]);
                }
                derivatives.extend(length.map(|length| (length, -dot(unit, [x, y, z]))));
                derivatives.extend([(*diameter, -0.5), (tip, -1.0)]);
                (distance - 0.5 * of(*diameter) - of(tip), unit)
            }
            Surface::Centre(centre) => centre.row(point, of, &mut derivatives),
            Surface::Face { normal, outward, known_mm, parts } => {
                let mut away = dot(*normal, point) - known_mm;
                let mut across = *normal;
                for part in parts {
                    let lever = part.factor * part.along.map_or(1.0, |along| dot(along, point));
                    away -= of(part.unknown) * lever;
                    if let Some(along) = part.along {
                        (0..3).for_each(|k| across[k] -= of(part.unknown) * part.factor * along[k]);
                    }
                    derivatives.push((part.unknown, -outward * lever));
                }
                derivatives.push((tip, -1.0));
                (outward * away - of(tip), across.map(|part| outward * part))
            }
        };
        derivatives.extend(self.response.iter().map(|response| dot(gradient, *response)).enumerate());
        for (knot, weight) in &self.drift {
            derivatives.extend((0..3).map(|k| (knot + k, -weight * gradient[k])));
        }
        let weight = self.weight;
        derivatives.iter_mut().for_each(|(_, derivative)| *derivative *= weight);
        Row { residual: weight * residual, derivatives, across: gradient.map(|part| weight * part) }
    }
}
