//! Growth lines on their way from the thermal task to the servo interrupt.

use heapless::spsc::Consumer;
use trueaxis::compensation::ThermalLine;
use trueaxis::{Position, Real, State};

/// Room of the queue; one less fits.
pub const WAITING: usize = 3;

/// Growth lines by the step's slots, and the cycle from which they are in force.
#[derive(Clone, Copy, Debug)]
pub struct InForce<R, const N: usize> {
    /// The cycle.
    pub from: u32,
    /// None for an axis that the growth does not name.
    pub lines: [Option<ThermalLine<R>>; N],
}

/// The interrupt's end of the queue.
pub struct Growths<R: 'static, const N: usize> {
    waiting: Consumer<'static, InForce<R, N>>,
    /// Growths taken.
    pub taken: u32,
    /// Of these after their cycle.
    pub late: u32,
}

impl<R: Real, const N: usize> Growths<R, N> {
    /// Before the first cycle.
    pub fn new(waiting: Consumer<'static, InForce<R, N>>) -> Self {
        Growths { waiting, taken: 0, late: 0 }
    }

    /// Sets the growth that is in force from this cycle on, if there is one: at most one in a cycle.
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
                state.set_thermal(slot, line);
            }
        }
    }
}
