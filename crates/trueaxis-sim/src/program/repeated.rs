//! Repetition of a program.

use super::{Curve, Move, Program, Turn};

/// Reason why a program cannot begin again where it ends.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{file}: found tool centre point control (G43.4) and turned axes {place}, needed a program that begins and ends \
without it or with A, B, C at zero"
)]
pub struct CannotRepeat {
    file: String,
    place: &'static str,
}

impl Program {
    /// Repeats the program `times` times: at its end the axes come to rest, return to its beginning at rapid, and it begins
    /// again.
    ///
    /// # Errors
    /// The program begins or ends under tool centre point control with rotary axes away from zero: its coordinates are turned
    /// with the workpiece there, and the return is not a line in them.
    pub fn repeated(&self, times: usize) -> Result<Program, CannotRepeat> {
        let (Some(first), Some(last)) = (self.moves.first(), self.moves.last()) else { return Ok(self.clone()) };
        let ends = [(first, first.turn.start, "in its first move"), (last, last.turn.end(), "in its last move")];
        for (element, angles, place) in ends {
            if element.tool_center && angles != [0.0; 3] {
                return Err(CannotRepeat { file: self.file.clone(), place });
            }
        }
        let (from, to) = (end(last), start(first));
        let turn = Turn { start: from.1, change: std::array::from_fn(|k| to.1[k] - from.1[k]) };
        let way_back = (from != to).then_some(Move {
            line: last.line,
            rapid: true,
            feed_per_min: 0.0,
            plane_normal: last.plane_normal,
            curve: Curve::Line { start: from.0, end: to.0 },
            turn,
            tool_center: false,
            stop: true,
            probe: false,
        });
        let mut once = self.moves.clone();
        if let Some(last) = once.last_mut() {
            last.stop = true;
        }
        let mut moves = Vec::with_capacity(times * (once.len() + 1));
        for time in 0..times {
            moves.extend(way_back.clone().filter(|_| time > 0));
            moves.extend_from_slice(&once);
        }
        Ok(Program { moves, ..self.clone() })
    }
}

fn start(element: &Move) -> ([f64; 3], [f64; 3]) {
    let (first, _) = element.curve.domain();
    (element.curve.derivatives(first).position, element.turn.start)
}

fn end(element: &Move) -> ([f64; 3], [f64; 3]) {
    let (_, last) = element.curve.domain();
    (element.curve.derivatives(last).position, element.turn.end())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{DWELL_CYCLES, Motion, MotionSettings};

    #[test]
    fn it_goes_back_and_begins_again() {
        let text = "G21 G90 F600\nG1 X1 A10\nG3 X3 I1\nG1 Y2\n";
        let once = Program::parse("p", text, "p.ngc").unwrap();
        let three = once.repeated(3).unwrap();
        assert_eq!(three.moves.len(), 11);
        for pair in three.moves.windows(2) {
            let (before, after) = (end(&pair[0]), start(&pair[1]));
            assert!((0..3).all(|k| (before.0[k] - after.0[k]).abs() < 1e-12 && before.1[k] == after.1[k]), "{pair:?}");
        }
        let back = &three.moves[3];
        assert!(back.rapid && back.stop && three.moves[2].stop && !three.moves[1].stop);
        assert_eq!((end(back), start(&three.moves[4])), (([0.0; 3], [0.0; 3]), ([0.0; 3], [0.0; 3])));
        assert_eq!(&three.moves[4..6], &once.moves[..2]);
        assert_eq!(once.repeated(1).unwrap().moves.len(), 3);
        // A program that ends where it begins needs no return.
        let closed = Program::parse("c", "G21 G90 F600\nG1 X1\nX0\n", "c.ngc").unwrap();
        assert_eq!(closed.repeated(5).unwrap().moves.len(), 10);
    }

    #[test]
    fn under_tool_centre_point_control_it_cannot() {
        let text = "G21 G90 F600\nG1 X1\nG43.4\nG1 X2 A1\n";
        let error = Program::parse("p", text, "p.ngc").unwrap().repeated(2).unwrap_err();
        assert!(
            error.to_string().starts_with("p.ngc: found tool centre point control (G43.4) and turned axes in its last")
        );
        // With the axes at zero, the mode changes nothing.
        let text = "G21 G90 F600\nG43.4\nG1 X1 A1\nG1 A0\n";
        let program = Program::parse("p", text, "p.ngc").unwrap().repeated(2).unwrap();
        assert_eq!((program.moves.len(), program.moves[2].tool_center), (5, false));
    }

    /// Three repetitions take three times as long plus the two returns.
    #[test]
    fn it_is_run() {
        let cycles = |times| {
            let program = Program::builtin("short-tour").unwrap().unwrap().repeated(times).unwrap();
            Motion::plan(&program, MotionSettings { period_s: 1e-3, ..MotionSettings::default() }).unwrap().cycles()
        };
        let [one, two, three] = [1, 2, 3].map(cycles);
        assert_eq!(three - two, two - one);
        let dwells = 2 * DWELL_CYCLES;
        assert!(two - one >= one - dwells, "{one} {two}");
    }
}
