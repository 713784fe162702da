//! A bare-metal image: the step as a controller's servo interrupt, the same code as on a host.
//!
//! ```text
//! recording ─► servo interrupt: step ─► queue ─► telemetry task ─► UART 0: frames, UART 1: raw outputs
//!                    ▲                                └► log (defmt over semihosting)
//!                    ├─ mailbox ◄─ exchange task: tables B read, checked, built
//!                    └─ queue ◄─── thermal task: readings of sensors ─► growth lines
//! ```
//!
//! The interrupt has the highest priority and touches neither serial port nor log. Tables and recording are in separate
//! regions of flash (`memory.x`). If the tables are refused, the machine runs uncompensated, and every record reports it;
//! without a recording the image ends with exit code 1.

#![no_std]
#![no_main]

mod board;
mod scalars;
mod servo;
mod stack;
mod start;
mod tables;
mod telemetry;
mod warming;

use cortex_m_rt as _;
use cortex_m_semihosting::debug;
use defmt_semihosting as _;

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    match info.location() {
        Some(at) => defmt::error!("panic at {=str}:{=u32}", at.file(), at.line()),
        None => defmt::error!("panic"),
    }
    leave(false)
}

/// Ends QEMU with exit code 0 or 1.
fn leave(well: bool) -> ! {
    debug::exit(if well { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    loop {
        cortex_m::asm::bkpt();
    }
}

#[rtic::app(device = trueaxis_cortex_m::device, peripherals = false, dispatchers = [Uart1Rx, Uart2Rx, Uart2Tx])]
mod app {
    use super::board::{ServoTimer, instructions};
    use super::scalars::Loop;
    use super::servo::{Gauge, Produced, Servo};
    use super::start::{self, Spare, Started};
    use super::telemetry::{Telemetry, latest};
    use super::warming::ThermalTask;
    use super::{leave, stack};
    use core::sync::atomic::{AtomicU32, Ordering};
    use heapless::spsc::Producer;
    use trueaxis::exchange::Exchange;
    use trueaxis_recording::warming::Warming;

    static EXCHANGE: Exchange<'static, Loop> = Exchange::new();
    /// Stack pointer of the idle task: the interrupt's starting point if it interrupts nothing else.
    static IDLE: AtomicU32 = AtomicU32::new(0);

    /// Counters of the interrupt.
    #[derive(Clone, Copy, Default)]
    pub struct Figures {
        cycles: u32,
        /// Cycles that were still running when the next one was due.
        overruns: u32,
        /// Cycles whose record found the queue full and was dropped.
        dropped: u32,
        /// Maximum number of records waiting for the telemetry.
        waiting: usize,
        /// Longest time from the timer's interrupt to the start of the cycle, ticks of the board's clock.
        latest: u32,
        /// Deepest stack below the interrupt's own frame, bytes.
        below: u32,
        /// Stack between the interrupted task and that frame, bytes: the registers saved by the processor, and the frame.
        entry: u32,
        /// Readings skipped because the thermal task was still running.
        readings_left_out: u32,
        /// Growths that came into force, and the number of those that did so after their cycle.
        growths: u32,
        growths_late: u32,
        /// The recording is over.
        ended: bool,
    }

    #[shared]
    struct Shared {
        gauge: Option<Gauge>,
        figures: Figures,
    }

    #[local]
    struct Local {
        timer: ServoTimer,
        servo: Servo,
        produced: Producer<'static, Produced>,
        telemetry: Telemetry,
        spare: Option<Spare>,
        warming: Option<Warming<'static>>,
        thermal: Option<ThermalTask>,
    }

    #[init]
    fn init(_: init::Context) -> (Shared, Local) {
        let Started { servo, gauge, produced, telemetry, spare, thermal } = start::start();
        let warming = thermal.as_ref().map(ThermalTask::warming);
        let figures = Figures { entry: u32::MAX, ..Figures::default() };
        // SAFETY: the only owner.
        let timer = unsafe { ServoTimer::start() };
        (Shared { gauge, figures }, Local { timer, servo, produced, telemetry, spare: Some(spare), warming, thermal })
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            IDLE.store(stack::pointer(), Ordering::Relaxed);
            cortex_m::asm::wfi();
        }
    }

    /// The servo cycle.
    #[task(binds = Timer0, priority = 4, local = [timer, servo, produced, warming], shared = [gauge, figures])]
    fn servo_cycle(cx: servo_cycle::Context) {
        let servo_cycle::LocalResources { timer, servo, produced, warming, .. } = cx.local;
        let servo_cycle::SharedResources { gauge, figures, .. } = cx.shared;
        let late = timer.acknowledge();
        if servo.is_exchange_due() {
            // Spawned once: a recording requests the exchange in one cycle.
            let _ = exchange_tables::spawn();
        }
        let row = warming.as_ref().and_then(|warming| warming.read_in(servo.cycles()));
        let left_out = row.is_some_and(|row| thermal::spawn(row).is_err());
        (gauge, figures).lock(|gauge, figures| {
            if figures.ended {
                return;
            }
            stack::paint();
            match servo.cycle(&EXCHANGE, gauge.as_mut()) {
                Some(new) => figures.dropped += u32::from(produced.enqueue(*new).is_err()),
                None => figures.ended = true,
            }
            figures.below = figures.below.max(stack::used());
            let interrupted = IDLE.load(Ordering::Relaxed).checked_sub(stack::pointer());
            figures.entry = figures.entry.min(interrupted.unwrap_or(u32::MAX));
            figures.cycles = servo.cycles();
            figures.readings_left_out += u32::from(left_out);
            (figures.growths, figures.growths_late) = (servo.growths().taken, servo.growths().late);
            figures.waiting = figures.waiting.max(produced.len());
            figures.latest = figures.latest.max(late);
            figures.overruns += u32::from(!figures.ended && timer.is_due());
        });
        // If the task is still running from the previous cycle, it will find this record too.
        let _ = telemetry::spawn();
    }

    /// Sends everything that the cycles have produced.
    #[task(priority = 3, local = [telemetry], shared = [gauge, figures])]
    async fn telemetry(cx: telemetry::Context) {
        let out = cx.local.telemetry;
        let telemetry::SharedResources { mut gauge, mut figures, .. } = cx.shared;
        while let Some(new) = out.next() {
            out.cycle(&new);
            if new.gauge.is_some_and(|gauge| gauge.finished) {
                let machine_id = new.output.record.machine_id;
                let frame = gauge.lock(|gauge| latest(machine_id, gauge.as_ref()?));
                out.revolution(frame);
            }
        }
        if figures.lock(|figures| figures.ended) && out.is_empty() {
            let _ = finish::spawn(out.lost_revolutions());
        }
    }

    /// Reads, checks and builds the other tables, and offers them to the interrupt.
    #[task(priority = 1, local = [spare])]
    async fn exchange_tables(cx: exchange_tables::Context) {
        if let Some(servo) = cx.local.spare.take().and_then(Spare::build) {
            // The mailbox is empty: no other tables are ever offered.
            let _ = EXCHANGE.offer(servo);
        }
    }

    /// Computes the growth from the sensor readings, without waiting for an exchange.
    #[task(priority = 2, local = [thermal])]
    async fn thermal(cx: thermal::Context, row: u32) {
        if let Some(thermal) = cx.local.thermal {
            thermal.update(row);
        }
    }

    /// Logs the result and ends.
    #[task(priority = 1, shared = [gauge, figures])]
    async fn finish(cx: finish::Context, lost_revolutions: u32) {
        let finish::SharedResources { gauge, figures, .. } = cx.shared;
        let (counts, figures) =
            (gauge, figures).lock(|gauge, figures| (gauge.as_ref().map(|gauge| gauge.state.counts()), *figures));
        let Figures { cycles, overruns, dropped, waiting, latest, below, entry, .. } = figures;
        defmt::info!(
            "end: {=u32} cycles, {=u32} overruns, {=u32} records dropped, at most {=usize} waiting, latest start {=u32} \
             instructions",
            cycles,
            overruns,
            dropped,
            waiting,
            instructions(latest)
        );
        let Figures { growths, growths_late, readings_left_out, .. } = figures;
        if growths + readings_left_out > 0 {
            defmt::info!(
                "growth: {=u32} times in force, {=u32} late, {=u32} readings left out",
                growths,
                growths_late,
                readings_left_out
            );
        }
        if let Some(counts) = counts {
            defmt::info!("gauge: {}, {=u32} records lost", counts, lost_revolutions);
        }
        defmt::info!("stack of the servo interrupt: {=u32} bytes on entry, {=u32} bytes of the step", entry, below);
        leave(true)
    }
}
