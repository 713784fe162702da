//! `trueaxis helicoid`.

mod arguments;

pub(crate) use arguments::{EXAMPLE, HELP, HelicoidArgs};

use crate::output::{data, json, report_line};
use crate::report;
use anyhow::Result;
use trueaxis_evaluation::helicoid::document::csv;
use trueaxis_evaluation::helicoid::{HelicoidDocument, Job};
use trueaxis_tables::output::Outputs;

pub(crate) fn run(arguments: &HelicoidArgs) -> Result<()> {
    let job = Job::new(&arguments.request())?;
    let points = job.points()?;
    // Create every output before writing any.
    let program = match &arguments.gcode {
        Some(file) => Some((job.program()?, file)),
        None => None,
    };
    let document = HelicoidDocument::new(&job, points);
    let table = csv(&document.points);
    for note in job.notes() {
        report_line(format_args!("note: {note}"));
    }
    let mut outputs = Outputs::default();
    if let Some((text, file)) = &program {
        outputs.put(file, text.as_bytes())?;
    }
    if let Some(to) = &arguments.report {
        let page = document.shown().page("", [report::helicoid::flank(&job)]);
        report::write_to(&mut outputs, &page, to, "helicoid.html")?;
    }
    if let Some(file) = &arguments.output {
        outputs.put(file, table.as_bytes())?;
    }
    outputs.commit()?;
    match (arguments.json, &arguments.output) {
        (true, _) => json(&document),
        (false, None) => data(&table),
        (false, Some(_)) => Ok(()),
    }
}
