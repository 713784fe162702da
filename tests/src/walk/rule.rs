//! The rules of the contract, and the number of times each was checked.

macro_rules! rules {
    ($($name:ident: $text:literal,)*) => {
        /// A rule of the contract.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Rule {
            $(#[doc = $text] $name,)*
        }

        impl Rule {
            /// All rules.
            pub const ALL: &'static [Rule] = &[$(Rule::$name),*];

            /// Name in reports.
            pub const fn name(self) -> &'static str {
                match self { $(Rule::$name => stringify!($name)),* }
            }

            /// Text of the rule.
            pub const fn text(self) -> &'static str {
                match self { $(Rule::$name => $text),* }
            }
        }
    };
}

rules! {
    Sequence: "the number of the record counts every cycle, and wraps",
    Identity: "machine id and sum of the tables are those of the loop in force in this very cycle",
    Finite: "every number of output and record is finite, whatever came in",
    First: "the first cycle returns the command, bit for bit",
    Magnitude: "|c| <= C of the axis, c all that is added to the command",
    Slope: "|change of c| <= V in every cycle that is due",
    Acceleration: "|second difference of c| <= a over the cycles that are due; after a hold from rest",
    Pace: "a cycle is due once a period, less 0.1 %, has passed since the last due one; in others nothing moves",
    ExchangeSmooth: "C, V and a hold in the very cycle in which another configuration is adopted; limits lowered in motion are reached with a",
    DynamicMagnitude: "the dynamic correction stays within the magnitude of its limiter",
    DynamicSlope: "the dynamic correction stays within the slope of its limiter",
    DynamicAcceleration: "the dynamic correction stays within the acceleration of its limiter",
    GeometricLimits: "the geometric correction keeps the limits of the axis beside a dynamic one, while no limit binds",
    DriveIsSum: "drive = command + correction, bit for bit",
    FeedbackIsMeasured: "feedback for the host = reading less the correction sent before, bit for bit",
    Hold: "while a stop is requested, drive, record and correction stay constant, bit for bit",
    Freeze: "while a reading is refused, the correction comes to rest with a and stays constant",
    Disabled: "with the correction gone, a disabled step passes commands bit for bit",
    RampedOut: "switched off, the correction is gone within the time that its limits take",
    LimitedReported: "an axis is reported as limited where its correction is not the wanted one: switched off, where it is not zero; never while the output holds",
    Stops: "a bad command stops, in its own cycle, with its fault and its axis",
    StopsOnlyWhenDue: "a stop appears for no other reason",
    Latches: "a stop stays until a reset, with the fault that it began with",
    ResetReleases: "a reset near the held command with nothing else wrong releases",
    ResetOnlyNear: "a reset away from the held command, held down, or with a bad command does not",
    JointRange: "command plus correction stays within the joint's range while active, or the output holds",
    JointRangeOnlyWhenDue: "that stop appears only where the limits could have let the position leave the range",
    Reading: "a bad reading freezes, in its own cycle, with its fault and its axis; a late and an early cycle too",
    ReadingOnlyWhenDue: "nothing else freezes",
    ReadingInForce: "the reading of the record is the one that came, or the last good one of its axis",
    CommandInForce: "the command of the record is the one that came, or the held one",
    State: "active, frozen, stop and no output are reported as they are",
    NoOutput: "an output exists from the first usable command on, or once every axis has been read",
    AtEdge: "an axis is at the edge of its table beyond its ends, and not within",
    ContourReported: "an error is measured exactly where the record says so, and only while command and readings are plausible",
    ContourConsistent: "distance and vector agree, the foot is in its span, lengths are not negative, evaluations are bounded",
    FootOnPath: "reading − vector is the point of the path that span and parameter name",
    WindowEnds: "the window of commands ends at the newest accepted one",
    WindowJoined: "its spans are joined and in order",
    WindowNearest: "no error is larger, by more than chords differ from their spans, than the distance from the newest command",
    Orientation: "the error of the direction is reported only for a tool path, and is an angle of at most 180 degrees",
    Probes: "a probe out of range or not finite is reported, one in range is not",
    InfeedBound: "the infeed correction keeps its own bound, at every point and in every cycle",
    InfeedFrozen: "a revolution in which the infeed was limited or not followed changes nothing",
    GaugeCounts: "every whole revolution is evaluated, skipped or in work",
    PartsOff: "a part of the dynamic correction that is not configured, switched off or inactive wants nothing",
    NoDynamic: "a record has a dynamic part exactly where one is configured",
    Learned: "the learned part is the input's, bit for bit, as far as it is usable",
    FeedbackStands: "under a refused reading the contour feedback wants the value of its integral, which stays constant until its axis reverses",
    FeedbackOut: "the watch's flag stays until the feedback is switched off or a reset comes",
    Rtcp: "positions found for a tool bring it there; a tool that is refused stops with the refusal's fault",
    Copied: "a copied state gives the same bits, and `step` those of `step_into`",
    Twin: "exchanged for equal tables, the step continues with the same bits",
    Returns: "back at a fixed position, switched on from rest, the same bits as at the start: nothing drifts",
    Settles: "at standstill the correction is that of `correction_at`",
    Cancels: "and the modelled error where it leads is its negative",
    Repeats: "the same sequence gives the same bits",
    Foreign: "tables of another machine are refused, and damaged ones",
    Period: "another servo period is refused at the start",
    Bypass: "refused tables pass commands bit for bit, hold the last usable one and say why",
    Allocation: "no cycle touches the heap",
}

/// A broken rule, and the finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken {
    /// The rule.
    pub rule: Rule,
    /// The finding.
    pub found: String,
}

/// Number of times each rule was checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tally(pub [u64; Rule::ALL.len()]);

impl Default for Tally {
    fn default() -> Self {
        Tally([0; Rule::ALL.len()])
    }
}

impl Tally {
    /// Checks a rule; `holds` is the result.
    ///
    /// # Errors
    /// The rule does not hold.
    #[inline(always)]
    pub fn that(&mut self, rule: Rule, holds: bool, found: impl FnOnce() -> String) -> Result<(), Broken> {
        self.0[rule as usize] += 1;
        if holds { Ok(()) } else { Err(broken(rule, found)) }
    }

    /// Adds another's counts.
    pub fn add(&mut self, other: &Tally) {
        self.0.iter_mut().zip(&other.0).for_each(|(sum, count)| *sum += count);
    }

    /// Number of times the rule was checked.
    pub fn of(&self, rule: Rule) -> u64 {
        self.0[rule as usize]
    }

    /// Rules that were never checked.
    pub fn idle(&self) -> impl Iterator<Item = Rule> + '_ {
        Rule::ALL.iter().copied().filter(|rule| self.of(*rule) == 0)
    }
}

#[cold]
#[inline(never)]
fn broken(rule: Rule, found: impl FnOnce() -> String) -> Broken {
    Broken { rule, found: found() }
}
