//! The reference on the spans of a move.

use trueaxis::contour::{Reference, Span};

/// The reference at parameter `u` of a move whose first and last span have the given numbers; `spans` begins with `number`.
pub(super) fn reference(
    spans: &[Span<f64, f64>],
    number: u32,
    [first, last]: [u32; 2],
    u: f64,
    near: &mut u32,
) -> Reference<f64> {
    *near = (*near).clamp(first, last);
    let at = |near: u32| spans.get((near - number) as usize);
    while *near < last && at(*near).is_some_and(|span| span.u_range()[1] < u) {
        *near += 1;
    }
    while *near > first && at(*near).is_some_and(|span| span.u_range()[0] > u) {
        *near -= 1;
    }
    Reference { span: *near, t: at(*near).map_or(0.0, |span| span.t_of(u)) }
}
