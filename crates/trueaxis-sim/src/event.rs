//! Events that switch the plugin, or a part of it, on or off while a program runs, or exchange its tables.
//!
//! | specification | effect |
//! |---|---|
//! | `off:correction@2.5s` | from 2.5 s on the plugin is disabled: its correction goes back to zero |
//! | `on:correction@3s` | it is enabled again |
//! | `off:friction@3s` | the same for a part of the dynamic correction: `friction`, `lag`, `acceleration`, `feedback`, `crosstalk`, `learned` or `take-up` |
//! | `on:trial@3s` | from 3 s on, friction, lag and acceleration are on trial ([`Dynamics::ON_TRIAL`]); off at the start |
//! | `off:adapt@3s` | the friction that adapts is frozen, with `on:adapt` it adapts again |
//! | `reset:adapt@3s` | the friction that adapts returns to the identified figures, and faults 12 and 13 are forgotten |
//! | `exchange:FOLDER@2s` | its tables are exchanged for those of the machine in that folder |
//!
//! An event acts before the first cycle at or after its time; events in one cycle act in the order in which they are listed.
//! Events do not change the plant, nor a machine whose plugin is disabled ([`Kind::Uncompensated`], [`Kind::ServoOnly`]).
//!
//! [`Kind::Uncompensated`]: crate::run::Kind::Uncompensated
//! [`Kind::ServoOnly`]: crate::run::Kind::ServoOnly

use crate::plant::fault::{Fault, FaultSpecError, seconds};
use crate::script::Script;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;
use trueaxis::Dynamics;

/// An event specification that cannot be understood.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("event \"{spec}\": found {found}, needed {needed}")]
pub struct EventSpecError {
    /// The specification as given.
    pub spec: String,
    /// The part that was not understood.
    pub found: String,
    /// An accepted form.
    pub needed: &'static str,
}

/// Target of a switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Switch {
    /// The plugin.
    Correction,
    /// One part of the plugin's dynamic correction, or the trial of its parts.
    Part(Dynamics),
    /// The adaptation of friction.
    Adaptation,
}

/// Names of the targets.
const SWITCHES: [(&str, Switch); 10] = [
    ("correction", Switch::Correction),
    ("friction", Switch::Part(Dynamics::FRICTION)),
    ("lag", Switch::Part(Dynamics::LAG)),
    ("acceleration", Switch::Part(Dynamics::ACCELERATION)),
    ("feedback", Switch::Part(Dynamics::FEEDBACK)),
    ("crosstalk", Switch::Part(Dynamics::CROSSTALK)),
    ("learned", Switch::Part(Dynamics::LEARNED)),
    ("take-up", Switch::Part(Dynamics::TAKE_UP)),
    ("trial", Switch::Part(Dynamics::ON_TRIAL)),
    (ADAPT, Switch::Adaptation),
];
const ADAPT: &str = "adapt";

impl Switch {
    /// All targets.
    pub const ALL: [Switch; 10] = {
        let mut all = [Switch::Correction; 10];
        let mut i = 0;
        while i < all.len() {
            all[i] = SWITCHES[i].1;
            i += 1;
        }
        all
    };

    /// Name in a specification.
    pub fn name(self) -> &'static str {
        SWITCHES.iter().find(|(_, switch)| *switch == self).map_or("", |(name, _)| name)
    }
}

/// Effect of an event.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// Switches something on.
    On(Switch),
    /// Switches something off.
    Off(Switch),
    /// Returns the friction that adapts to the identified figures.
    ResetAdaptation,
    /// Exchanges the tables for those of the machine of this name: its folder, for a scenario in a file.
    Exchange(String),
}

/// An event and its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Effect.
    pub kind: EventKind,
    /// Time, s from the start of the program.
    pub at_s: f64,
}

impl FromStr for Event {
    type Err = EventSpecError;

    fn from_str(spec: &str) -> Result<Event, EventSpecError> {
        let wrong =
            |found: &str, needed| EventSpecError { spec: spec.to_owned(), found: format!("\"{found}\""), needed };
        // A folder may have an @ in its name.
        let (what, time) = spec.trim().rsplit_once('@').ok_or_else(|| wrong(spec, "EVENT:WHAT@TIMEs"))?;
        let at_s = seconds(time).ok_or_else(|| wrong(time, "a time such as 1.25s, 0 to 1e6 s"))?;
        let (name, of) = what.split_once(':').ok_or_else(|| wrong(what, "EVENT:WHAT, such as off:correction"))?;
        let of = of.trim();
        let switch = || {
            let found = SWITCHES.iter().find(|(name, _)| *name == of).map(|(_, switch)| *switch);
            found.ok_or_else(|| {
                let needed =
                    "correction, friction, lag, acceleration, feedback, crosstalk, learned, take-up, trial or adapt";
                wrong(of, needed)
            })
        };
        let kind = match name.trim() {
            "on" => EventKind::On(switch()?),
            "off" => EventKind::Off(switch()?),
            "reset" if of != ADAPT => return Err(wrong(of, "adapt")),
            "reset" => EventKind::ResetAdaptation,
            "exchange" if of.is_empty() => return Err(wrong(what, "a machine's folder after exchange:")),
            "exchange" => EventKind::Exchange(of.to_owned()),
            other => return Err(wrong(other, "on, off, reset or exchange")),
        };
        Ok(Event { kind, at_s })
    }
}

/// Writes a specification that parses to the same event.
impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.kind {
            EventKind::On(switch) => write!(f, "on:{}@{}s", switch.name(), self.at_s),
            EventKind::Off(switch) => write!(f, "off:{}@{}s", switch.name(), self.at_s),
            EventKind::ResetAdaptation => write!(f, "reset:{ADAPT}@{}s", self.at_s),
            EventKind::Exchange(folder) => write!(f, "exchange:{folder}@{}s", self.at_s),
        }
    }
}

/// All events of a run.
pub type EventScript = Script<Event>;

impl EventScript {
    /// Names of the machines whose tables are required.
    pub fn exchanges(&self) -> impl Iterator<Item = &str> {
        self.items.iter().filter_map(|event| match &event.kind {
            EventKind::Exchange(name) => Some(name.as_str()),
            EventKind::On(_) | EventKind::Off(_) | EventKind::ResetAdaptation => None,
        })
    }
}

/// An intervention in a run: in its plant or its plugin.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// A fault of the plant, as in [`crate::plant::fault`].
    Fault(Fault),
    /// An event of the plugin.
    Event(Event),
}

/// An act that cannot be understood.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ActSpecError {
    /// The error of reading it as a fault.
    #[error(transparent)]
    Fault(#[from] FaultSpecError),
    /// The error of reading it as an event.
    #[error(transparent)]
    Event(#[from] EventSpecError),
}

impl FromStr for Act {
    type Err = ActSpecError;

    fn from_str(spec: &str) -> Result<Act, ActSpecError> {
        let name = spec.split(':').next().unwrap_or("").trim();
        Ok(match name {
            "on" | "off" | "reset" | "exchange" => Act::Event(spec.parse()?),
            _ => Act::Fault(spec.parse()?),
        })
    }
}

impl fmt::Display for Act {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Act::Fault(fault) => fault.fmt(f),
            Act::Event(event) => event.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_read_and_written_back() {
        let specs = [
            "off:correction@2.5s",
            "on:correction@3s",
            "exchange:a@b/mine@0.1s",
            "off:take-up@0s",
            "on:trial@0s",
            "reset:adapt@1s",
        ];
        let script = EventScript::parse(specs).unwrap();
        assert_eq!(Vec::from(script.clone()), specs);
        assert_eq!(script.items[0], Event { kind: EventKind::Off(Switch::Correction), at_s: 2.5 });
        assert_eq!(script.exchanges().collect::<Vec<_>>(), ["a@b/mine"]);
        for switch in Switch::ALL {
            let event = Event { kind: EventKind::On(switch), at_s: 0.1 + 0.2 };
            assert_eq!(event.to_string().parse(), Ok(event));
        }
        assert!(matches!("late@3s+1=2.5".parse(), Ok(Act::Fault(_))));
        assert!(matches!(" off:lag @ 3s ".parse(), Ok(Act::Event(_))));
    }

    #[test]
    fn bad_specifications_say_what_is_needed() {
        for (spec, found, needed) in [
            ("off:correction", "off:correction", "EVENT:WHAT@TIMEs"),
            ("off:correction@2", "2", "a time such as 1.25s"),
            ("off:correction@-1s", "-1s", "0 to 1e6 s"),
            ("off@1s", "off", "EVENT:WHAT, such as off:correction"),
            ("off:brakes@1s", "brakes", "correction, friction"),
            ("exchange:@1s", "exchange:", "a machine's folder"),
            ("reset:friction@1s", "friction", "adapt"),
            ("swap:mine@1s", "swap", "on, off, reset or exchange"),
        ] {
            let error = spec.parse::<Event>().unwrap_err();
            assert_eq!(error.found, format!("\"{found}\""), "{spec}");
            assert!(error.to_string().contains(needed), "{error}");
        }
    }
}
