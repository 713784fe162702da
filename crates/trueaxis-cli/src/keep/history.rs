//! `trueaxis keep history`.

use super::HistoryArgs;
use crate::model::note;
use crate::output::{json, print};
use crate::report;
use anyhow::Result;
use trueaxis_evaluation::keep::{State, listed};
use trueaxis_tables::output::Outputs;

pub(super) fn run(arguments: &HistoryArgs) -> Result<()> {
    let state = State::read(&arguments.task, &mut note)?;
    if let Some(directory) = &arguments.report {
        let page = super::table::page(&state.machine.settings.name, &state.history.entries, None);
        let mut outputs = Outputs::of([&arguments.task]);
        report::write(&mut outputs, &page, directory, "keep.html")?;
        outputs.commit()?;
    }
    if arguments.json { json(&state.history.entries) } else { print(&listed(&state.history.entries).to_string()) }
}
