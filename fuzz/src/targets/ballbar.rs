//! Records of circular tests: `trueaxis ballbar`.

use crate::choice::one_in;
use crate::{Target, no_repair, outcome, refusal};
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;
use trueaxis::Axis;
use trueaxis_evaluation::ballbar::{Options, Test};

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "ballbar",
    about: "records of a circular test in its three formats, some completed to whole circles after the input",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/csv.dict"),
    slowest: Duration::from_secs(1),
};

const FILE: &str = "record.csv";
const RADIUS_MM: f64 = 100.0;
/// Longer inputs reach nothing new.
const MOST_ROWS: usize = 128;
/// One in so many valid but incomplete inputs is evaluated with the remaining circles appended; of these and of complete ones,
/// one in so many has the pitches searched, which takes most of the time.
const WHOLE_ONE_IN: u64 = 256;
const SEARCH_ONE_IN: u64 = 256;

/// A form's first line and rows.
struct Form {
    header: &'static str,
    rows: fn(angle_deg: f64, deviation_um: f64, direction: f64, number: usize) -> String,
}

const FORMS: [Form; 3] = [
    Form {
        header: "angle_deg,deviation_um,direction\n",
        rows: |angle, deviation, direction, _| format!("{angle},{deviation:.3},{direction}\n"),
    },
    Form {
        header: "t_s,x_cmd_mm,x_mm,y_cmd_mm,y_mm\n",
        rows: |angle, deviation, _, number| {
            let [command, actual] = position(angle, deviation);
            format!("{number},{:.6},{:.6},{:.6},{:.6}\n", command[0], actual[0], command[1], actual[1])
        },
    },
    // halsampler's lines have no header.
    Form {
        header: "",
        rows: |angle, deviation, _, number| {
            let [command, actual] = position(angle, deviation);
            format!("{number} {:.6} {:.6} {:.6} {:.6}\n", command[0], actual[0], command[1], actual[1])
        },
    },
];

fn position(angle_deg: f64, deviation_um: f64) -> [[f64; 2]; 2] {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    [RADIUS_MM, RADIUS_MM + 1e-3 * deviation_um].map(|radius| [10.0 + radius * cos, radius * sin - 5.0])
}

fn run(bytes: &[u8]) {
    if bytes.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count() > MOST_ROWS {
        return;
    }
    let pitches_mm = if one_in(SEARCH_ONE_IN, bytes) { [None; 2] } else { [Some(5.0), Some(4.0)] };
    let options = Options { radius_mm: RADIUS_MM, axes: [Axis::X, Axis::Y], pitches_mm };
    let refused = evaluate(bytes, &options);
    let good =
        ["needed at least", "needed circles", "needed whole circles"].iter().any(|words| refused.contains(words));
    let form = FORMS.iter().position(|form| bytes.starts_with(form.header.as_bytes()));
    if let Some(form) = form.filter(|_| good && bytes.ends_with(b"\n")) {
        outcome::accepted();
        outcome::saw(form);
        if one_in(WHOLE_ONE_IN, bytes) {
            let lines = |text: &[u8]| text.iter().filter(|byte| **byte == b'\n').count();
            let own = lines(bytes) - lines(FORMS[form].header.as_bytes());
            let rest = rows(form).get(own..).unwrap_or_default().concat();
            evaluate(&[bytes, rest.as_bytes()].concat(), &options);
        }
    }
}

/// Evaluates a record and checks every figure; returns the refusal, if any.
fn evaluate(bytes: &[u8], options: &Options) -> String {
    let test = match Test::read(bytes, Path::new(FILE), options, outcome::refused) {
        Ok(test) => test,
        Err(error) => {
            let refused = format!("{error:#}");
            refusal::of_file(&refused, FILE, bytes);
            return refused;
        }
    };
    outcome::accepted();
    let document = test.document();
    let text = serde_json::to_string(&document).expect("a document");
    let shares = document.shares.iter().map(|share| share.share).sum::<f64>();
    assert!(document.readings == test.readings.len() && document.sigma_um >= 0.0, "{text}");
    assert!(document.shares.iter().all(|share| (0.0..=1.0).contains(&share.share)) && shares < 1.0 + 1e-9, "{text}");
    let finite = document.centre_um.iter().chain([&document.squareness_urad, &document.scale_mismatch_ppm]);
    assert!(finite.into_iter().all(|value| value.is_finite()), "{text}");
    for (own, both) in [(document.g_um.ccw, document.g_b_um), (document.g_um.cw, document.g_b_um)] {
        let (Some(own), Some(both)) = (own, both) else { continue };
        assert!(own >= 0.0 && own <= both * (1.0 + 1e-12), "G above G(b): {text}");
    }
    outcome::saw(document.warnings.len());
    String::new()
}

/// Two circles of a machine with squareness and lost motion, row by row.
fn rows(form: usize) -> &'static [String] {
    static ROWS: [OnceLock<Vec<String>>; FORMS.len()] = [const { OnceLock::new() }; FORMS.len()];
    ROWS[form].get_or_init(|| {
        let way = |direction: f64| (0..90).map(move |k| (direction, f64::from(k) * 4.0 + 0.5));
        let places = way(1.0).chain(way(-1.0).map(|(direction, angle)| (direction, 360.0 - angle)));
        let row = |(number, (direction, angle)): (usize, (f64, f64))| {
            let (sin, cos) = angle.to_radians().sin_cos();
            let deviation = -3.0 * sin * cos + 2.0 * (direction * sin).signum() * cos + 0.2 * (50.0 * cos).sin();
            (FORMS[form].rows)(angle, deviation, direction, number)
        };
        places.enumerate().map(row).collect()
    })
}

fn seeds() -> Vec<Vec<u8>> {
    let start = |form: usize, count: usize| format!("{}{}", FORMS[form].header, rows(form)[..count].concat());
    let forms = (0..FORMS.len()).flat_map(|form| [start(form, 2), start(form, 100)]);
    let semicolons = "direction;angle_deg;deviation_um\n1;0,5;1,25\n-1;4,5;0,001\n# end\n";
    forms.chain([semicolons.into()]).map(String::into_bytes).collect()
}
