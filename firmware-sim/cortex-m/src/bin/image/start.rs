//! Start-up: from the contents of flash to a servo that can run.

use crate::board::Uart;
use crate::leave;
use crate::scalars::{AXES, GaugePlan, GaugeState, Loop, Piece, Scalar};
use crate::servo::{Gauge, Produced, Running, Servo};
use crate::tables::{self, MEMORY, TablesRefusal};
use crate::telemetry::Telemetry;
use crate::warming::ThermalTask;
use heapless::Vec;
use heapless::spsc::{Producer, Queue};
use static_cell::{ConstStaticCell, StaticCell};
use trueaxis::Bypass;
use trueaxis::machine::AxisOrder;
use trueaxis_cortex_m::growth::{self, Growths, InForce};
use trueaxis_cortex_m::regions;
use trueaxis_recording::Recording;
use trueaxis_recording::warming::{MAGIC, Warming};

/// Maximum number of path pieces.
pub const MOST_PIECES: usize = 2048;
/// Maximum number of cycles waiting for the telemetry, plus one.
const WAITING: usize = 65;

static PIECES: ConstStaticCell<Vec<Piece, MOST_PIECES>> = ConstStaticCell::new(Vec::new());
static WAITING_CYCLES: ConstStaticCell<Queue<Produced, WAITING>> = ConstStaticCell::new(Queue::new());
static GROWTHS: ConstStaticCell<Queue<InForce<Scalar, AXES>, { growth::WAITING }>> = ConstStaticCell::new(Queue::new());
static MEMORY_A: ConstStaticCell<[Scalar; MEMORY]> = ConstStaticCell::new([0.0; MEMORY]);
static MEMORY_B: ConstStaticCell<[Scalar; MEMORY]> = ConstStaticCell::new([0.0; MEMORY]);
static LOOP_A: StaticCell<Loop> = StaticCell::new();
static LOOP_B: StaticCell<Loop> = StaticCell::new();
static GAUGE_PLAN: StaticCell<GaugePlan> = StaticCell::new();
static GAUGE_STATE: ConstStaticCell<GaugeState> = ConstStaticCell::new(GaugeState::new());

/// Initial data of the tasks.
pub struct Started {
    /// Data of the interrupt.
    pub servo: Servo,
    /// The gauge, owned by the interrupt and read by the telemetry.
    pub gauge: Option<Gauge>,
    /// The interrupt's end of the queue.
    pub produced: Producer<'static, Produced>,
    /// Data of the telemetry task.
    pub telemetry: Telemetry,
    /// Data of the exchange task.
    pub spare: Spare,
    /// Data of the thermal task, if growth was flashed.
    pub thermal: Option<ThermalTask>,
}

/// Memory for a second set of tables.
pub struct Spare {
    memory: &'static mut [Scalar; MEMORY],
    machine_id: u32,
    period_ns: u32,
    /// Whether a step is running whose tables can be exchanged.
    runs: bool,
}

impl Spare {
    /// Builds the second set; `None` if it is refused.
    pub fn build(self) -> Option<&'static Loop> {
        if !self.runs {
            defmt::warn!("tables B not taken: running uncompensated");
            return None;
        }
        match tables::build(regions::tables_b(), self.machine_id, self.period_ns, self.memory) {
            Ok(built) => {
                defmt::info!("tables B {=u32:08x} offered", built.file.crc());
                Some(LOOP_B.init(built.servo))
            }
            Err(refused) => {
                say("B", &refused);
                None
            }
        }
    }
}

fn say(which: &str, refused: &TablesRefusal) {
    let fault = refused.fault();
    defmt::error!(
        "tables {=str} refused: fault {=u8} {}, code {=u8}, {}",
        which,
        u8::from(fault),
        fault,
        refused.code(),
        refused
    );
}

/// Reads the recording and the first tables. Without a usable recording, ends with exit code 1.
pub fn start() -> Started {
    let recording = match Recording::<AXES>::parse(regions::recording()) {
        Ok(recording) => recording,
        Err(error) => {
            defmt::error!("recording refused: {}", defmt::Display2Format(&error));
            leave(false)
        }
    };
    let header = recording.header();
    let (machine_id, period_ns, with_gauge) = (header.machine_id, header.period_ns, header.gauge);
    let Some(first) = recording.cycle(0) else {
        defmt::error!("recording refused: no cycles");
        leave(false)
    };
    let pieces = PIECES.take();
    if header.pieces as usize > MOST_PIECES {
        defmt::error!("recording refused: {=u32} pieces of path, room for {=usize}", header.pieces, MOST_PIECES);
        leave(false)
    }
    pieces.extend(recording.path().take(MOST_PIECES));
    defmt::info!(
        "recording {=str}: {=u32} cycles of {=u32} ns, {=u32} pieces of path, gauge {=bool}",
        header.name.as_str(),
        header.cycles,
        header.period_ns,
        header.pieces,
        with_gauge
    );

    let mut tables_crc = 0;
    let (running, gauge, axes) = match loaded(machine_id, period_ns, first.elapsed_ns, with_gauge) {
        Ok((running, gauge, axes, crc)) => {
            tables_crc = crc;
            (running, gauge, axes)
        }
        Err(refused) => {
            say("A", &refused);
            (Running::Bypass(Bypass::new(refused.fault())), None, None)
        }
    };
    let (offered, growths) = GROWTHS.take().split();
    let thermal =
        axes.zip(warming(machine_id)).map(|(axes, warming)| ThermalTask::new(warming, axes, period_ns, offered));
    let spare = Spare { memory: MEMORY_B.take(), machine_id, period_ns, runs: matches!(running, Running::Step(..)) };
    let (produced, waiting) = WAITING_CYCLES.take().split();
    // SAFETY: the only owner of both ports.
    let (frames, raw) = unsafe { (Uart::zero(), Uart::one()) };
    Started {
        servo: Servo::new(recording, pieces, running, Growths::new(growths)),
        gauge,
        produced,
        telemetry: Telemetry::new(waiting, frames, raw, tables_crc),
        spare,
        thermal,
    }
}

/// The flashed thermal growth; if refused, this is logged and the machine runs without it. `None` if that flash was never
/// written.
fn warming(machine_id: u32) -> Option<Warming<'static>> {
    let bytes = regions::warming();
    let blank = |value: u8| bytes.iter().take(MAGIC.len()).all(|byte| *byte == value);
    if blank(0) || blank(0xff) {
        return None;
    }
    match Warming::parse(bytes, machine_id) {
        Ok(warming) => {
            let thermal = warming.thermal();
            defmt::info!(
                "growth {=u32:08x}: {=usize} sensors, {=u32} rows",
                thermal.crc(),
                thermal.sensors(),
                warming.rows()
            );
            Some(warming)
        }
        Err(refused) => {
            defmt::error!("growth refused: {}; none is compensated", defmt::Display2Format(&refused));
            None
        }
    }
}

fn loaded(
    machine_id: u32,
    period_ns: u32,
    first_ns: u32,
    with_gauge: bool,
) -> Result<(Running, Option<Gauge>, Option<AxisOrder<AXES>>, u32), TablesRefusal> {
    let tables = tables::build(regions::tables_a(), machine_id, period_ns, MEMORY_A.take())?;
    let period = TablesRefusal::Period { found: first_ns, configured: period_ns };
    tables.servo.check_period(first_ns).map_err(|_| period)?;
    let state = tables.servo.start();
    let plan = if with_gauge { tables::gauge(&tables.file, period_ns)? } else { None };
    let gauge = plan.map(|plan| Gauge { plan: GAUGE_PLAN.init(plan), state: GAUGE_STATE.take() });
    defmt::info!(
        "machine {=str} id {=u32:08x}, axes {=str}, tables {=u32:08x}, memory {=usize} of {=usize} scalars",
        tables.file.name(),
        tables.file.machine_id(),
        tables.file.chain(),
        tables.file.crc(),
        tables.used,
        MEMORY
    );
    let axes = AxisOrder::of(tables.file.settings()).ok();
    Ok((Running::Step(LOOP_A.init(tables.servo), state), gauge, axes, tables.file.crc()))
}
