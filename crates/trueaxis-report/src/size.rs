//! Sizes of a figure's parts, px.

/// Width of a half-page figure.
pub(crate) const HALF_PX: i32 = 550;
/// Smallest distance between two labels above the plot.
pub(crate) const LABEL_PX: f64 = 34.0;
/// Room for the labels of the vertical axis.
pub(crate) const LEFT: i32 = 62;
/// Room for the labels of the horizontal axis.
pub(crate) const BOTTOM: i32 = 40;
/// Margin at the right.
pub(crate) const RIGHT: i32 = 16;
/// Margin at the top.
pub(crate) const TOP: i32 = 10;

/// Width and height of the area inside the axes of a figure of this size.
pub(crate) const fn inside(width: i32, height: i32) -> [i32; 2] {
    [width - LEFT - RIGHT, height - TOP - BOTTOM]
}
