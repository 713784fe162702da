//! A learned correction that a scenario owns.

use self_cell::self_cell;
use trueaxis::learned::{Learned, LearnedError};

type Parsed<'b> = Learned<'b, f64>;

self_cell! {
    /// A learned correction together with the bytes of its file.
    pub struct LearnedTable {
        owner: Vec<u8>,
        #[covariant]
        dependent: Parsed,
    }

    impl {Debug}
}

impl LearnedTable {
    /// Reads a file.
    ///
    /// # Errors
    /// As [`Learned::parse`].
    pub fn read(bytes: Vec<u8>) -> Result<LearnedTable, LearnedError> {
        LearnedTable::try_new(bytes, |bytes| Learned::parse(bytes))
    }

    /// The correction.
    pub fn table(&self) -> &Learned<'_, f64> {
        self.borrow_dependent()
    }

    /// The file's bytes.
    pub fn bytes(&self) -> &[u8] {
        self.borrow_owner()
    }
}
