//! Cycles of a three-axis machine, in the image's output format.

use trueaxis_recording::outputs::{Line, Wire, line_bytes};

/// Number of axes.
pub const AXES: usize = 3;

/// A cycle as numbers.
pub type Row = Line<AXES>;

/// Bytes of a cycle in scalar `R`.
pub const fn bytes<R: Wire>(gauge: bool) -> usize {
    line_bytes::<R>(AXES, gauge)
}

/// Decodes all complete cycles in the received bytes.
pub fn decode<R: Wire>(received: &[u8], gauge: bool) -> Vec<Row> {
    received.chunks_exact(bytes::<R>(gauge)).map(Row::read::<R>).collect()
}
