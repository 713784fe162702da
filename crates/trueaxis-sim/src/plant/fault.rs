//! Scripted faults: kind, axis, time and duration.
//!
//! | specification | effect |
//! |---|---|
//! | `dropout:X@1.25s+3` | from 1.25 s on, 3 readings of X are missing (NaN, `valid` false) |
//! | `glitch:Y@0.5s+1=5.0mm` | one reading of Y is 5 mm too large |
//! | `stuck:Z@2s+200` | Z repeats its last reading for 200 cycles |
//! | `scale:X@0s+5000=0.5` | for 5000 cycles the reading of X shows half of its motion; −1: against it |
//! | `late@3s+1=2.5` | one cycle takes 2.5 periods |
//! | `nan-command:X@2s+1` | the commanded position of X is NaN once |
//! | `jump-command:X@2s+1=3mm` | the commanded position of X is 3 mm too large once |
//!
//! Lengths are `mm`, or `deg` for rotary axes. Faults of readings occur between the drive and the control: they do not disturb
//! the drive, which evaluates its encoder itself.

use crate::script::Script;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;
use trueaxis::machine::Axis;

/// A fault specification that cannot be understood.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("fault \"{spec}\": found {found}, needed {needed}")]
pub struct FaultSpecError {
    /// The specification as given.
    pub spec: String,
    /// The part that was not understood.
    pub found: String,
    /// An accepted form.
    pub needed: &'static str,
}

/// Kind of a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// The reading of an axis is missing.
    Dropout(Axis),
    /// The reading of an axis is off by this, mm (deg).
    Glitch(Axis, f64),
    /// The reading of an axis does not change.
    Stuck(Axis),
    /// The reading of an axis shows this multiple of its motion.
    Scale(Axis, f64),
    /// A cycle takes this many periods.
    Late(f64),
    /// The commanded position of an axis is NaN.
    NanCommand(Axis),
    /// The commanded position of an axis is off by this, mm (deg).
    JumpCommand(Axis, f64),
}

impl FaultKind {
    /// The affected axis; `None` for a late cycle.
    pub fn axis(&self) -> Option<Axis> {
        match *self {
            FaultKind::Dropout(axis)
            | FaultKind::Glitch(axis, _)
            | FaultKind::Stuck(axis)
            | FaultKind::Scale(axis, _)
            | FaultKind::NanCommand(axis)
            | FaultKind::JumpCommand(axis, _) => Some(axis),
            FaultKind::Late(_) => None,
        }
    }
}

/// One fault of a script.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// Kind of fault.
    pub kind: FaultKind,
    /// Start, s of plant time: the first cycle at or after it.
    pub at_s: f64,
    /// Duration in cycles.
    pub cycles: u64,
}

impl Fault {
    /// Whether the fault acts in cycle number `cycle` (0 is the first).
    pub fn acts_in(&self, cycle: u64, period_s: f64) -> bool {
        cycle.checked_sub(first_cycle(self.at_s, period_s)).is_some_and(|since| since < self.cycles)
    }
}

/// The first cycle at or after a time.
pub(crate) fn first_cycle(at_s: f64, period_s: f64) -> u64 {
    // Slightly below the quotient; otherwise 0.3 s would be cycle 3001 of a 10 kHz servo.
    (at_s / period_s * (1.0 - 1e-12)).ceil() as u64
}

/// A time such as `1.25s`, 0 to 1e6 s.
pub(crate) fn seconds(text: &str) -> Option<f64> {
    let seconds = text.trim().strip_suffix('s')?.parse().ok()?;
    (0.0..=1e6).contains(&seconds).then_some(seconds)
}

impl FromStr for Fault {
    type Err = FaultSpecError;

    fn from_str(spec: &str) -> Result<Fault, FaultSpecError> {
        let wrong =
            |found: &str, needed| FaultSpecError { spec: spec.to_owned(), found: format!("\"{found}\""), needed };
        let (what, rest) = spec.trim().split_once('@').ok_or_else(|| wrong(spec, "KIND:AXIS@TIMEs+CYCLES[=VALUE]"))?;
        let (time, rest) = rest.split_once('+').ok_or_else(|| wrong(rest, "TIMEs+CYCLES after '@'"))?;
        let (cycles, value) = rest.split_once('=').map_or((rest, None), |(cycles, value)| (cycles, Some(value)));

        let at_s = seconds(time).ok_or_else(|| wrong(time, "a time such as 1.25s, 0 to 1e6 s"))?;
        let cycles = cycles
            .trim()
            .parse::<u64>()
            .ok()
            .filter(|&count| count > 0)
            .ok_or_else(|| wrong(cycles, "a whole number of cycles, at least 1"))?;

        let (name, letter) =
            what.split_once(':').map_or((what.trim(), None), |(name, letter)| (name.trim(), Some(letter.trim())));
        let axis = || {
            let mut letters = letter.unwrap_or("").chars();
            match (letters.next().and_then(Axis::from_letter), letters.next()) {
                (Some(axis), None) => Ok(axis),
                _ => Err(wrong(what, "an axis after the kind, such as :X")),
            }
        };
        let length = |axis: Axis| {
            let unit = if axis.is_rotary() { "deg" } else { "mm" };
            let needed = if axis.is_rotary() { "a value such as =0.5deg" } else { "a value such as =5.0mm" };
            let text = value.ok_or_else(|| wrong(rest, needed))?;
            let number = text.trim().strip_suffix(unit).and_then(|number| number.trim().parse::<f64>().ok());
            number.filter(|number| number.is_finite()).ok_or_else(|| wrong(text, needed))
        };
        let without_value = |kind: FaultKind| match value {
            None => Ok(kind),
            Some(text) => Err(wrong(text, "no value for this kind of fault")),
        };
        let kind = match name {
            "dropout" => without_value(FaultKind::Dropout(axis()?))?,
            "stuck" => without_value(FaultKind::Stuck(axis()?))?,
            "nan-command" => without_value(FaultKind::NanCommand(axis()?))?,
            "glitch" => axis().and_then(|axis| Ok(FaultKind::Glitch(axis, length(axis)?)))?,
            "jump-command" => axis().and_then(|axis| Ok(FaultKind::JumpCommand(axis, length(axis)?)))?,
            "scale" => {
                let needed = "a multiple of the motion such as =0.5, -1000 to 1000";
                let text = value.ok_or_else(|| wrong(rest, needed))?;
                let multiple = text.trim().parse::<f64>().ok().filter(|multiple| multiple.abs() <= 1000.0);
                FaultKind::Scale(axis()?, multiple.ok_or_else(|| wrong(text, needed))?)
            }
            "late" => {
                if letter.is_some() {
                    return Err(wrong(what, "no axis: the whole cycle is late"));
                }
                let needed = "a number of periods such as =2.5, 1 to 1000";
                let text = value.ok_or_else(|| wrong(rest, needed))?;
                let periods = text.trim().parse::<f64>().ok().filter(|periods| (1.0..=1000.0).contains(periods));
                FaultKind::Late(periods.ok_or_else(|| wrong(text, needed))?)
            }
            _ => return Err(wrong(name, "dropout, glitch, stuck, scale, late, nan-command or jump-command")),
        };
        Ok(Fault { kind, at_s, cycles })
    }
}

/// Writes a specification that parses to the same fault.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, value) = match self.kind {
            FaultKind::Dropout(_) => ("dropout", None),
            FaultKind::Glitch(_, by) => ("glitch", Some(by)),
            FaultKind::Stuck(_) => ("stuck", None),
            FaultKind::Scale(_, multiple) => ("scale", Some(multiple)),
            FaultKind::Late(periods) => ("late", Some(periods)),
            FaultKind::NanCommand(_) => ("nan-command", None),
            FaultKind::JumpCommand(_, by) => ("jump-command", Some(by)),
        };
        f.write_str(name)?;
        if let Some(axis) = self.kind.axis() {
            write!(f, ":{}", axis.letter())?;
        }
        write!(f, "@{}s+{}", self.at_s, self.cycles)?;
        let unit = match self.kind {
            FaultKind::Glitch(axis, _) | FaultKind::JumpCommand(axis, _) => {
                if axis.is_rotary() {
                    "deg"
                } else {
                    "mm"
                }
            }
            _ => "",
        };
        value.map_or(Ok(()), |value| write!(f, "={value}{unit}"))
    }
}

/// All faults of a run; several that act at once act in this order.
pub type FaultScript = Script<Fault>;

impl FaultScript {
    /// The kinds that act in `cycle`.
    pub fn acting(&self, cycle: u64, period_s: f64) -> impl Iterator<Item = FaultKind> + '_ {
        self.items.iter().filter(move |fault| fault.acts_in(cycle, period_s)).map(|fault| fault.kind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_read() {
        let script = FaultScript::parse([
            "dropout:X@1.25s+3",
            "glitch:Y@0.5s+1=5.0mm",
            "stuck:Z@2s+200",
            "scale:B@0s+5000=-0.5",
            "late@3s+1=2.5",
            "nan-command:X@2s+1",
            "jump-command:C@2s+1=-3deg",
        ])
        .unwrap();
        let kinds: Vec<FaultKind> = script.items.iter().map(|fault| fault.kind).collect();
        assert_eq!(
            kinds,
            [
                FaultKind::Dropout(Axis::X),
                FaultKind::Glitch(Axis::Y, 5.0),
                FaultKind::Stuck(Axis::Z),
                FaultKind::Scale(Axis::B, -0.5),
                FaultKind::Late(2.5),
                FaultKind::NanCommand(Axis::X),
                FaultKind::JumpCommand(Axis::C, -3.0),
            ]
        );
        assert_eq!((script.items[0].at_s, script.items[0].cycles), (1.25, 3));
        assert_eq!(FaultScript::parse(Vec::from(script.clone())), Ok(script));
    }

    #[test]
    fn a_fault_acts_in_its_cycles_only() {
        for (time, first) in [("0s", 0), ("0.3s", 3000), ("1.25s", 12_500), ("0.00015s", 2)] {
            let fault: Fault = format!("dropout:X@{time}+3").parse().unwrap();
            let acting: Vec<u64> = (0..20_000).filter(|&cycle| fault.acts_in(cycle, 1e-4)).collect();
            assert_eq!(acting, [first, first + 1, first + 2], "{time}");
        }
    }

    #[test]
    fn bad_specifications_say_what_is_needed() {
        for (spec, found, needed) in [
            ("dropout", "dropout", "KIND:AXIS"),
            ("dropout:X@1s", "1s", "CYCLES"),
            ("dropout:Q@1s+1", "dropout:Q", "an axis"),
            ("dropout:XY@1s+1", "dropout:XY", "an axis"),
            ("dropout@1s+1", "dropout", "an axis"),
            ("dropout:X@1+1", "\"1\"", "1.25s"),
            ("dropout:X@-1s+1", "-1s", "1.25s"),
            ("dropout:X@NaNs+1", "NaNs", "1.25s"),
            ("dropout:X@1s+0", "\"0\"", "at least 1"),
            ("dropout:X@1s+1=2mm", "2mm", "no value"),
            ("glitch:X@1s+1", "\"1\"", "=5.0mm"),
            ("glitch:X@1s+1=2deg", "2deg", "=5.0mm"),
            ("glitch:C@1s+1=2mm", "2mm", "deg"),
            ("glitch:C@1s+1=infdeg", "infdeg", "deg"),
            ("scale:X@1s+1", "\"1\"", "=0.5"),
            ("scale:X@1s+1=2mm", "2mm", "multiple"),
            ("scale:X@1s+1=1e4", "1e4", "-1000 to 1000"),
            ("scale@1s+1=2", "scale", "an axis"),
            ("late:X@1s+1=2", "late:X", "no axis"),
            ("late@1s+1=0.5", "0.5", "1 to 1000"),
            ("vanish:X@1s+1", "vanish", "dropout"),
            ("", "\"\"", "KIND"),
        ] {
            let error = spec.parse::<Fault>().unwrap_err();
            assert!(error.found.contains(found) && error.needed.contains(needed), "{spec}: {error}");
        }
    }
}
