//! G5 and G5.1: a cubic or quadratic curve in XY by its control points, as in LinuxCNC.

use super::arc::Plane;
use super::block::Block;
use super::curve::Curve;
use super::error::Refusal;
use super::interpreter::Interpreter;

impl Interpreter<'_> {
    /// G5 X Y I J P Q: I J from the start to the second control point, P Q from the end to the third; a G5 after another
    /// continues its direction without I J. G5.1 X Y I J: a single point between them.
    pub(super) fn spline(&mut self, block: &mut Block, cubic: bool) -> Result<(), Refusal> {
        let line = block.line;
        let name = if cubic { "G5" } else { "G5.1" };
        let refuse = |found: String, needed: &str| Err(Refusal::new(line, found, needed));
        let pace = self.feed(line)?;
        if self.plane != Plane::Xy {
            return refuse(format!("{name} in {}", self.plane.code()), "G17");
        }
        if block.has("ZABC") {
            return refuse(format!("Z or a rotary word with {name}"), "X and Y only");
        }
        let mut pair = |one, other| match (block.take(one), block.take(other)) {
            (Some(a), Some(b)) => Ok(Some([self.mm(a), self.mm(b)])),
            (None, None) => Ok(None),
            _ => Err(Refusal::new(line, format!("{name} with one of {one} and {other}"), "both or neither")),
        };
        let first = pair('I', 'J')?.or(if cubic { self.spline_end } else { None });
        let last = if cubic { pair('P', 'Q')? } else { None };
        let Some(first) = first.filter(|offset| cubic || *offset != [0.0; 2]) else {
            return refuse(format!("{name} without I and J"), "I and J, the direction at its start");
        };
        if cubic && last.is_none() {
            return refuse("G5 without P and Q".to_owned(), "P and Q, from its end to the control point before it");
        }
        let [x, y, z, ..] = self.frame.to_program(self.builder.at);
        let (end, _) = self.target(block);
        let [ex, ey, ..] = self.frame.to_program(end);
        let mut points = vec![self.builder.point(), self.frame.point([x + first[0], y + first[1], z])];
        points.extend(last.map(|[p, q]| self.frame.point([ex + p, ey + q, z])));
        points.push([end[0], end[1], end[2]]);
        let order = points.len();
        let knots = [vec![0.0; order], vec![1.0; order]].concat();
        let weights = vec![1.0; order];
        let [.., a, b, c] = self.builder.at;
        let turn = self.builder.turn_to([a, b, c]);
        self.builder.push(
            line,
            pace,
            Curve::Nurbs { degree: order - 1, knots, points, weights },
            turn,
            [0.0, 0.0, 1.0],
        )?;
        self.spline_end = last.map(|offset| offset.map(|value| -value));
        self.moved();
        Ok(())
    }
}
