//! The whole step over the recording.

use crate::arena::Arena;
use crate::forms::{AXES, FORMS, Machine, PreparedCycle, STAGES};
use crate::middle::Middle;
use cortex_m_semihosting::hprintln;
use trueaxis::contour::Path;
use trueaxis::{Real, State};
use trueaxis_cortex_m::regions;
use trueaxis_cortex_m::timer::Tally;
use trueaxis_recording::{Integer, Recording};

/// The recording in flash.
pub fn recording() -> Recording<'static, AXES> {
    match Recording::parse(regions::recording()) {
        Ok(recording) => recording,
        Err(error) => panic!("recording: {}", error),
    }
}

/// Passes every cycle of the recording to `run`; the second tables are in force from the cycle that requests them.
fn each<R: Real, P: Integer>(
    machine: &Machine<R, P>,
    arena: &mut Arena,
    mut run: impl FnMut(u32, &PreparedCycle<'_, R, P>),
) {
    let recording = recording();
    let header = recording.header();
    let spans: &[_] = arena.collect(recording.path::<R, P>());
    let mut cycle = machine.cycle(Path::new(spans, 0, false), header.period_ns);
    // All terms are counted on cubic tables, whatever the tables of the nine terms are.
    cycle.all_exchanged = true;
    machine.restart();
    for number in 0..header.cycles {
        let Some(recorded) = recording.cycle(number) else { break };
        cycle.exchanged |= header.exchange_at == Some(number);
        (cycle.input, cycle.reference, cycle.probes) = (recorded.input(), recorded.place(), recorded.probes());
        run(number, &cycle);
    }
}

/// Counts the recording.
pub fn all<R: Real, P: Integer>(scalar: &str, machine: &Machine<R, P>, arena: &mut Arena) {
    let mut whole = [(); FORMS].map(|()| Tally::default());
    let mut middle = [(); FORMS].map(|()| Middle::new(arena));
    let mut parts = STAGES.map(|_| Tally::default());
    let mut worst_at = (0, 0);
    let (mut evaluated, mut cycles) = (0, 0);
    each(machine, arena, |number, cycle| {
        let (taken, revolutions) = cycle.count(|_, _| ());
        evaluated += revolutions;
        cycles += 1;
        for (taken, (tally, middle)) in taken.into_iter().zip(whole.iter_mut().zip(&mut middle)) {
            tally.add(taken);
            middle.add(taken, number);
        }
        worst_at = worst_at.max((taken[0], number));
        for (taken, part) in cycle.stages().into_iter().zip(&mut parts) {
            part.add(taken);
        }
    });
    hprintln!("{} step typical {} {}", scalar, middle[0].value(), whole[0]);
    hprintln!("{} step_gauge typical {} {}", scalar, middle[1].value(), whole[1]);
    hprintln!("{} step_volumetric typical {} {}", scalar, middle[2].value(), whole[2]);
    for ((_, name), part) in STAGES.iter().zip(&parts) {
        hprintln!("{} stage_{} {}", scalar, name, part);
    }
    let typical_at = middle[0].first();
    hprintln!(
        "{} recording cycles {} worst_at {} typical_at {} revolutions {}",
        scalar,
        cycles,
        worst_at.1,
        typical_at,
        evaluated
    );
    hprintln!("{} state bytes {}", scalar, size_of::<State<R, P, AXES>>());
}

/// Runs the recording up to a cycle, in the bare form only.
pub fn replay<R: Real, P: Integer>(scalar: &str, machine: &Machine<R, P>, number: u32, arena: &mut Arena) {
    // Later cycles do not run, so the last call is the requested one.
    each(machine, arena, |at, cycle| {
        if at <= number {
            let taken = cycle.count_bare();
            if at == number {
                hprintln!("{} replay cycle {} instructions {}", scalar, number, taken);
            }
        }
    });
}
