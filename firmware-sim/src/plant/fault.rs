//! Scripted faults: what goes wrong, on which axis, when, for how long.

use std::fmt;
use trueaxis::Axis;

/// What is injected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// The encoder gives nothing.
    Dropout,
    /// The reading is off by this, mm (deg).
    Glitch(f64),
    /// The reading stands still.
    Stuck,
    /// The cycle comes this many periods after the last.
    Late(f64),
    /// The command is not a number.
    NanCommand,
    /// The command is off by this, mm (deg).
    JumpCommand(f64),
}

/// One injected fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Injection {
    /// What.
    pub kind: Kind,
    /// On which axis (X for faults that have none).
    pub axis: Axis,
    /// When it starts, seconds.
    pub at_s: f64,
    /// For how many cycles.
    pub cycles: u64,
}

/// A fault specification that makes no sense.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FaultSpecError {
    /// The specification.
    pub spec: String,
    /// What was found in it.
    pub found: String,
    /// What is needed there.
    pub needed: &'static str,
}

impl fmt::Display for FaultSpecError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fault \"{}\": found \"{}\", needed {}", self.spec, self.found, self.needed)
    }
}

impl std::error::Error for FaultSpecError {}

/// How a fault is written: `dropout:X@1.25s+3`, `glitch:Y@0.5s+1=5mm`, `stuck:Z@2s+200`, `late@3s+1=2.5`,
/// `nan-command:X@2s+1`, `jump-command:X@2s+1=3mm` (kind, axis, start, cycles, size).
pub const SYNTAX: &str = "KIND[:AXIS]@STARTs+CYCLES[=SIZE], e.g. dropout:X@1.25s+3, glitch:Y@0.5s+1=5mm, late@3s+1=2.5";

impl std::str::FromStr for Injection {
    type Err = FaultSpecError;

    fn from_str(spec: &str) -> Result<Injection, FaultSpecError> {
        let error = |found: &str, needed| FaultSpecError { spec: spec.into(), found: found.into(), needed };
        let (what, when) = spec.split_once('@').ok_or_else(|| error(spec, SYNTAX))?;
        let (name, axis) = match what.split_once(':') {
            Some((name, axis)) => (name, Some(axis)),
            None => (what, None),
        };
        let (when, size) = match when.split_once('=') {
            Some((when, size)) => (when, Some(size)),
            None => (when, None),
        };
        let (start, cycles) = when.split_once('+').unwrap_or((when, "1"));
        let at_s = start
            .strip_suffix('s')
            .and_then(|s| s.parse::<f64>().ok())
            .filter(|s| s.is_finite() && *s >= 0.0)
            .ok_or_else(|| error(start, "a start in seconds, e.g. 1.25s"))?;
        let cycles = cycles
            .parse::<u64>()
            .ok()
            .filter(|n| *n > 0)
            .ok_or_else(|| error(cycles, "a number of cycles, at least 1"))?;
        let number = |needed: &'static str| {
            let text = size.ok_or_else(|| error("", needed))?;
            text.trim_end_matches("mm")
                .trim_end_matches("deg")
                .parse::<f64>()
                .ok()
                .filter(|x| x.is_finite())
                .ok_or_else(|| error(text, needed))
        };
        let kind = match name {
            "dropout" => Kind::Dropout,
            "glitch" => Kind::Glitch(number("a size, e.g. =5mm")?),
            "stuck" => Kind::Stuck,
            "late" => Kind::Late(number("a number of periods, e.g. =2.5")?),
            "nan-command" => Kind::NanCommand,
            "jump-command" => Kind::JumpCommand(number("a size, e.g. =3mm")?),
            other => return Err(error(other, "dropout, glitch, stuck, late, nan-command or jump-command")),
        };
        let axis = match (axis, kind) {
            (None, Kind::Late(_)) => Axis::X,
            (None, _) => return Err(error("", "an axis, e.g. dropout:X@…")),
            (Some(letter), _) => {
                let mut letters = letter.chars();
                match (letters.next().and_then(Axis::from_letter), letters.next()) {
                    (Some(axis), None) => axis,
                    _ => return Err(error(letter, "one of X Y Z A B C")),
                }
            }
        };
        Ok(Injection { kind, axis, at_s, cycles })
    }
}

impl Injection {
    /// Whether it acts in a cycle.
    pub fn acts(&self, cycle: u64, period_s: f64) -> bool {
        let first = (self.at_s / period_s).round() as u64;
        (first..first + self.cycles).contains(&cycle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_it_documents() {
        let injection: Injection = "glitch:Y@0.5s+2=5mm".parse().unwrap();
        assert_eq!(injection, Injection { kind: Kind::Glitch(5.0), axis: Axis::Y, at_s: 0.5, cycles: 2 });
        assert!(injection.acts(5000, 1e-4) && injection.acts(5001, 1e-4));
        assert!(!injection.acts(4999, 1e-4) && !injection.acts(5002, 1e-4));
        assert_eq!("late@3s=2.5".parse::<Injection>().unwrap().kind, Kind::Late(2.5));
        assert_eq!("dropout:C@1s+3".parse::<Injection>().unwrap().axis, Axis::C);
    }

    #[test]
    fn refuses_the_rest_and_says_why() {
        for bad in [
            "",
            "dropout",
            "dropout@1s",
            "dropout:Q@1s",
            "dropout:XY@1s",
            "dropout:X@1",
            "dropout:X@-1s",
            "dropout:X@nans",
            "dropout:X@1s+0",
            "dropout:X@1s+x",
            "glitch:X@1s",
            "glitch:X@1s=inf",
            "fire:X@1s",
        ] {
            let error = bad.parse::<Injection>().unwrap_err();
            assert!(error.to_string().contains("needed"), "{error}");
        }
    }
}
