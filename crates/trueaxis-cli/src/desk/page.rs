//! The page that was built in.

use anyhow::{Context, Result};
use flate2::read::GzDecoder;
use std::io::Read;

/// As it is served to browsers.
pub(super) const COMPRESSED: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/desk.html.gz"));

/// As it is written.
pub(super) fn plain() -> Result<Vec<u8>> {
    let mut page = Vec::new();
    GzDecoder::new(COMPRESSED).read_to_end(&mut page).context("the page that was built in")?;
    Ok(page)
}
