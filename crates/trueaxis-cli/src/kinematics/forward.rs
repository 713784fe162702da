//! `trueaxis kinematics forward`: from axis positions to the tool.

use super::common::{AXIS_COLUMNS, Common, MARGIN, TOOL_COLUMNS, kinematics};
use super::sheet::Sheet;
use crate::csv_in::{self, Column, Row};
use anyhow::{Result, bail};
use trueaxis::Axis;
use trueaxis::kinematics::Tool;
use trueaxis::machine::MachineSettings;

pub(super) fn run(common: &Common, settings: &MachineSettings) -> Result<()> {
    let kinematics = kinematics(common, settings)?;
    let columns = AXIS_COLUMNS.map(|name| Column { name, needed: false });
    let mut rows = csv_in::open(&common.input, &columns, "positions")?;
    for (axis, (column, present)) in Axis::ALL.into_iter().zip(AXIS_COLUMNS.iter().zip(rows.present)) {
        if present && !kinematics.has(axis) {
            bail!(
                "{}: found the column {column}, needed only axes of the machine {} ({})",
                common.input.display(),
                settings.name,
                settings.chain
            );
        }
    }
    let found = TOOL_COLUMNS.into_iter().chain([MARGIN]).map(str::to_owned);
    let mut sheet = Sheet::new(common, settings, rows.header.iter().cloned().chain(found).collect())?;
    while let Some(Row { line, values: axes }) = rows.next()? {
        for known in &settings.axes {
            let ([low, high], index) = (known.travel, known.axis.index());
            if axes[index] < low || axes[index] > high {
                let needed = format!("the declared travel, {low} to {high}");
                return Err(rows.error(line, AXIS_COLUMNS[index], axes[index], needed));
            }
        }
        let Tool { tip, axis } = kinematics.forward(&axes);
        let margin = kinematics.singularity_margin_deg(&axes);
        sheet.row(rows.cells(), [tip.x, tip.y, tip.z, axis.x, axis.y, axis.z, margin])?;
    }
    sheet.finish()
}
