component dahl "A drive with friction, for tests: position and velocity loop, mass, pre-sliding.";

pin in float cmd "Position command, mm";
pin out float pos "Position of the axis, mm, one period after the command";

param rw float position_gain = 110 "1/s";
param rw float velocity_gain = 800 "1/s";
param rw float reset_time = 0.006 "s";
param rw float feed_forward = 0.93 "Share of the velocity";
param rw float coulomb = 0.5 "Friction over velocity_gain, mm/s";
param rw float stribeck_share = 0.3;
param rw float stribeck_velocity = 2 "mm/s";
param rw float presliding = 0.006 "mm";

variable int started;
variable double last;
variable double x;
variable double v;
variable double q;
variable double m;
variable double f;

function _;
license "MIT OR Apache-2.0";
;;

#include <rtapi_math.h>

/* Explicit steps of 20 us; the current loop has a time constant of 0.25 ms. Written for the test alone. */
FUNCTION(_) {
    const double h = 2e-5;
    const int steps = (int)(fperiod / h + 0.5);
    double rate;
    int i;

    if (!started) {
        last = x = cmd;
        started = 1;
    }
    rate = (cmd - last) / fperiod;
    for (i = 0; i < steps; i++) {
        const double r = position_gain * (last + rate * h * (i + 0.5) - x) + feed_forward * rate;
        const double ratio = v / stribeck_velocity;
        const double force = velocity_gain * coulomb * (1.0 + stribeck_share / (1.0 + ratio * ratio)) * f;
        q += h * (r - v) / reset_time;
        m += h * (velocity_gain * (r - v + q) - m) / 2.5e-4;
        f += h * (v - fabs(v) * f) / presliding;
        v += h * (m - force);
        x += h * v;
    }
    last = cmd;
    pos = rint(x / 1e-5) * 1e-5;
}
