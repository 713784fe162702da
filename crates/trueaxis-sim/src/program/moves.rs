//! Motion words: lines, arcs, NURBS, in program or (G53) machine coordinates.

use super::arc::{ArcWords, Plane};
use super::block::{AXIS_LETTERS, Block, CANCEL};
use super::builder::Pace;
use super::curve::Curve;
use super::error::Refusal;
use super::interpreter::Interpreter;
use super::modal::{g, m};
use super::nurbs_block::NurbsBlock;

const CUBIC: u16 = 50;
const QUADRATIC: u16 = 51;
const NURBS: u16 = 52;
const NURBS_END: u16 = 53;

impl Interpreter<'_> {
    /// Executes the motion of a line, if any.
    pub(super) fn go(&mut self, block: &mut Block) -> Result<(), Refusal> {
        let line = block.line;
        let explicit = block.g[g::MOTION];
        if explicit == Some(CANCEL) {
            self.rapid_after_cancel = match self.motion {
                Some(730..=890) => self.before_cycle.is_none_or(|code| code == 0),
                motion => motion == Some(0),
            };
        } else if explicit.is_some_and(|code| code < 730) {
            self.before_cycle = explicit;
        }
        if let Some(code) = explicit {
            self.motion = Some(code).filter(|code| !matches!(*code, CANCEL | NURBS_END));
        }
        if explicit.is_some_and(|code| code != self.cycle.map_or(code, |cycle| cycle.code)) {
            self.cycle = None;
        }
        if !self.motion.is_some_and(|code| matches!(code, 730..=890 if code != CANCEL)) {
            self.cycle_start = None;
        }
        if self.motion != Some(CUBIC) {
            self.spline_end = None;
        }
        if block.g[g::ONCE] == Some(530) {
            return self.in_machine_coordinates(block);
        }
        let moving = block.has_axes();
        match explicit.filter(|code| *code == NURBS_END).or(self.motion) {
            Some(code @ (0 | 10)) if moving => {
                let pace = if code == 0 { Pace::Rapid } else { self.feed(line)? };
                let (end, _) = self.target(block);
                self.straight(line, pace, end)
            }
            Some(code @ 382..=385) if moving => self.probe(block, code),
            Some(382..=385) if explicit.is_some() => Err(Refusal::new(line, "G38 alone", "axis words with it")),
            Some(code @ (CUBIC | QUADRATIC)) if moving || block.has("IJPQ") || explicit.is_some() => {
                self.spline(block, code == CUBIC)
            }
            Some(code @ (20 | 30)) if moving || block.has("IJKR") || explicit.is_some() => self.arc(block, code == 20),
            Some(NURBS) if moving || block.has("PL") || explicit.is_some() => self.control_point(block),
            Some(NURBS_END) => self.close_nurbs(line),
            Some(code @ 730..=890) if moving => self.drill(block, code),
            Some(code @ 730..=890) if explicit.is_some() => {
                Err(Refusal::new(line, format!("G{} alone", code / 10), "axis words with a canned cycle"))
            }
            None if moving && self.rapid_after_cancel => {
                self.note(line, "axis words after G80", "move at rapid");
                let (end, _) = self.target(block);
                self.straight(line, Pace::Rapid, end)
            }
            _ => Ok(()),
        }
    }

    /// A straight move requested by the program.
    fn straight(&mut self, line: u32, pace: Pace, end: [f64; 6]) -> Result<(), Refusal> {
        if !self.builder.line_to(line, pace, end, self.plane.normal())? {
            self.note(line, "a move without length", "left out");
        }
        self.moved();
        Ok(())
    }

    /// G53: in this line only, the words are machine coordinates.
    fn in_machine_coordinates(&mut self, block: &mut Block) -> Result<(), Refusal> {
        let line = block.line;
        self.refuse_tool_center(line, "G53")?;
        let pace = match self.motion {
            Some(0) => Pace::Rapid,
            Some(10) => self.feed(line)?,
            _ => return Err(Refusal::new(line, "G53 without G0 or G1", "G0 or G1 in force or in the line")),
        };
        if self.incremental {
            return Err(Refusal::new(line, "G53 in G91", "G90"));
        }
        if self.options.offsets.is_none() {
            self.note(line, "G53", "the machine's zero is the program's zero without --offsets");
        }
        let mut end = self.builder.at;
        for (axis, letter) in AXIS_LETTERS.into_iter().enumerate() {
            if let Some(value) = block.take(letter) {
                end[axis] = if axis < 3 { self.mm(value) } else { value };
                self.needs_rotary(line, axis);
            }
        }
        self.straight(line, pace, end)
    }

    fn needs_rotary(&mut self, line: u32, axis: usize) {
        if let Some(first) = axis.checked_sub(3).and_then(|k| self.builder.first.rotary.get_mut(k)) {
            first.get_or_insert(line);
        }
    }

    /// Target of the axis words in machine coordinates, and the axes that they name.
    pub(super) fn target(&mut self, block: &mut Block) -> ([f64; 6], [bool; 6]) {
        let mut place = self.frame.to_program(self.builder.at);
        let mut given = [false; 6];
        for (axis, letter) in AXIS_LETTERS.into_iter().enumerate() {
            let Some(value) = block.take(letter) else { continue };
            let value = if axis < 3 { self.mm(value) } else { value };
            place[axis] = if self.incremental { place[axis] + value } else { value };
            given[axis] = true;
            self.needs_rotary(block.line, axis);
        }
        if let Some(polar) = self.polar(block, place, given) {
            [place[0], place[1]] = polar;
            (given[0], given[1]) = (true, true);
        }
        (self.keep_still(self.frame.to_machine(place), given), given)
    }

    /// X and Y by @ and ^: the radius and the angle about the program's zero, or what they grow by in G91. What is not given
    /// stays.
    fn polar(&self, block: &mut Block, [x, y, ..]: [f64; 6], given: [bool; 6]) -> Option<[f64; 2]> {
        // Beside X or Y they remain, and are refused. The origin has no angle.
        if given[0] || given[1] || ((self.incremental || !block.has("^")) && x == 0.0 && y == 0.0) {
            return None;
        }
        let (radius, angle) = (block.take('@').map(|radius| self.mm(radius)), block.take('^'));
        let before = if self.incremental { 1.0 } else { 0.0 };
        if radius.is_none() && angle.is_none() {
            return None;
        }
        let (here, direction) = (libm::hypot(x, y), libm::atan2(y, x));
        let radius = radius.map_or(here, |radius| radius + before * here);
        let angle = angle.map_or(direction, |angle| angle.to_radians() + before * direction);
        let (sine, cosine) = libm::sincos(angle);
        Some([radius * cosine, radius * sine])
    }

    /// Keeps axes that nothing moves where they are, to the last bit.
    fn keep_still(&self, mut end: [f64; 6], given: [bool; 6]) -> [f64; 6] {
        let turned = self.frame.rotation_deg != 0.0 && (given[0] || given[1]);
        for axis in 0..6 {
            if !(given[axis] || turned && axis < 2) {
                end[axis] = self.builder.at[axis];
            }
        }
        end
    }

    fn arc(&mut self, block: &mut Block, clockwise: bool) -> Result<(), Refusal> {
        let line = block.line;
        let pace = self.feed(line)?;
        let [x, y, z, ..] = self.frame.to_program(self.builder.at);
        let (machine_end, _) = self.target(block);
        let [ex, ey, ez, ..] = self.frame.to_program(machine_end);
        let words = ArcWords {
            line,
            clockwise,
            plane: self.plane,
            start: [x, y, z],
            end: [ex, ey, ez],
            center: ['I', 'J', 'K'].map(|letter| block.take(letter).map(|value| self.mm(value))),
            absolute_center: self.absolute_center,
            radius: block.take('R').map(|value| self.mm(value)),
            turns: block.take('P'),
        };
        let Curve::Arc { end, center, normal, turns, .. } = words.curve()? else { return Ok(()) };
        let start = self.builder.point();
        // Where offsets are added, end coordinates that the arc made equal to the start's remain equal.
        let end = if end == [ex, ey, ez] { std::array::from_fn(|k| machine_end[k]) } else { self.frame.point(end) };
        let same = |k: usize| (end[k] - start[k]).abs() < 1.0e-9;
        let end = std::array::from_fn(|k| if same(k) { start[k] } else { end[k] });
        let [.., a, b, c] = machine_end;
        let turn = self.builder.turn_to([a, b, c]);
        let curve =
            Curve::Arc { start, end, center: self.frame.point(center), normal: self.frame.direction(normal), turns };
        self.builder.push(line, pace, curve, turn, self.frame.direction(self.plane.normal()))?;
        self.moved();
        Ok(())
    }

    /// Within a NURBS only control points, F and G5.3 are allowed.
    pub(super) fn stay_in_nurbs(&self, block: &Block) -> Result<(), Refusal> {
        let line = block.line;
        if block.g[g::MOTION].is_some_and(|code| !matches!(code, NURBS | NURBS_END)) {
            return Err(Refusal::new(line, "another motion word within a NURBS", "control points or G5.3"));
        }
        let other = block.g.iter().enumerate().find_map(|(group, code)| code.filter(|_| group != g::MOTION));
        if let Some(code) = other {
            return Err(Refusal::new(
                line,
                format!("`G{}`", f64::from(code) / 10.0),
                "control points or G5.3 within a NURBS",
            ));
        }
        if block.m[m::STOP].is_some_and(|number| matches!(number, 2 | 30)) {
            return Err(Refusal::new(line, "the program's end within a NURBS", "G5.3"));
        }
        Ok(())
    }

    fn control_point(&mut self, block: &mut Block) -> Result<(), Refusal> {
        let line = block.line;
        if self.inverse_time {
            return Err(Refusal::new(line, "a NURBS in G93", "G94"));
        }
        self.feed(line)?;
        if self.plane != Plane::Xy {
            return Err(Refusal::new(line, format!("G5.2 in {}", self.plane.code()), "G17"));
        }
        if block.has("Z") {
            return Err(Refusal::new(line, "Z within a NURBS", "X and Y only"));
        }
        if block.has("ABC") {
            return Err(Refusal::new(line, "a rotary word within a NURBS", "X and Y only"));
        }
        // In G91 control points count from the start of the curve: the current point does not move until G5.3.
        let [x, y, z, ..] = self.frame.to_program(self.builder.at);
        let mut coordinate = |letter, start: f64| {
            block.take(letter).map(|value| if self.incremental { start + self.mm(value) } else { self.mm(value) })
        };
        let point = [coordinate('X', x), coordinate('Y', y)];
        let (weight, order) = (block.take('P'), block.take('L'));
        self.nurbs.get_or_insert_with(|| NurbsBlock::new(line, [x, y, z])).add(line, point, weight, order)
    }

    fn close_nurbs(&mut self, line: u32) -> Result<(), Refusal> {
        let Some(nurbs) = self.nurbs.take() else {
            return Err(Refusal::new(line, "G5.3 without G5.2", "G5.2 and control points before it"));
        };
        let pace = self.feed(line)?;
        let mut curve = nurbs.curve(line)?;
        if let Curve::Nurbs { points, .. } = &mut curve {
            points.iter_mut().for_each(|point| *point = self.frame.point(*point));
            if let Some(first) = points.first_mut() {
                *first = self.builder.point();
            }
        }
        let [.., a, b, c] = self.builder.at;
        let turn = self.builder.turn_to([a, b, c]);
        self.builder.push(line, pace, curve, turn, [0.0, 0.0, 1.0])?;
        self.moved();
        Ok(())
    }
}
