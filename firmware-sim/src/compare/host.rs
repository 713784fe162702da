//! The recording on the host.

use super::outputs::{AXES, Wire, encode};
use anyhow::{Result, anyhow};
use trueaxis::compensation::Storage;
use trueaxis::contour::{Path, Span};
use trueaxis::roundness::{Roundness, RoundnessState};
use trueaxis::tcomp::Tcomp;
use trueaxis::telemetry::RoundnessFrame;
use trueaxis::{Axis, Config, ServoLoop};
use trueaxis_recording::Recording;

/// Points of the gauge's revolution, as in the image.
const POINTS: usize = 1024;

/// Runs a recording through the step in scalar `R`; the second table file, where there is one, from cycle `exchange` on.
///
/// Returns what the image sends in the same run, and a frame of every revolution evaluated.
///
/// # Errors
/// The recording or a table file is refused.
pub fn replay<R: Wire>(
    recording: &[u8],
    tables: &[u8],
    second: Option<(&[u8], u32)>,
) -> Result<(Vec<u8>, Vec<RoundnessFrame>)> {
    let recording = Recording::<AXES>::parse(recording).map_err(|e| anyhow!("recording: {e}"))?;
    let period_ns = recording.header().period_ns;
    let path: Vec<Span<R, R::Place>> = recording.path().collect();
    let path = Path::new(&path, 0, false);
    let file = Tcomp::parse(tables).map_err(|e| anyhow!("tables: {e}"))?;
    let first = build::<R>(&file, period_ns)?;
    let exchanged = match second {
        None => None,
        Some((bytes, at)) => {
            let file = Tcomp::parse(bytes).map_err(|e| anyhow!("second tables: {e}"))?;
            Some((build::<R>(&file, period_ns)?, at))
        }
    };
    let mut state = first.start(period_ns).map_err(|fault| anyhow!("the step refused to start: {fault:?}"))?;
    let gauge = match file.settings().roundness.filter(|_| recording.header().gauge) {
        None => None,
        Some(settings) => {
            Some(Box::new(Roundness::<R, POINTS>::build(&settings, period_ns).map_err(|e| anyhow!("gauge: {e}"))?))
        }
    };
    let mut gauge_state = Box::new(RoundnessState::<R, POINTS>::new());
    let mut sent = Vec::new();
    let mut revolutions = Vec::new();
    for number in 0..recording.header().cycles {
        let Some(cycle) = recording.cycle(number) else { break };
        let servo = match &exchanged {
            Some((second, at)) if number >= *at => second,
            _ => &first,
        };
        let (input, reference) = (cycle.input::<R::Place>(), cycle.place::<R>());
        let Some(gauge) = &gauge else {
            encode::<R>(&servo.step(&mut state, &input, &path, reference), None, &mut sent);
            continue;
        };
        let (output, ridden) =
            servo.step_with_gauge(&mut state, &input, &path, reference, gauge, &mut gauge_state, &cycle.probes());
        encode::<R>(&output, Some(ridden.infeed), &mut sent);
        if ridden.finished {
            revolutions.extend(RoundnessFrame::of(file.machine_id(), gauge, &gauge_state));
        }
    }
    Ok((sent, revolutions))
}

fn build<R: Wire>(file: &Tcomp<'_>, period_ns: u32) -> Result<ServoLoop<'static, R, R::Place, AXES>> {
    let rows = |axis: Axis| file.table(axis);
    let config = Config::of(file, period_ns);
    let need = config.requirement::<R, R::Place, AXES, _>(rows);
    // Two loops of one run: freed with the process.
    let storage = Storage {
        lines: vec![R::ZERO; need.lines].leak(),
        knots: vec![R::ZERO; need.knots].leak(),
        guide: vec![0; need.guide].leak(),
    };
    config.build::<R, R::Place, AXES, _>(rows, storage).map_err(|e| anyhow!("{e}"))
}
