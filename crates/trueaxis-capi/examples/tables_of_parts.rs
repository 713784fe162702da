//! Writes one table file for each part that a build of the library may leave out: the machines of
//! `examples/c/left_out.c`.
//!
//! `cargo run -p trueaxis-capi --example tables_of_parts -- FOLDER`
use std::error::Error;
use std::path::PathBuf;
use trueaxis::machine::{ErrorModel, FeedbackSettings};
use trueaxis_tables::{Grid, GridSource, Machine, compile};

#[allow(unsafe_code)]
#[path = "../tests/machines/mod.rs"]
mod machines;

fn with(change: impl FnOnce(&mut Machine)) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut machine = machines::read("mill-3axis");
    change(&mut machine);
    Ok(compile(&machine)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("a folder is needed")?);
    let corner = |x: f64| [0.0, 0.0, 1e-5 * x, 0.0, 0.0, 0.0];
    let grid = Grid::new(GridSource {
        nodes: [vec![-100.0, 100.0], vec![-100.0, 100.0], vec![]],
        given: [false, false, true, false, false, false],
        values: [-100.0, -100.0, 100.0, 100.0].map(corner).to_vec(),
        ..GridSource::default()
    })
    .map_err(|_| "a resolution that holds the errors is needed")?;
    let feedback = FeedbackSettings { proportional: 0.05, integral_per_s: 0.0, ..FeedbackSettings::default() };
    for (part, file) in [
        ("grids", with(|machine| machine.grids = vec![grid])?),
        ("volumetric", with(|machine| machine.settings.compensation.model = ErrorModel::Volumetric)?),
        ("rotary", compile(&machines::small_five())?),
        (
            "dynamic",
            with(|machine| {
                for axis in &mut machine.settings.axes {
                    axis.servo.drive = Some(machines::drive());
                }
                machine.settings.contour.feedback = Some(feedback);
            })?,
        ),
        ("gauge", machines::gauge::with_gauge(machines::read("mill-3axis"), 512)),
    ] {
        std::fs::write(folder.join(format!("{part}.tcomp")), file)?;
    }
    Ok(())
}
