//! Table files for the calls, and the limits set by a file.

use crate::small;
use trueaxis::Axis;
use trueaxis::machine::{AxisOrder, DynamicSettings, Limits};
use trueaxis::roundness::{Band, GaugeSettings, InfeedSettings, ProbeAngles};
use trueaxis::tcomp::Tcomp;
use trueaxis_capi::AXES_MAX;
use trueaxis_tables::{Machine, compile};

/// The servo period for all of them.
pub(super) const PERIOD_NS: u32 = 100_000;
/// Counts of the spindle per revolution of the gauge.
pub(super) const COUNTS: i32 = 1 << 12;

/// A mill with nine terms; with volumetric errors a trunnion, a head with four axes and a machine with six; the mill with
/// friction, lag and feedback; the mill with a gauge.
pub(super) fn files() -> Vec<Vec<u8>> {
    let mill = small::machine("w X' Y' b Z t");
    let machines = [
        mill.clone(),
        small::machine("w C' A' X' Y' b Z t"),
        small::machine("w X' b Y Z C t"),
        small::machine("w X' b Y Z C A B t"),
        with_dynamics(),
        with_gauge(mill),
    ];
    machines.iter().map(|machine| compile(machine).expect("a good machine")).collect()
}

/// The sample mill with its dynamic correction, two lines per table.
fn with_dynamics() -> Machine {
    let file = include_bytes!("../../../../crates/trueaxis/mill-3axis.tcomp");
    let mut machine = Machine::from_tcomp(&Tcomp::parse(file).expect("a committed file"));
    for table in machine.tables.iter_mut().flatten() {
        let (first, last) = (table.rows[0], table.rows[table.rows.len() - 1]);
        table.rows = vec![first, last];
    }
    machine
}

fn with_gauge(mut machine: Machine) -> Machine {
    let mut settings = GaugeSettings::with_defaults(512, ProbeAngles::Slots { p: 88, q: 114 }, COUNTS as u32);
    settings.band = Band { first: 2, last: 30 };
    settings.revolutions = 1;
    settings.slices_per_cycle = 4;
    settings.infeed = Some(InfeedSettings::with_defaults(Axis::X, Band { first: 2, last: 10 }));
    machine.settings.roundness = Some(settings);
    machine
}

/// Limits of a correction per cycle, by axis of the step.
#[derive(Clone, Copy, Default)]
pub(super) struct Bound {
    /// Limits of the sum, mm (deg): its value, its change per cycle, and the change of that.
    pub(super) sum: [f64; 3],
    /// Limits of the dynamic part.
    pub(super) dynamic: [f64; 3],
}

impl Bound {
    /// The wider of both: an exchange hands a correction over from one to the other.
    pub(super) fn or(self, other: Bound) -> Bound {
        let wider = |one: [f64; 3], other: [f64; 3]| [0, 1, 2].map(|i| one[i].max(other[i]));
        Bound { sum: wider(self.sum, other.sum), dynamic: wider(self.dynamic, other.dynamic) }
    }
}

/// The bounds of a sound file; the correction of an axis that the machine does not have must be zero.
pub(super) fn bounds(file: &[u8], period_ns: u32) -> [Bound; AXES_MAX] {
    let tables = Tcomp::parse(file).expect("a file that a loop was built of");
    let settings = tables.settings();
    let order = match settings.step_axes().count() {
        3 => AxisOrder::<3>::of(settings).map(|order| order.axes().to_vec()),
        4 => AxisOrder::<4>::of(settings).map(|order| order.axes().to_vec()),
        5 => AxisOrder::<5>::of(settings).map(|order| order.axes().to_vec()),
        _ => AxisOrder::<6>::of(settings).map(|order| order.axes().to_vec()),
    };
    let period = 1e-9 * f64::from(period_ns);
    let per_cycle =
        |limits: Limits| [limits.magnitude, limits.slope_per_s * period, limits.acceleration_per_s2 * period * period];
    let mut bounds = [Bound::default(); AXES_MAX];
    for (bound, axis) in bounds.iter_mut().zip(order.expect("axes of a loop that was built")) {
        let Some(own) = settings.axis(axis) else { continue };
        let dynamic = own.servo.dynamic.unwrap_or_else(|| DynamicSettings::with_defaults(axis));
        *bound = Bound { sum: per_cycle(own.limits), dynamic: per_cycle(dynamic.limits) };
    }
    bounds
}
