//! `trueaxis keep undo`.

use super::UndoArgs;
use crate::model::note;
use crate::output::report_line;
use anyhow::Result;
use trueaxis_evaluation::keep::State;
use trueaxis_tables::output::Outputs;

pub(super) fn run(arguments: &UndoArgs) -> Result<()> {
    let state = State::alone(&arguments.task, &mut note)?;
    let undone = state.undone(arguments.entry, arguments.time.clone(), arguments.by_hand, &mut note)?;
    state.put_back(Outputs::of([&arguments.task]), &undone)?;
    let back = undone.files.iter().filter(|(_, bytes)| bytes.is_some()).map(|(file, _)| ("restored", file));
    for (how, file) in back.chain(undone.away.iter().map(|file| ("removed", file))) {
        report_line(format_args!("{how} {}", state.folder.join(file).display()));
    }
    let before = undone.entry.undone.unwrap_or_default();
    report_line(format_args!("entry {}: as before entry {before}", undone.entry.entry));
    Ok(())
}
