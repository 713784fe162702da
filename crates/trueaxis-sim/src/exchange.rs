//! Exchange of tables while the machine moves.

use crate::error::Result;
use crate::limit_watch::LimitWatch;
use crate::servo::{Axes, Compiled, step, with_loop};
use trueaxis::machine::{AXES, AxisOrder};
use trueaxis_tables::Machine;

/// A millisecond.
const PERIOD_NS: u32 = 1_000_000;
/// The course: a circle in X and Y with this radius, mm, and this many cycles per turn, about 60 mm/s.
const RADIUS_MM: f64 = 40.0;
const TURN: u32 = 4_189;
/// Cycles with the old tables: one turn in which the first correction ramps in, and one that is measured.
const BEFORE: u32 = 2 * TURN;
/// Cycles with the new tables.
const AFTER: u32 = TURN;

/// Motion of the correction while tables were exchanged.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Exchanged {
    /// Difference between the new and the old tables' correction at the exchange: the largest of any axis, mm or degrees.
    /// Without a limiter the correction would jump by this.
    pub difference: f64,
    /// Largest step of the correction from cycle to cycle after the exchange.
    pub largest_step: f64,
    /// Largest step in a turn with the old tables.
    pub step_before: f64,
    /// Largest velocity or acceleration after the exchange, as a share of its limit.
    pub of_limits: f64,
    /// Time until the correction followed the new tables, s; `None` if it never did.
    #[serde(rename = "led_in_s")]
    pub ramp_in_s: Option<f64>,
}

/// Runs a circle about a place (X, Y, Z, A, B, C; mm and degrees) and exchanges the tables of `old` for those of `new` between
/// two cycles; state and motion continue.
///
/// # Errors
/// Tables that do not compile or build.
pub fn in_motion(old: &Machine, new: &Machine, about: [f64; AXES]) -> Result<Exchanged> {
    match old.settings.step_axes().count() {
        3 => of::<3>(old, new, about),
        _ => of::<6>(old, new, about),
    }
}

fn of<const N: usize>(old: &Machine, new: &Machine, about: [f64; AXES]) -> Result<Exchanged>
where
    Axes: Compiled<N>,
{
    with_loop::<N, _, _>(old, PERIOD_NS, |first| {
        with_loop::<N, _, _>(new, PERIOD_NS, |second| {
            let axes = AxisOrder::<N>::with_spare_slots(&old.settings)?.axes();
            let limits = axes.map(|axis| old.settings.axis(axis).map(|own| own.limits));
            let period_s = 1e-9 * f64::from(PERIOD_NS);
            let command = |cycle: u32| {
                let (sin, cos) = libm::sincos(core::f64::consts::TAU * f64::from(cycle) / f64::from(TURN));
                axes.map(|axis| {
                    let k = axis.index();
                    about[k] + [RADIUS_MM * cos, RADIUS_MM * sin, 0.0, 0.0, 0.0, 0.0][k]
                })
            };
            let mut state = first.start();
            let mut watch = LimitWatch::new(limits, period_s);
            for cycle in 0..BEFORE {
                let at = command(cycle);
                let output = step(first, &mut state, &first.input(at, at), &mut (), &mut ());
                if cycle == TURN {
                    watch.largest_step = 0.0;
                }
                watch.take(output.record.correction);
            }
            let mut found = Exchanged { step_before: watch.largest_step, ..Exchanged::default() };
            let mut other = state;
            let at = command(BEFORE);
            let here = step(first, &mut other, &first.input(at, at), &mut (), &mut ()).record.correction;
            (watch.largest_step, watch.of_limits) = (0.0, 0.0);
            for cycle in 0..AFTER {
                let at = command(BEFORE + cycle);
                let output = step(second, &mut state, &second.input(at, at), &mut (), &mut ());
                watch.take(output.record.correction);
                if output.record.limited == 0 && found.ramp_in_s.is_none() {
                    found.ramp_in_s = Some(period_s * f64::from(cycle));
                }
            }
            // The settled correction at the place of the exchange: the same circle from a cold start.
            let mut settled = second.start();
            let mut there = here;
            for cycle in 0..=BEFORE {
                let at = command(cycle);
                there = step(second, &mut settled, &second.input(at, at), &mut (), &mut ()).record.correction;
            }
            found.difference = here.iter().zip(there).fold(0.0, |most, (a, b)| most.max((a - b).abs()));
            (found.largest_step, found.of_limits) = (watch.largest_step, watch.of_limits);
            Ok(found)
        })
    })
}
