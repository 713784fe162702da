//! Queue of growth lines from the thermal task to the servo interrupt.

use heapless::spsc::Consumer;
use trueaxis::{Position, Real, State, ThermalLine};

/// Size of the queue, which holds one entry less.
pub const WAITING: usize = 3;

/// Growth lines by the step's slots, and the cycle from which they are in force.
#[derive(Clone, Copy, Debug)]
pub struct InForce<R, const N: usize> {
    /// The cycle.
    pub from: u32,
    /// `None` for an axis without growth.
    pub lines: [Option<ThermalLine<R>>; N],
}

/// The interrupt's end of the queue.
pub struct Growths<R: 'static, const N: usize> {
    waiting: Consumer<'static, InForce<R, N>>,
    /// Number of growths taken.
    pub taken: u32,
    /// Number of these taken after their cycle.
    pub late: u32,
}

impl<R: Real, const N: usize> Growths<R, N> {
    /// The queue's end before the first cycle.
    pub fn new(waiting: Consumer<'static, InForce<R, N>>) -> Self {
        Growths { waiting, taken: 0, late: 0 }
    }

    /// Applies the growth that is due in this cycle, if any; at most one per cycle.
    #[inline]
    pub fn take_into<P: Position>(&mut self, state: &mut State<R, P, N>, cycle: u32) {
        if self.waiting.peek().is_none_or(|next| next.from > cycle) {
            return;
        }
        let Some(growth) = self.waiting.dequeue() else { return };
        self.taken += 1;
        self.late += u32::from(growth.from < cycle);
        for (slot, line) in growth.lines.into_iter().enumerate() {
            if let Some(line) = line {
                let _ = state.set_thermal(slot, line); // there is one line for each slot
            }
        }
    }
}
