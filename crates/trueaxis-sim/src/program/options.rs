//! Options of reading a program.

use super::{Offsets, ToolTable};

/// Tools, offsets and block delete, beside a program's text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Tools for G43; without it they have no length.
    pub tools: Option<ToolTable>,
    /// Work offsets and stored positions; zero without it.
    pub offsets: Option<Offsets>,
    /// Whether lines that begin with `/` are left out.
    pub block_delete: bool,
}
