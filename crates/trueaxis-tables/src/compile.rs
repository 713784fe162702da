//! Compiles tables for the controller: the bytes of a `.tcomp` file.

use crate::{Machine, Table};
use trueaxis::Config;
use trueaxis::check::{self, Spread};
use trueaxis::contour::Method;
use trueaxis::error::{ConfigError, Field};
use trueaxis::machine::{AXES, Axis, Row};
use trueaxis::tcomp::{
    MAGIC, Stored, TableHeader, VERSION, VERSION_WITHOUT_ADDITIONS, VERSION_WITHOUT_ENCODERS, VERSION_WITHOUT_GRIDS,
    VERSION_WITHOUT_PERIODS, additions, checksum, machine_id, notch,
};

/// The compiled form of a machine, byte by byte as in [`trueaxis::tcomp`]. The result is deterministic.
///
/// # Errors
/// Everything that [`check::machine`] refuses; a table with values in a component that it marks as not given, or with two
/// different directions although it is marked as having one.
pub fn compile(machine: &Machine) -> Result<Vec<u8>, ConfigError> {
    if machine.tables.len() != machine.settings.axes.len() {
        let found = machine.tables.len() as f64;
        return Err(ConfigError::new(Field::Axes, found, "one entry of tables for each axis"));
    }
    check::machine(&machine.settings, |axis| machine.rows(axis), &machine.grids())?;
    let mut settings = machine.settings.clone();
    check::decide_notches(&mut settings);
    let unencodable = |_| ConfigError::new(Field::Name, 0.0, "settings that postcard can encode");
    let mut payload = postcard::to_stdvec(&Stored(&machine.settings)).map_err(unencodable)?;
    for (settings, table) in machine.axes() {
        let header = match table {
            Some(table) => header(settings.axis, table)?,
            None => TableHeader::default(),
        };
        payload.extend(postcard::to_stdvec(&header).map_err(unencodable)?);
        for row in table.iter().flat_map(|table| &table.rows) {
            write_row(&mut payload, &header, row);
        }
    }
    let encoders = machine.settings.axes.iter().map(|axis| axis.encoder_resolution);
    let figures = machine.settings.axes.iter().flat_map(additions);
    let periods = &machine.settings.periodic;
    let version = if !periods.is_empty() {
        VERSION
    } else if figures.clone().any(|figure| figure != 0.0) {
        VERSION_WITHOUT_PERIODS
    } else if encoders.clone().any(|step| step.is_some()) {
        VERSION_WITHOUT_ADDITIONS
    } else if machine.grids.is_empty() {
        VERSION_WITHOUT_GRIDS
    } else {
        VERSION_WITHOUT_ENCODERS
    };
    if version != VERSION_WITHOUT_GRIDS {
        // The check limits the number of grids.
        payload.push(machine.grids.len() as u8);
    }
    for grid in &machine.grids {
        payload.extend(postcard::to_stdvec(&Stored(grid.header())).map_err(unencodable)?);
        payload.extend(grid.bytes());
    }
    if version >= VERSION_WITHOUT_ADDITIONS {
        payload.extend(encoders.flat_map(|step| step.unwrap_or(0.0).to_le_bytes()));
    }
    if version >= VERSION_WITHOUT_PERIODS {
        payload.extend(figures.flat_map(f64::to_le_bytes));
        let notches = settings.axes.iter().map(notch);
        if version == VERSION || notches.clone().any(|gain| gain > 0.0) {
            payload.extend(notches.flat_map(f64::to_le_bytes));
        }
    }
    if version == VERSION {
        // The settings hold few.
        payload.push(periods.len() as u8);
        for period in periods {
            payload.extend(postcard::to_stdvec(&Stored(period)).map_err(unencodable)?);
        }
    }
    let mut bytes = MAGIC.to_vec();
    bytes.extend(version.to_le_bytes());
    bytes.extend(machine_id(&machine.settings.name, &machine.settings.chain).to_le_bytes());
    let length = u32::try_from(payload.len())
        .map_err(|_| ConfigError::new(Field::Table, payload.len() as f64, "at most 4 GiB of tables"))?;
    bytes.extend(length.to_le_bytes());
    bytes.extend(payload);
    bytes.extend(checksum(&bytes).to_le_bytes());
    Ok(bytes)
}

fn header(axis: Axis, table: &Table) -> Result<TableHeader, ConfigError> {
    let wrong = |row, found, needed| Err(ConfigError::new(Field::Table, found, needed).on(axis).at(row));
    for (index, row) in table.rows.iter().enumerate() {
        for ((forward, reverse), given) in row.forward.iter().zip(&row.reverse).zip(table.given) {
            if !given && (*forward != 0.0 || *reverse != 0.0) {
                return wrong(index, *forward, "zero in a component that is not given");
            }
            if !table.bidirectional && forward != reverse {
                return wrong(index, *reverse, "the forward value in a table that is not bidirectional");
            }
        }
    }
    let given = table.given.iter().enumerate().map(|(component, given)| u8::from(*given) << component).sum();
    if given == 0 {
        return wrong(0, 0.0, "at least one given component");
    }
    let rows = table.rows.len() as u32;
    Ok(TableHeader { present: true, given, bidirectional: table.bidirectional, rows })
}

fn write_row(payload: &mut Vec<u8>, header: &TableHeader, row: &Row) {
    payload.extend(row.position.to_le_bytes());
    for (twist, stored) in [(&row.forward, true), (&row.reverse, header.bidirectional)] {
        for (component, error) in twist.iter().enumerate() {
            if stored && header.given >> component & 1 == 1 {
                payload.extend(error.to_le_bytes());
            }
        }
    }
}

/// Builds the servo loop as a controller does at this rate, in single and in double precision, and drops it: a controller
/// accepts every machine that is accepted here. Gains that leave too little margin at the stated resonances are refused
/// here only.
///
/// # Errors
/// Everything that [`check::machine`] or [`Config::build`] refuses.
pub fn build(machine: &Machine, rate_hz: f64) -> Result<(), ConfigError> {
    let grids = machine.grids();
    let inverse_passes = check::machine(&machine.settings, |axis| machine.rows(axis), &grids)?;
    check::feedback_within(&machine.settings, 1.0 / rate_hz, |_| Spread::LEAST)?;
    let mut settings = machine.settings.clone();
    check::decide_notches(&mut settings);
    let config = Config {
        machine: &settings,
        grids: &grids,
        machine_id: machine_id(&machine.settings.name, &machine.settings.chain),
        tables_crc: 0,
        period_ns: (1e9 / rate_hz).round() as u32,
        inverse_passes,
        method: Method::Guarded,
    };
    let rows = |axis| machine.rows(axis);
    let scalars = config.requirement(rows);
    config.build_with_spare_slots::<f32, f64, AXES, _>(rows, &mut vec![0.0; scalars])?;
    config.build_with_spare_slots::<f64, f64, AXES, _>(rows, &mut vec![0.0; scalars]).map(|_| ())
}
