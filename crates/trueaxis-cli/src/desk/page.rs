//! The built-in page.

use anyhow::{Context, Result};
use flate2::read::GzDecoder;
use std::io::Read;

/// The page as served to browsers, gzip.
pub(super) const COMPRESSED: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/desk.html.gz"));

/// The page as written to a file.
pub(super) fn plain() -> Result<Vec<u8>> {
    let mut page = Vec::new();
    GzDecoder::new(COMPRESSED).read_to_end(&mut page).context("the page that was built in")?;
    Ok(page)
}
