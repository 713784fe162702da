//! Rows of a result, as CSV and as JSON.

use super::common::{BRANCH, Common};
use crate::model;
use crate::output::Writer;
use anyhow::Result;
use serde_json::Value;
use std::borrow::Cow;
use trueaxis::machine::MachineSettings;

/// A result being written: cells as in the input, then the values found.
pub(super) struct Sheet<'p> {
    names: Vec<String>,
    csv: Option<Writer<'p>>,
    json: Option<Writer<'p>>,
    first: bool,
}

impl<'p> Sheet<'p> {
    pub(super) fn new(common: &'p Common, settings: &MachineSettings, names: Vec<String>) -> Result<Sheet<'p>> {
        let inputs = model::files(&common.machine).into_iter().chain([common.input.clone()]);
        let mut csv = (!common.json || common.output.is_some())
            .then(|| Writer::new(common.output.as_deref(), inputs))
            .transpose()?;
        if let Some(csv) = &mut csv {
            csv.put(format_args!("{}\n", names.join(",")))?;
        }
        let mut json = common.json.then(|| Writer::new(None, [])).transpose()?;
        if let Some(json) = &mut json {
            let [machine, chain] = [settings.name.as_str(), settings.chain.as_str()].map(Value::from);
            json.put(format_args!("{{\n  \"machine\": {machine},\n  \"chain\": {chain},\n  \"rows\": ["))?;
        }
        Ok(Sheet { names, csv, json, first: true })
    }

    pub(super) fn row<'c>(
        &mut self,
        cells: impl Iterator<Item = Cow<'c, str>> + Clone,
        values: impl IntoIterator<Item = f64> + Clone,
    ) -> Result<()> {
        if let Some(csv) = &mut self.csv {
            for cell in cells.clone() {
                csv.put(format_args!("{cell},"))?;
            }
            for (i, value) in values.clone().into_iter().enumerate() {
                csv.put(format_args!("{}{value}", if i > 0 { "," } else { "" }))?;
            }
            csv.put(format_args!("\n"))?;
        }
        if let Some(json) = &mut self.json {
            json.put(format_args!("{}\n    {{", if self.first { "" } else { "," }))?;
            // The cells have already been parsed as numbers.
            let numbers = cells.filter_map(|cell| cell.parse::<f64>().ok()).chain(values);
            for (i, (name, value)) in self.names.iter().zip(numbers).enumerate() {
                let number = if name == BRANCH { Value::from(value as u8) } else { Value::from(value) };
                json.put(format_args!("{}\"{name}\": {number}", if i > 0 { ", " } else { " " }))?;
            }
            json.put(format_args!(" }}"))?;
        }
        self.first = false;
        Ok(())
    }

    pub(super) fn finish(self) -> Result<()> {
        if let Some(csv) = self.csv {
            csv.finish()?;
        }
        if let Some(mut json) = self.json {
            json.put(format_args!("\n  ]\n}}\n"))?;
            json.finish()?;
        }
        Ok(())
    }
}
