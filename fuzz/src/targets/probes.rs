//! Readings of three and five probes: `trueaxis roundness` and the desk.

use crate::alone::alone;
use crate::execution::SLOWEST;
use crate::{Target, no_repair, outcome, refusal};
use anyhow::Result;
use std::path::Path;
use trueaxis_evaluation::probes::Probes;
use trueaxis_evaluation::roundness::{COLUMNS, Evaluation, Plan, Request, Zones};
use trueaxis_evaluation::rows::Rows;

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "probes",
    about: "readings of three and five probes (CSV), with angles and without, through separation and evaluation",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/csv.dict"),
    slowest: SLOWEST,
};

const FILE: &str = "probes.csv";
/// Points per revolution: the fewest accepted.
const POINTS: usize = 64;
/// With more rows, evaluation takes too long here.
const MOST_ROWS: usize = 3 * POINTS;

/// Angles of five probes, degrees.
const FIVE: [f64; 5] = [0.0, 39.2, 101.3, 158.9, 243.3];

/// Requests, selected by the length of the input: without a filter, with one, with an arm, by five probes.
fn plans() -> [Plan; 4] {
    let plain = Request {
        probes: Probes { n: POINTS, harmonics: Some([2, 15]), p: Some(11), q: Some(14), ..Probes::default() },
        arm: None,
        upr: None,
        noise_gain_limit: 10.0,
    };
    let filtered = Request { upr: Some(15), noise_gain_limit: 3.0, ..plain.clone() };
    let arm = Request { arm: Some([40.0, 300.0, 30.0]), ..plain.clone() };
    let five = Request {
        probes: Probes { p: None, q: None, angles_deg: Some(FIVE.to_vec()), ..plain.probes.clone() },
        ..plain.clone()
    };
    [plain, filtered, arm, five].map(|request| request.plan().expect("a good request"))
}

thread_local! {
    static PLANS: [Plan; 4] = plans();
}

fn run(bytes: &[u8]) {
    if bytes.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count() > MOST_ROWS {
        return;
    }
    let evaluate = |plan: &Plan| -> Result<Evaluation> {
        let mut rows = Rows::new(bytes, Path::new(FILE), &COLUMNS, |_| {})?;
        let readings = plan.read(&mut rows)?;
        drop(rows);
        let lengths: Vec<usize> = readings.probes.iter().map(Vec::len).collect();
        assert_eq!(lengths.len(), plan.arrangement().probes());
        assert!(lengths.iter().all(|length| *length > 0 && length.is_multiple_of(POINTS) && *length == lengths[0]));
        readings.note(plan.points()).iter().for_each(outcome::refused);
        let separations = plan.separate(&readings, || {})?;
        plan.evaluate(&separations, &readings)
    };
    let found = PLANS.with(|plans| alone(|| evaluate(&plans[bytes.len() % 4])));
    match found {
        Ok(found) => accepted(&found),
        Err(error) => refusal::of_file(&format!("{error:#}"), FILE, bytes),
    }
}

/// Figures are finite and do not contradict one another.
fn accepted(found: &Evaluation) {
    let document = &found.document;
    assert_eq!(document.n, POINTS);
    assert_eq!(document.per_revolution.len(), document.revolutions);
    let json = serde_json::to_string(document).expect("a document");
    // serde_json writes non-finite numbers as null; here two things may be null, and errors that five probes do not determine.
    let nulls = usize::from(document.upr.is_none()) + 2 * usize::from(document.spindle.x.asynchronous_um.is_none());
    match &document.agreement {
        None => assert_eq!(json.matches(":null").count(), nulls, "{json}"),
        Some(found) => assert!(found.noise_um.is_finite() && found.probes.iter().all(|of| of.residual_um.is_finite())),
    }
    let mut curves = found.profile.iter().chain(&found.x.mean_contour).chain(&found.y.mean_contour);
    assert!(curves.all(|value| value.is_finite()));
    for Zones { lsc_um, mzc_um, mic_um, mcc_um } in
        document.per_revolution.iter().map(|revolution| revolution.zones).chain([document.zones])
    {
        let rounding = 1e-9 * (1.0 + lsc_um);
        for zone in [lsc_um, mic_um, mcc_um] {
            assert!(0.0 <= mzc_um && mzc_um <= zone + rounding, "{json}");
        }
    }
    assert!(
        document
            .harmonics
            .iter()
            .all(|harmonic| harmonic.amplitude_um >= 0.0 && !(harmonic.suppressed && harmonic.amplitude_um > 0.0))
    );
    outcome::accepted();
    outcome::saw((document.revolutions, document.resampling.is_some()));
    document.warnings.iter().for_each(outcome::refused);
}

fn seeds() -> Vec<Vec<u8>> {
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / POINTS as f64;
    let reading = |i: usize, phi: f64| (2.0 * (3.0 * (angle(i) + phi)).cos() + 10.0 * (angle(i) + phi).sin()) as f32;
    let row = |i: usize, phi: &[f64]| phi.iter().map(|phi| format!("{:.1}", reading(i, *phi))).collect::<Vec<_>>();
    let three = [0, 11, 25].map(angle);
    let mut plain = String::from("h1_um,h2_um,h3_um\n");
    let mut five = String::from("h1_um,h2_um,h3_um,h4_um,h5_um\n");
    let mut angles = String::from("theta_deg;h1_um;h2_um;h3_um\n");
    for i in 0..POINTS {
        plain += &(row(i, &three).join(",") + "\n");
        five += &(row(i, &FIVE.map(f64::to_radians)).join(",") + "\n");
        angles += &format!("{};{}\n", 5.625 * i as f64, row(i, &three).join(";")).replace('.', ",");
    }
    for i in POINTS..POINTS + 4 {
        angles += &format!("{};{}\n", 5.625 * (i - POINTS) as f64, row(i, &three).join(";")).replace('.', ",");
    }
    // A comment gives each the length that selects its request.
    let asked = [(&plain, 0), (&angles, 0), (&plain, 1), (&plain, 2), (&five, 3)];
    let padded = asked.map(|(text, plan)| {
        let comment = (4 + plan + 4 - (text.len() + 2) % 4) % 4;
        format!("{text}#{}\n", " ".repeat(comment))
    });
    padded.map(String::into_bytes).into()
}
