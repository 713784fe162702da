//! A machine's configuration in the form that the contract needs: per axis, in doubles, per cycle.

use super::drawn::Drawn;
use trueaxis::machine::{AxisOrder, AxisSettings, DynamicSettings, GridHeader, Limits, wraps};
use trueaxis::{Axis, Position};

/// Bound on the sum of the angular errors of all tables and grids as drawn, rad.
const LARGEST_ANGLE: f64 = 5e-4;

/// Magnitude, slope and acceleration in mm (deg) and cycles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// C.
    pub c: f64,
    /// V.
    pub v: f64,
    /// a.
    pub a: f64,
}

impl Bounds {
    /// Converts limits in seconds.
    pub(super) fn of(limits: &Limits, period_s: f64) -> Bounds {
        Bounds {
            c: limits.magnitude,
            v: limits.slope_per_s * period_s,
            a: limits.acceleration_per_s2 * period_s * period_s,
        }
    }
}

/// One axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisFacts<P> {
    /// Whether the machine has the axis; otherwise it is only a letter of the step.
    pub present: bool,
    /// Limits of the correction.
    pub sum: Bounds,
    /// Limits of the dynamic correction.
    pub dynamic: Bounds,
    /// Acceleration limit of the geometric correction beside a dynamic one.
    pub ramp_a: f64,
    /// Declared travel.
    pub travel: [P; 2],
    /// Range of the joint.
    pub joint: [P; 2],
    /// Largest plausible change of a command.
    pub command_jump: f64,
    /// Largest plausible change of a reading.
    pub feedback_jump: f64,
    /// Commanded travel after which a constant reading counts as stuck.
    pub stuck: f64,
    /// A reading that changes by no more than this is constant.
    pub still: f64,
    /// A command that changes by no more than this need not show in such a reading.
    pub play: f64,
    /// Range in which readings are accepted: 1 mm (1°) beyond the joint.
    pub readable: [P; 2],
    /// Maximum distance of a reset from the held command.
    pub resume: f64,
    /// Ends between which the table and every grid of the axis give errors; `None` if it has neither, or the table spans a
    /// full turn.
    pub table: Option<[f64; 2]>,
    /// Highest feed, mm (deg) per cycle.
    pub feed: f64,
    /// Hysteresis of the direction of travel.
    pub hysteresis: f64,
    /// Whether a feed-forward is configured, which needs the drive's figures.
    pub fed_forward: bool,
    /// Cycles in which a switched-off feed-forward decays: 25 time constants of velocity and position loop.
    pub dies_away: f64,
    /// Whether cross-talk moves this axis.
    pub crosstalked: bool,
}

/// One configuration.
#[derive(Clone, Debug)]
pub(super) struct Facts<P, const N: usize> {
    /// Facts of the axes by slot.
    pub axes: [AxisFacts<P>; N],
    /// Axis letters by slot.
    pub letters: [Axis; N],
    /// Id of the machine.
    pub machine_id: u32,
    /// CRC of the tables.
    pub tables_crc: u32,
    /// Servo period, ns.
    pub period_ns: u32,
    /// Whether any part of the dynamic correction is configured.
    pub dynamic: bool,
    /// Whether contour feedback is configured.
    pub feedback: bool,
    /// Whether errors are looked up at the feedback on any axis.
    pub at_feedback: bool,
    /// Largest sum of squareness and angular errors, rad.
    pub lean: f64,
    /// Singular cone: largest deviation from a commanded tool direction, degrees.
    pub cone_deg: f64,
}

impl<P: Position, const N: usize> Facts<P, N> {
    /// Facts of a drawn machine.
    pub(super) fn of(drawn: &Drawn, machine_id: u32, tables_crc: u32, period_ns: u32) -> Self {
        let machine = &drawn.settings;
        let order = AxisOrder::<N>::of(machine).expect("a machine of so many axes");
        let period_s = f64::from(period_ns) * 1e-9;
        let feedback = machine.contour.feedback.is_some();
        let axes = order.slots(|axis| {
            let Some(settings) = machine.axis(axis) else { return AxisFacts::absent(period_s) };
            let rows = drawn.rows(axis);
            let whole = rows.is_some_and(|rows| wraps(axis, rows));
            let table = rows.filter(|_| !whole).map(|rows| [rows[0].position, rows[rows.len() - 1].position]);
            let of_grid = |(header, _): &(GridHeader, _)| {
                let along = header.axes.get(axis.index()).filter(|along| along.is_there())?;
                Some(along.ends)
            };
            let both = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].min(b[1])];
            let table = drawn.grids.iter().filter_map(of_grid).chain(table).reduce(both);
            let crosstalked = machine.crosstalk.iter().any(|entry| entry.tip == axis);
            AxisFacts { table, crosstalked, ..AxisFacts::of(drawn, settings, period_s) }
        });
        let location = &machine.location;
        let servo = machine.axes.iter().any(|axis| axis.servo.friction.is_some() || axis.servo.dynamic.is_some());
        Facts {
            axes,
            letters: order.axes(),
            machine_id,
            tables_crc,
            period_ns,
            dynamic: servo || feedback || !machine.crosstalk.is_empty(),
            feedback,
            at_feedback: machine.axes.iter().any(|axis| {
                use trueaxis::machine::Lookup::Feedback;
                axis.lookup == Feedback || axis.cross_lookup == Feedback
            }),
            lean: LARGEST_ANGLE + [location.a0z, location.b0z, location.c0y].map(f64::abs).iter().sum::<f64>(),
            cone_deg: machine.kinematics.singular_cone_deg,
        }
    }
}

impl<P: Position> AxisFacts<P> {
    fn of(drawn: &Drawn, settings: &AxisSettings, period_s: f64) -> Self {
        let faults = &drawn.settings.faults;
        let pick = |[linear, rotary]: [f64; 2]| if settings.axis.is_rotary() { rotary } else { linear };
        let jump = faults.command_jump_factor * settings.max_feed_per_s * period_s;
        let servo = &settings.servo;
        let dynamic = servo.dynamic.unwrap_or(DynamicSettings::with_defaults(settings.axis));
        // If acceleration is fed forward, limited to the deceleration by friction (docs/dynamic.md).
        let braking = match (&servo.drive, &servo.friction) {
            (Some(drive), Some(friction)) if dynamic.acceleration => {
                friction.coulomb_per_s * drive.velocity_gain_per_s * period_s * period_s
            }
            _ => f64::INFINITY,
        };
        let sum = Bounds::of(&settings.limits, period_s);
        // Three encoder steps, at most a quarter of the travel after which the axis is stuck.
        let stuck = pick(faults.stuck);
        let still = settings.encoder_resolution.map_or(0.0, |step| f64::min(3.0 * step, stuck / 4.0));
        AxisFacts {
            present: true,
            sum,
            dynamic: Bounds::of(&dynamic.limits, period_s),
            ramp_a: sum.a.min(braking),
            travel: settings.travel.map(|end| P::nearest(end.clamp(-1e9, 1e9))),
            joint: settings.joint.map(P::nearest),
            command_jump: jump,
            feedback_jump: jump + pick(faults.feedback_jump),
            stuck,
            still,
            play: if settings.encoder_resolution.is_some() { still + settings.backlash.abs() } else { 0.0 },
            readable: [settings.joint[0] - 1.0, settings.joint[1] + 1.0].map(|end| P::nearest(end.clamp(-1e9, 1e9))),
            resume: pick(faults.resume),
            table: None,
            feed: settings.max_feed_per_s * period_s,
            hysteresis: settings.hysteresis,
            fed_forward: servo.drive.is_some(),
            dies_away: servo.drive.map_or(0.0, |drive| {
                let position = drive.velocity_feed_forward / drive.position_gain_per_s;
                25.0 * (drive.reset_time_s + position) / period_s
            }),
            crosstalked: false,
        }
    }

    /// An axis letter that the machine does not have; any reading is accepted. Its only correction is thermal growth that a
    /// host sets for it, which moves no drive: within any limits.
    fn absent(period_s: f64) -> Self {
        let any = Bounds { c: 1.0, v: 1e-3, a: 1e-3 };
        AxisFacts {
            present: false,
            sum: any,
            dynamic: Bounds::of(&DynamicSettings::with_defaults(Axis::X).limits, period_s),
            ramp_a: 1e-3,
            travel: [-1e9, 1e9].map(P::nearest),
            joint: [f64::MIN, f64::MAX].map(P::nearest),
            command_jump: f64::INFINITY,
            feedback_jump: f64::INFINITY,
            stuck: f64::INFINITY,
            still: 0.0,
            play: 0.0,
            readable: [-1e9, 1e9].map(P::nearest),
            resume: f64::INFINITY,
            table: None,
            feed: 0.1,
            hysteresis: 0.0,
            fed_forward: false,
            dies_away: 0.0,
            crosstalked: false,
        }
    }
}
