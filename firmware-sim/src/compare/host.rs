//! Replay of a recording on the host.

use super::outputs::AXES;
use super::warming::Heating;
use anyhow::{Result, anyhow};
use trueaxis::contour::{Path, Span};
use trueaxis::machine::AxisOrder;
use trueaxis::roundness::{Gauge, GaugeState};
use trueaxis::tcomp::Tcomp;
use trueaxis::telemetry::RoundnessFrame;
use trueaxis::temperature::Growth;
use trueaxis::{GaugeRide, ServoLoop};
use trueaxis_recording::Recording;
use trueaxis_recording::outputs::{Wire, line};
use trueaxis_recording::warming::Warming;
use trueaxis_sim::servo::with_tables;

/// Points per revolution of the gauge, as in the image.
const POINTS: usize = 1024;

/// The host's equivalents of the image's output.
#[derive(Debug, Default)]
pub struct Replayed {
    /// Outputs of the step, byte for byte.
    pub outputs: Vec<u8>,
    /// One frame per evaluated revolution.
    pub revolutions: Vec<RoundnessFrame>,
    /// Every thermal growth that took effect.
    pub growths: Vec<Growth>,
}

/// Runs a recording through the step in scalar `R`. The second table file, if given, is in force from its cycle on; thermal
/// growth follows the readings of `warming`.
///
/// # Errors
/// The recording or a table file is refused.
pub fn replay<R: Wire>(
    recording: &[u8],
    tables: &[u8],
    second: Option<(&[u8], u32)>,
    warming: Option<&[u8]>,
) -> Result<Replayed> {
    let recording = Recording::<AXES>::parse(recording).map_err(|e| anyhow!("recording: {e}"))?;
    let period_ns = recording.header().period_ns;
    let file = Tcomp::parse(tables).map_err(|e| anyhow!("tables: {e}"))?;
    let warming = warming.map(|bytes| Warming::parse(bytes, file.machine_id())).transpose();
    let warming = warming.map_err(|e| anyhow!("growth: {e}"))?;
    with_tables(&file, period_ns, |first| match second {
        None => run::<R>(&recording, &file, first, None, warming),
        Some((bytes, at)) => {
            let other = Tcomp::parse(bytes).map_err(|e| anyhow!("second tables: {e}"))?;
            with_tables(&other, period_ns, |second| run::<R>(&recording, &file, first, Some((second, at)), warming))
        }
    })
}

/// A step in a scalar with its position type.
type Loop<'a, R> = ServoLoop<'a, R, <R as Wire>::Place, AXES>;

fn run<R: Wire>(
    recording: &Recording<'_, AXES>,
    file: &Tcomp<'_>,
    first: &Loop<'_, R>,
    exchanged: Option<(&Loop<'_, R>, u32)>,
    warming: Option<Warming<'_>>,
) -> Result<Replayed> {
    let period_ns = recording.header().period_ns;
    let path: Vec<Span<R, R::Place>> = recording.path().collect();
    let path = Path::new(&path, 0, false);
    let mut state = first.start();
    let axes = AxisOrder::<AXES>::of(file.settings()).map_err(|e| anyhow!("tables: {e}"))?.axes();
    let mut heating = warming.map(Heating::new);
    let gauge = match file.settings().roundness.filter(|_| recording.header().gauge) {
        None => None,
        Some(settings) => {
            Some(Box::new(Gauge::<R, POINTS>::build(&settings, period_ns).map_err(|e| anyhow!("gauge: {e}"))?))
        }
    };
    let mut gauge_state = Box::new(GaugeState::<R, POINTS>::new());
    let mut replayed = Replayed::default();
    for number in 0..recording.header().cycles {
        let Some(cycle) = recording.cycle(number) else { break };
        let servo = match exchanged {
            Some((second, at)) if number >= at => second,
            _ => first,
        };
        if let Some(growth) = heating.as_mut().and_then(|heating| heating.cycle(number, period_ns)) {
            for (slot, axis) in axes.into_iter().enumerate() {
                if let Some(line) = growth.line(axis) {
                    state.set_thermal(slot, line).expect("a slot of the step");
                }
            }
            replayed.growths.push(growth);
        }
        let (input, reference) = (cycle.input::<R::Place>(), cycle.place::<R>());
        let Some(gauge) = &gauge else {
            replayed.outputs.extend(line(&servo.step(&mut state, &input, path.on(reference), ()), None));
            continue;
        };
        let probes = cycle.probes();
        let mut ride = GaugeRide::new(gauge, &mut gauge_state, &probes);
        let output = servo.step(&mut state, &input, path.on(reference), &mut ride);
        let gauged = ride.cycle();
        replayed.outputs.extend(line(&output, Some(gauged.infeed)));
        if gauged.finished {
            replayed.revolutions.extend(RoundnessFrame::of(file.machine_id(), gauge, &gauge_state));
        }
    }
    Ok(replayed)
}
