//! The thermal task: computes growth lines from sensor readings for the servo interrupt.

use crate::scalars::{AXES, Scalar};
use heapless::spsc::Producer;
use trueaxis::machine::AxisOrder;
use trueaxis::temperature::{Growth, SensorStatus};
use trueaxis_cortex_m::growth::InForce;
use trueaxis_recording::warming::{Task, Warming};

/// The thermal task's settings and readings, state, and end of the queue.
pub struct ThermalTask {
    warming: Warming<'static>,
    task: Task,
    axes: AxisOrder<AXES>,
    period_ns: u32,
    offered: Producer<'static, InForce<Scalar, AXES>>,
    /// The previous growth.
    before: Option<Growth>,
}

impl ThermalTask {
    /// The task before its first update.
    pub fn new(
        warming: Warming<'static>,
        axes: AxisOrder<AXES>,
        period_ns: u32,
        offered: Producer<'static, InForce<Scalar, AXES>>,
    ) -> Self {
        ThermalTask { warming, task: Task::default(), axes, period_ns, offered, before: None }
    }

    /// The settings and readings.
    pub fn warming(&self) -> Warming<'static> {
        self.warming
    }

    /// Runs one update and offers the growth to the interrupt; logs any change in a sensor's status.
    pub fn update(&mut self, row: u32) {
        let Some(growth) = self.warming.update(&mut self.task, row, self.period_ns) else { return };
        let lines = self.axes.slots(|axis| growth.line(axis));
        // There is room: of two waiting growths, the first is in force before a third is computed.
        let _ = self.offered.enqueue(InForce { from: self.warming.in_force_from(row), lines });
        self.log_changes(&growth, row);
        self.before = Some(growth);
    }

    fn log_changes(&self, growth: &Growth, row: u32) {
        for (number, now) in growth.sensors.iter().enumerate() {
            let before = self.before.as_ref().map_or(SensorStatus::Good, |before| before.sensors[number]);
            if *now != before {
                defmt::warn!("growth: sensor {=usize} {} from row {=u32} on", number + 1, now, row);
            }
        }
        let before = self.before.as_ref().map_or((false, 0), |before| (before.spindle_missing, before.beyond));
        if (growth.spindle_missing, growth.beyond) != before {
            let (missing, beyond) = (growth.spindle_missing, growth.beyond);
            defmt::warn!(
                "growth: speed missing {=bool}, beyond on axes {=u8:06b}, from row {=u32} on",
                missing,
                beyond,
                row
            );
        }
    }
}
