//! Cycles of a machine of three axes, as the image sends them.

use trueaxis_recording::outputs::{Line, Wire, line_bytes};

/// Number of axes.
pub const AXES: usize = 3;

/// A cycle as numbers.
pub type Row = Line<AXES>;

/// Bytes of a cycle in scalar `R`.
pub const fn bytes<R: Wire>(gauge: bool) -> usize {
    line_bytes::<R>(AXES, gauge)
}

/// All whole cycles in what was received.
pub fn decode<R: Wire>(received: &[u8], gauge: bool) -> Vec<Row> {
    received.chunks_exact(bytes::<R>(gauge)).map(Row::read::<R>).collect()
}
