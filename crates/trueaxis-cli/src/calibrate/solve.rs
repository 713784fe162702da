//! `trueaxis calibrate solve`.

use super::{SolveArgs, read};
use crate::output::{print, progress, report_line};
use crate::{machine_folder, model, report};
use anyhow::Result;
use maud::Render;
use trueaxis_evaluation::calibrate::{residuals, solved};
use trueaxis_tables::output::Outputs;

pub(super) fn run(arguments: &SolveArgs) -> Result<()> {
    let into = arguments.writing.output(arguments.output.as_deref());
    let _alone = into.map(machine_folder::alone).transpose()?;
    let read = read(&arguments.task)?;
    let text = model::text(&arguments.log)?;
    let bar = progress(0, "solving");
    let (plan, found) = solved(&read.task, &read.machine, &text, &arguments.log, |how| {
        bar.suspend(|| report_line(format_args!("note: {how}")));
    })?;
    bar.finish_and_clear();
    let document = found.document(&read.task, &read.machine);
    let files = machine_folder::inputs(&read.path, into);
    let mut outputs = Outputs::of(files.into_iter().chain([arguments.task.clone(), arguments.log.clone()]));
    let additions = (arguments.writing, found.additions(&read.task));
    let done = machine_folder::decide(&mut outputs, &read.path, into, &arguments.log, additions)?;
    if arguments.writing.dry_run {
        return done.dry_run(&document, arguments.json);
    }
    if let Some(directory) = &arguments.report {
        let figures = [("Residuals", residuals(&read.task, &plan, &found).render())];
        report::stage(&mut outputs, (directory, "calibrate.html"), &arguments.log, &document.shown(&found), figures)?;
    }
    outputs.commit()?;
    done.print_notes();
    if arguments.json { done.json(&document) } else { print(&document.shown(&found).text()) }
}
