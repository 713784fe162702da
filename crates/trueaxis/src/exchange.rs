//! Hand-over of a new configuration from a task to the servo interrupt, between two cycles.

#![deny(clippy::indexing_slicing)]

use core::cell::Cell;
use critical_section::Mutex;

/// A mailbox with one slot: the task offers a new configuration, the interrupt takes it before its next cycle.
///
/// Both sides spend a critical section of a few instructions. The step's state continues with the new tables and the
/// limiter ramps the correction over, so the exchange is bumpless in mid-motion.
///
/// ```
/// use trueaxis::exchange::Exchange;
/// let tables = [1, 2];
/// let mailbox = Exchange::new();
/// assert_eq!(mailbox.offer(&tables[1]), Ok(()));
/// assert_eq!(mailbox.offer(&tables[0]), Err(&tables[0])); // not taken yet
/// let mut active = &tables[0];
/// mailbox.take_into(&mut active); // first thing in the interrupt
/// assert_eq!(*active, 2);
/// ```
#[derive(Debug)]
pub struct Exchange<'a, T>(Mutex<Cell<Option<&'a T>>>);

impl<'a, T> Exchange<'a, T> {
    /// An empty mailbox.
    pub const fn new() -> Self {
        Exchange(Mutex::new(Cell::new(None)))
    }

    /// Offers a configuration to the interrupt.
    ///
    /// # Errors
    /// The previous offer has not been taken yet; the new one is returned.
    pub fn offer(&self, new: &'a T) -> Result<(), &'a T> {
        critical_section::with(|section| {
            let place = self.0.borrow(section);
            match place.get() {
                None => {
                    place.set(Some(new));
                    Ok(())
                }
                Some(_) => Err(new),
            }
        })
    }

    /// Replaces `active` by the offered configuration, if any; returns the replaced one, whose memory is then free for
    /// the next build.
    pub fn take_into(&self, active: &mut &'a T) -> Option<&'a T> {
        critical_section::with(|section| self.0.borrow(section).take()).map(|new| core::mem::replace(active, new))
    }
}

impl<T> Default for Exchange<'_, T> {
    fn default() -> Self {
        Self::new()
    }
}
