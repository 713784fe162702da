//! Margins of the contour feedback by a scan of its open loop, written apart from the check at configuration.
//!
//! ```text
//! L(s) = (K_p + K_i/s) (k_ff s + K_v)/(s + K_v) · 1/(1 + s t_v) · e^(−s t_d)        t_v = 1/K_vp + current loop
//! ```
//!
//! The correction is added to the command and passes the drive's velocity feed-forward like it: without k_ff in the loop,
//! gains are permitted that make one plant in a hundred unstable.

use trueaxis::machine::DriveFigures;

/// Smallest phase margin, degrees, and gain margin, dB, that a configuration has to leave.
pub(crate) const NEEDED: [f64; 2] = [60.0, 12.0];

/// Phase margin, degrees, and gain margin, dB; infinite where the loop never gets to a gain of 1 or a phase of −180°.
pub(crate) fn margins(drive: &DriveFigures, [proportional, integral]: [f64; 2]) -> [f64; 2] {
    let lag = 1.0 / drive.velocity_gain_per_s + drive.current_loop_s;
    let open = |w: f64| {
        let ahead = drive.velocity_feed_forward * w / drive.position_gain_per_s;
        let gain = proportional.hypot(integral / w) * 1.0_f64.hypot(ahead)
            / (1.0_f64.hypot(w / drive.position_gain_per_s) * 1.0_f64.hypot(w * lag));
        let phase = ahead.atan()
            - (integral / w).atan2(proportional)
            - (w / drive.position_gain_per_s).atan()
            - (w * lag).atan()
            - w * drive.dead_time_s;
        [gain, phase.to_degrees()]
    };
    let (mut phase_margin, mut gain_margin) = (f64::INFINITY, f64::INFINITY);
    let mut before = open(1e-3);
    let mut w = 1e-3;
    while w < 1e5 {
        w *= 1.02;
        let here = open(w);
        if (before[0] >= 1.0) != (here[0] >= 1.0) {
            phase_margin = phase_margin.min(180.0 + here[1]);
        }
        if before[1] > -180.0 && here[1] <= -180.0 {
            gain_margin = gain_margin.min(-20.0 * here[0].log10());
        }
        before = here;
    }
    [phase_margin, gain_margin]
}

/// Whether the gains may be configured.
pub(crate) fn permitted(drive: &DriveFigures, gains: [f64; 2]) -> bool {
    margins(drive, gains).iter().zip(NEEDED).all(|(found, needed)| *found >= needed)
}

#[test]
fn margins_of_a_pure_integrator_behind_a_dead_time() {
    // K_i/s e^(−s t_d) with everything else fast: crosses 1 at K_i, −180° at π/(2 t_d).
    let drive = DriveFigures {
        position_gain_per_s: 1e7,
        velocity_gain_per_s: 1e7,
        reset_time_s: 1.0,
        velocity_feed_forward: 0.0,
        current_loop_s: 1e-9,
        dead_time_s: 0.01,
    };
    let [phase, gain] = margins(&drive, [0.0, 20.0]);
    let expected = 20.0 * (std::f64::consts::PI / (2.0 * 0.01) / 20.0).log10();
    assert!((phase - (90.0 - 0.2_f64.to_degrees())).abs() < 0.5 && (gain - expected).abs() < 0.2, "{phase} {gain}");
}
