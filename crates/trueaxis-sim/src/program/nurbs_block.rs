//! G5.2 … G5.3: collects the control points of a NURBS.

use super::curve::Curve;
use super::error::Refusal;
use super::nurbs::MAX_DEGREE;

/// Order without an L word.
const DEFAULT_ORDER: usize = 3;

/// An open G5.2 block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NurbsBlock {
    /// Line of G5.2.
    pub(super) line: u32,
    order: usize,
    /// Whether the next line is that of G5.2.
    first: bool,
    points: Vec<[f64; 3]>,
    weights: Vec<f64>,
}

impl NurbsBlock {
    pub(super) fn new(line: u32, start: [f64; 3]) -> Self {
        NurbsBlock { line, order: DEFAULT_ORDER, first: true, points: vec![start], weights: vec![1.0] }
    }

    /// Adds the words of one line: X and Y (both or neither), P, and on the first line L.
    pub(super) fn add(
        &mut self,
        line: u32,
        point: [Option<f64>; 2],
        weight: Option<f64>,
        order: Option<f64>,
    ) -> Result<(), Refusal> {
        let first = std::mem::replace(&mut self.first, false);
        if let Some(order) = order {
            let highest = (MAX_DEGREE + 1) as f64;
            if !first || order.fract() != 0.0 || !(DEFAULT_ORDER as f64..=highest).contains(&order) {
                let needed = format!("a whole order from {DEFAULT_ORDER} to {highest}, on the line of G5.2");
                return Err(Refusal::new(line, format!("L{order}"), needed));
            }
            self.order = order as usize;
        }
        if let Some(weight) = weight
            && weight <= 0.0
        {
            return Err(Refusal::new(line, format!("P{weight}"), "a positive weight"));
        }
        match (point, weight) {
            ([Some(x), Some(y)], Some(weight)) => {
                let z = self.points.first().map_or(0.0, |start| start[2]);
                self.points.push([x, y, z]);
                self.weights.push(weight);
            }
            ([Some(_), Some(_)], None) => {
                return Err(Refusal::new(line, "a control point without P", "X Y and the weight P"));
            }
            ([None, None], Some(weight)) if first => self.weights[0] = weight,
            ([None, None], None) => {}
            _ => return Err(Refusal::new(line, "half a control point", "X and Y and the weight P")),
        }
        Ok(())
    }

    /// Closes the block at the line of G5.3.
    pub(super) fn curve(self, line: u32) -> Result<Curve, Refusal> {
        let NurbsBlock { order, points, weights, .. } = self;
        if points.len() < order {
            return Err(Refusal::new(
                line,
                format!("a NURBS of order {order} with {} control points, the current point included", points.len()),
                format!("at least {order} control points"),
            ));
        }
        let last = points.len() - order + 1;
        let knots = (0..points.len() + order).map(|i| (i + 1).saturating_sub(order).min(last) as f64).collect();
        Ok(Curve::Nurbs { degree: order - 1, knots, points, weights })
    }
}
