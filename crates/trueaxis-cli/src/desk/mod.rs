//! `trueaxis desk`.

#[cfg(feature = "desk")]
mod answer;
#[cfg(feature = "desk")]
mod page;
#[cfg(feature = "desk")]
mod server;

use anyhow::Result;
use clap::Args;
use std::path::PathBuf;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis desk";

pub(crate) const HELP: &str = "\
The desk is one page that works without a network. It runs the code of these commands and of the simulator in the \
browser, on files that are dropped into it and stay on this computer. Its figures are those that the command line \
prints.
  machine: tables plotted and edited, accuracy, volumetric error
  servo: a part program through the real step against simulated drives
  helicoid: the five axes of an involute flank, and the tool on it
  roundness: three probes; profile, spindle, harmonics, probe angles
  friction: friction and drives from recorded circles
  and tests, ballbar, calibration, keeping, thermal growth, uncertainty

The page is served to this computer alone (127.0.0.1) until Ctrl-C; -o writes it to a file that a browser opens \
from the disk.

More examples:
  # At port 9000 only:
  trueaxis desk --port 9000
  # The page as a file:
  trueaxis desk -o desk.html";

#[derive(Args)]
pub(crate) struct DeskArgs {
    /// Port to serve at; 0 selects any free one [default: 8471, or any free one if that is in use].
    #[arg(long, value_name = "P", conflicts_with = "output")]
    port: Option<u16>,
    /// Write the page to a file instead of serving it.
    #[arg(short, long, alias = "write", value_name = "HTML")]
    output: Option<PathBuf>,
}

/// Refuses, and explains how to get the page.
#[cfg(not(feature = "desk"))]
pub(crate) fn run(arguments: &DeskArgs) -> Result<()> {
    let DeskArgs { port: _, output: _ } = arguments;
    anyhow::bail!(
        "desk: found a trueaxis that was built without the page, needed one of `desk/build.sh` and then `cargo install --path \
         crates/trueaxis-cli --features desk`"
    )
}

#[cfg(feature = "desk")]
pub(crate) fn run(arguments: &DeskArgs) -> Result<()> {
    let Some(file) = &arguments.output else { return server::serve(arguments.port) };
    let mut outputs = trueaxis_tables::output::Outputs::of(std::env::current_exe());
    outputs.put(file, &page::plain()?)?;
    Ok(outputs.commit()?)
}
