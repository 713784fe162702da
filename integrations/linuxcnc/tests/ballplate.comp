component ballplate "A ball plate on a machine with errors, and its touch probe, for tests.";

pin in float position-#[3] "Positions of the drives of X, Y, Z, machine units";
pin out bit touch "The tip has met a ball";

param rw float unit = 1 "mm in a machine unit";
param rw float scale_#[3] "Scale error of X, Y, Z, ppm";
param rw float squareness "C0Y: Y turned about Z, urad";
param rw float reach "Radius of a ball and of the tip, mm";
param rw float ball_x_#[3] "Middles of the balls, mm";
param rw float ball_y_#[3];
param rw float ball_z_#[3];

function _;
license "MIT OR Apache-2.0";
;;

#include <rtapi_math.h>

/* Computes the true tip of a chain w b X Y Z t, in closed form: X moves along itself and rotates Y and Z, which it carries.
 * Written for the test alone. */
FUNCTION(_) {
    const double turn = 1e-6 * squareness;
    const double x = position(0) * unit * (1.0 + 1e-6 * scale(0));
    const double y = position(1) * unit * (1.0 + 1e-6 * scale(1));
    const double z = position(2) * unit * (1.0 + 1e-6 * scale(2));
    const double tip_x = x - y * sin(turn), tip_y = y * cos(turn);
    int touched = 0, k;

    for (k = 0; k < 3; k++) {
        const double dx = tip_x - ball_x(k), dy = tip_y - ball_y(k), dz = z - ball_z(k);
        touched |= dx * dx + dy * dy + dz * dz <= reach * reach;
    }
    touch = touched;
}
