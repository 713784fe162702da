//! Options for reading a program.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::{Offsets, Surface, ToolTable};

/// Tools, offsets, block delete and a probed surface, in addition to a program's text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Tools for G43; if absent, tools have no length.
    pub tools: Option<ToolTable>,
    /// Work offsets and stored positions; zero if absent.
    pub offsets: Option<Offsets>,
    /// Whether lines that begin with `/` are skipped.
    pub block_delete: bool,
    /// Folder with the files of subprograms, the program's own; if absent, they are in the program itself.
    pub folder: Option<PathBuf>,
    /// Text of each subprogram file by name, `name.ngc`, for a program without a folder.
    pub texts: Option<BTreeMap<String, String>>,
    /// What probing moves touch; if absent, they go to their ends.
    pub surface: Option<Surface>,
}
