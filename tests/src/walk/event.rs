//! Disturbances of a cycle.

macro_rules! events {
    ($($name:ident: $text:literal,)*) => {
        /// A kind of disturbance.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Event {
            $(#[doc = $text] $name,)*
        }

        impl Event {
            /// All events.
            pub const ALL: &'static [Event] = &[$(Event::$name),*];

            /// Description of the event.
            pub const fn text(self) -> &'static str {
                match self { $(Event::$name => $text),* }
            }
        }
    };
}

events! {
    WildCommand: "a command that is anything",
    Jump: "a command that jumps",
    OutOfTravel: "a command out of the travel",
    WildReading: "readings that are anything",
    ReadingJumps: "a reading that jumps",
    Alarm: "an encoder alarm",
    Stuck: "a reading that stands",
    Late: "a late cycle",
    Early: "a doubled cycle",
    Disable: "compensation switched off",
    Unhomed: "not homed, commands set again",
    Exchange: "another configuration",
    Thermal: "thermal growth set",
    Reset: "a reset for no reason, held down at times",
    Switches: "parts of the dynamic correction switched",
    Learned: "a learned correction, wild at times",
    Reference: "a reference that is anywhere",
    Probes: "probe readings that are anything",
    Gauge: "new part, idle wheel, lost index, spindle turned back",
    Refusal: "a command refused before the step, a tool that is none",
    Ends: "to the end of a travel",
    Everything: "every field of the input anything at once",
    Measure: "another reference of the contour error, the window restarted",
}

/// A set of events as bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Events(pub u32);

impl Events {
    /// The set of all events.
    pub const ALL: Events = Events((1 << Event::ALL.len()) - 1);

    /// Whether the set contains an event.
    pub const fn has(self, event: Event) -> bool {
        self.0 >> event as u8 & 1 == 1
    }

    /// The set without an event.
    #[must_use]
    pub const fn without(self, event: Event) -> Events {
        Events(self.0 & !(1 << event as u8))
    }
}
