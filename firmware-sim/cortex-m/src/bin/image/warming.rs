//! The thermal task: readings of the sensors to growth lines for the servo interrupt.

use crate::scalars::{AXES, Scalar};
use heapless::spsc::Producer;
use trueaxis::machine::AxisOrder;
use trueaxis::temperature::{Growth, SensorStatus};
use trueaxis_cortex_m::growth::InForce;
use trueaxis_recording::warming::{Task, Warming};

/// Its settings and readings, its state, and its end of the queue.
pub struct ThermalTask {
    warming: Warming<'static>,
    task: Task,
    axes: AxisOrder<AXES>,
    period_ns: u32,
    offered: Producer<'static, InForce<Scalar, AXES>>,
    /// The growth before.
    before: Option<Growth>,
}

impl ThermalTask {
    /// Before the first update.
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

    /// One update, offered to the interrupt; what has changed with a sensor is logged.
    pub fn update(&mut self, row: u32) {
        let Some(growth) = self.warming.update(&mut self.task, row, self.period_ns) else { return };
        let lines = self.axes.slots(|axis| growth.line(axis));
        // Of two that wait the first is in force before a third is computed: there is room.
        let _ = self.offered.enqueue(InForce { from: self.warming.in_force_from(row), lines });
        self.tell(&growth, row);
        self.before = Some(growth);
    }

    fn tell(&self, growth: &Growth, row: u32) {
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
