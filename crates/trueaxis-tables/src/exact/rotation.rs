//! Rotation vectors and matrices.

use glam::{DMat3, DVec3};

/// Rotation matrix of a rotation vector (Rodrigues).
///
/// Below 0.01 rad sin θ/θ and (1 − cos θ)/θ² are the first three terms of their series, exact to the last bit.
pub(super) fn rotation(w: DVec3) -> DMat3 {
    let square = w.length_squared();
    let (a, b) = if square < 1e-4 {
        (1.0 - square / 6.0 * (1.0 - square / 20.0), 0.5 - square / 24.0 * (1.0 - square / 30.0))
    } else {
        let angle = square.sqrt();
        (angle.sin() / angle, (1.0 - angle.cos()) / square)
    };
    let cross = DMat3::from_cols(DVec3::new(0.0, w.z, -w.y), DVec3::new(-w.z, 0.0, w.x), DVec3::new(w.y, -w.x, 0.0));
    let outer = DMat3::from_cols(w * w.x, w * w.y, w * w.z);
    DMat3::from_diagonal(DVec3::splat(1.0 - b * square)) + cross * a + outer * b
}

/// Rotation vector of a rotation matrix that turns by less than half a revolution; the inverse of [`rotation`].
pub(super) fn rotation_vector(turn: DMat3) -> DVec3 {
    let sine =
        DVec3::new(turn.y_axis.z - turn.z_axis.y, turn.z_axis.x - turn.x_axis.z, turn.x_axis.y - turn.y_axis.x) * 0.5;
    let size = sine.length();
    // Of a small angle the sine is the angle to rounding, and 0/0 is to be avoided.
    if size < 1e-9 {
        return sine;
    }
    let cosine = 0.5 * (turn.x_axis.x + turn.y_axis.y + turn.z_axis.z - 1.0);
    sine * (size.atan2(cosine) / size)
}
