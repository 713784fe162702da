//! One cycle of a recording.

use trueaxis::contour::Reference;
use trueaxis::roundness::Probes;
use trueaxis::{Input, Nanometres, Position, Real};

/// A position that a recording can represent exactly.
pub trait Integer: Position {
    /// Converts from 1e-6 mm (1e-6 degree); unusable values stay unusable.
    fn of_nanometres(nanometres: Nanometres) -> Self;
}

impl Integer for Nanometres {
    fn of_nanometres(nanometres: Nanometres) -> Nanometres {
        nanometres
    }
}

impl Integer for f64 {
    fn of_nanometres(nanometres: Nanometres) -> f64 {
        if nanometres.is_usable() { nanometres.to_f64() } else { f64::NAN }
    }
}

/// Inputs of the gauge in one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Probe {
    /// Raw values of the three probes.
    pub readings: [f32; 3],
    /// Counts of the spindle's encoder.
    pub spindle: i32,
    /// Counts latched by an index pulse.
    pub index: Option<i32>,
}

/// Inputs of the step in one cycle of `N` axes.
///
/// | bytes | |
/// |---|---|
/// | 4 N | commands, i32, 1e-6 mm (1e-6 degree) |
/// | 4 N | readings, the same |
/// | 4 | elapsed time, ns |
/// | 4 | number of the span |
/// | 4 | position on it, f32, 0 to 1 |
/// | 1 | switches: 1 homed, 2 enable, 4 reset, 8 index pulse |
/// | 1 | a bit for every axis with an encoder alarm |
/// | 2 | zero |
/// | 20 | with a gauge: three readings f32, spindle i32, latched index i32 |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedCycle<const N: usize> {
    /// Commanded positions.
    pub command: [Nanometres; N],
    /// Encoder positions.
    pub feedback: [Nanometres; N],
    /// Time since the last cycle, ns.
    pub elapsed_ns: u32,
    /// Position on the path.
    pub reference: Reference<f32>,
    /// Whether all axes are homed.
    pub homed: bool,
    /// Whether compensation is requested.
    pub enable: bool,
    /// Whether to release a latched stop.
    pub reset: bool,
    /// Axes with an encoder alarm.
    pub encoder_alarm: u8,
    /// Inputs of the gauge; not stored in a recording without one.
    pub probe: Probe,
}

const HOMED: u8 = 1;
const ENABLE: u8 = 2;
const RESET: u8 = 4;
const INDEX: u8 = 8;

impl<const N: usize> RecordedCycle<N> {
    /// Number of bytes of a cycle.
    pub const fn bytes(gauge: bool) -> usize {
        8 * N + 16 + if gauge { 20 } else { 0 }
    }

    /// Input of the step.
    pub fn input<P: Integer>(&self) -> Input<P, N> {
        Input {
            command: self.command.map(P::of_nanometres),
            feedback: self.feedback.map(P::of_nanometres),
            encoder_alarm: self.encoder_alarm,
            elapsed_ns: self.elapsed_ns,
            homed: self.homed,
            enable: self.enable,
            reset: self.reset,
            refusal: trueaxis::sample::Refusal::NONE,
            dynamics: trueaxis::Dynamics::ALL,
            learned: [P::default(); 3],
        }
    }

    /// Reference of the step on the path.
    pub fn place<R: Real>(&self) -> Reference<R> {
        Reference { span: self.reference.span, t: R::of(f64::from(self.reference.t)) }
    }

    /// Input of the gauge.
    pub fn probes<R: Real>(&self) -> Probes<R> {
        Probes {
            readings: self.probe.readings.map(|value| R::of(f64::from(value))),
            spindle: self.probe.spindle,
            index: self.probe.index,
            ..Probes::default()
        }
    }

    pub(crate) fn decode(bytes: &[u8], gauge: bool) -> Option<Self> {
        let (words, rest) = bytes.as_chunks::<4>();
        let mut words = words.iter().copied();
        if !rest.is_empty() {
            return None;
        }
        let mut positions = || -> Option<[Nanometres; N]> {
            let mut all = [Nanometres(0); N];
            for nanometres in &mut all {
                *nanometres = Nanometres(i32::from_le_bytes(words.next()?));
            }
            Some(all)
        };
        let (command, feedback) = (positions()?, positions()?);
        let elapsed_ns = u32::from_le_bytes(words.next()?);
        let span = u32::from_le_bytes(words.next()?);
        let t = f32::from_le_bytes(words.next()?);
        let [switches, encoder_alarm, _, _] = words.next()?;
        let mut probe = Probe::default();
        if gauge {
            for reading in &mut probe.readings {
                *reading = f32::from_le_bytes(words.next()?);
            }
            probe.spindle = i32::from_le_bytes(words.next()?);
            let latched = i32::from_le_bytes(words.next()?);
            probe.index = (switches & INDEX != 0).then_some(latched);
        }
        Some(RecordedCycle {
            command,
            feedback,
            elapsed_ns,
            reference: Reference { span, t },
            homed: switches & HOMED != 0,
            enable: switches & ENABLE != 0,
            reset: switches & RESET != 0,
            encoder_alarm,
            probe,
        })
    }

    #[cfg(feature = "std")]
    pub(crate) fn encode(&self, gauge: bool, into: &mut std::vec::Vec<u8>) {
        for nanometres in self.command.iter().chain(&self.feedback) {
            into.extend(nanometres.0.to_le_bytes());
        }
        into.extend(self.elapsed_ns.to_le_bytes());
        into.extend(self.reference.span.to_le_bytes());
        into.extend(self.reference.t.to_le_bytes());
        let switch = |on: bool, bit: u8| if on { bit } else { 0 };
        let index = gauge && self.probe.index.is_some();
        let switches =
            switch(self.homed, HOMED) | switch(self.enable, ENABLE) | switch(self.reset, RESET) | switch(index, INDEX);
        into.extend([switches, self.encoder_alarm, 0, 0]);
        if gauge {
            for reading in self.probe.readings {
                into.extend(reading.to_le_bytes());
            }
            into.extend(self.probe.spindle.to_le_bytes());
            into.extend(self.probe.index.unwrap_or(0).to_le_bytes());
        }
    }
}
