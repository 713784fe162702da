//! Tables and plots of roundness and spindle error.

use super::{AgreementEntry, Evaluation, HarmonicEntry, Plan, Revolution, RoundnessDocument, SpindleDirection, Zones};
use crate::circle::NAMES;
use crate::shown::{Cell, Curve, Look, Plot, Shown, Table, Uncertainty};
use trueaxis_metrology::separation::Arrangement;
use trueaxis_metrology::spindle::ErrorMotion;
use trueaxis_report::number::{shortest, significant};
use trueaxis_tables::text::counted;

/// The two directions of the spindle's error motion.
const DIRECTIONS: [&str; 2] = ["X, across probe 1", "Y, along probe 1"];
/// A limit above this many times the largest gain is only stated: drawn, it would flatten the columns.
const WITHIN: f64 = 30.0;

impl Zones {
    /// In the order of [`trueaxis_report::CIRCLES`].
    fn in_order(&self) -> [f64; 4] {
        [self.lsc_um, self.mzc_um, self.mcc_um, self.mic_um]
    }
}

impl Plan {
    /// Zones of the profile, error motion of the spindle; profile, harmonics and motion over the angle, and the development over
    /// the revolutions.
    pub fn shown(&self, evaluation: &Evaluation) -> Shown {
        let document = &evaluation.document;
        let filter = document.upr.map_or("no filter".to_owned(), |upr| format!("Gaussian filter {upr} UPR"));
        let revolutions = counted(document.revolutions, "revolution");
        let caption = format!("Roundness of the mean of {revolutions}, {filter}");
        let mut notes = document.warnings.clone();
        if document.revolutions < 2 {
            notes.push("a single revolution has no development and no asynchronous error motion".into());
        }
        Shown {
            title: "Roundness and spindle error".into(),
            summary: vec![
                format!("{revolutions} of {} points", document.n),
                self.angles(),
                filter,
                self.gains(document),
            ],
            notes,
            tables: [zones(caption, document), spindle(document)]
                .into_iter()
                .chain(document.agreement.as_ref().map(probes))
                .collect(),
            plots: [profile(&evaluation.profile)]
                .into_iter()
                .chain(self.harmonics(&document.harmonics))
                .chain([motion([&evaluation.x, &evaluation.y])])
                .chain(development(&document.per_revolution))
                .collect(),
            ..Shown::default()
        }
    }

    fn angles(&self) -> String {
        if let Arrangement::Three(gain) = self.arrangement() {
            let [phi2, phi3] = [gain.phi2(), gain.phi3()].map(|phi| shortest(phi.to_degrees()));
            return format!("φ2 = {phi2}°, φ3 = {phi3}°");
        }
        let angles: Vec<String> = self.arrangement().degrees().into_iter().map(shortest).collect();
        format!("{} probes at {}°", angles.len(), angles.join("°, "))
    }

    /// Suppressed harmonics, the largest noise gain and its limit.
    fn gains(&self, document: &RoundnessDocument) -> String {
        let suppressed = document.harmonics.iter().filter(|of| of.suppressed).map(|of| of.k.to_string());
        let suppressed: Vec<String> = suppressed.collect();
        let which =
            if suppressed.is_empty() { "no harmonic".into() } else { format!("harmonics {}", suppressed.join(", ")) };
        let worst = significant(worst_gain(&document.harmonics), 3);
        let limit = shortest(self.noise_gain_limit);
        format!("{which} suppressed: noise gain up to {worst}, limit {limit}")
    }

    fn harmonics(&self, harmonics: &[HarmonicEntry]) -> [Plot; 2] {
        let values = |suppressed: bool, value: fn(&HarmonicEntry) -> f64| {
            harmonics.iter().map(|of| if of.suppressed == suppressed { value(of) } else { f64::NAN }).collect()
        };
        let plot = |title: &str, y, caption, curves| Plot {
            section: "Harmonics",
            title: title.into(),
            x: ("undulations per revolution".into(), ""),
            y,
            look: Look::Columns,
            caption,
            at: harmonics.iter().map(|of| of.k.into()).collect(),
            curves,
            ..Plot::default()
        };
        let limit = self.noise_gain_limit;
        let amplitudes = Curve::new("amplitude", 6, values(false, |of| of.amplitude_um));
        let kept = Curve::new("kept", 7, values(false, |of| of.noise_gain));
        let suppressed = Curve::new("suppressed", 4, values(true, |of| of.noise_gain));
        [
            plot(
                "Amplitude of every harmonic",
                ("amplitude", "µm"),
                "Of the mean profile, before the filter; a suppressed harmonic has none.",
                vec![amplitudes],
            ),
            Plot {
                logarithmic: true,
                limit: Some(limit).filter(|limit| *limit < WITHIN * worst_gain(harmonics)),
                ..plot(
                    "Noise gain of every harmonic",
                    ("noise gain", ""),
                    "How much the probes' noise grows in each harmonic of the profile.",
                    vec![kept, Curve { dashed: true, ..suppressed }],
                )
            },
        ]
    }
}

fn worst_gain(harmonics: &[HarmonicEntry]) -> f64 {
    harmonics.iter().map(|of| of.noise_gain).fold(1.0, f64::max)
}

/// Curves over the angle of a revolution.
fn over_angle(section: &'static str, title: &str, y: (&'static str, &'static str), curves: Vec<Curve>) -> Plot {
    let points = curves.first().map_or(0, |curve| curve.values.len());
    let at = (0..points).map(|i| 360.0 * i as f64 / points as f64).collect();
    Plot { section, title: title.into(), x: ("θ".into(), "°"), y, at, curves, ..Plot::default() }
}

fn profile(profile: &[f64]) -> Plot {
    let curve = Curve::new("profile", 8, profile.to_vec());
    over_angle("Profile", "Mean profile behind the filter", ("profile", "µm"), vec![curve])
}

/// Chooses one of two values.
type OfTwo = fn(f64, f64) -> f64;

/// Mean contours in both directions, and the ends of the single revolutions at every angle.
fn motion(directions: [&ErrorMotion; 2]) -> Plot {
    let mut curves = Vec::new();
    for (colour, (of, name)) in directions.into_iter().zip(DIRECTIONS).enumerate() {
        let mean = &of.mean_contour;
        curves.push(Curve::new(name, colour, mean.clone()));
        let ends: [(&str, OfTwo); 2] = [("lowest", f64::min), ("highest", f64::max)];
        if of.revolutions.len() > mean.len() {
            curves.extend(ends.map(|(end, of_two)| {
                let mut values = vec![f64::NAN; mean.len()];
                for revolution in of.revolutions.chunks_exact(mean.len()) {
                    values.iter_mut().zip(revolution).for_each(|(value, one)| *value = of_two(*value, *one));
                }
                Curve { dashed: true, ..Curve::new(format!("{}, {end}", &name[..1]), colour, values) }
            }));
        }
    }
    let title = "Error motion of the spindle over the angle";
    let caption = "Mean contours of the revolutions; dashed, where there are several: the lowest and highest of them at the angle.";
    Plot { caption, ..over_angle("Spindle", title, ("error motion", "µm"), curves) }
}

fn zones(caption: String, document: &RoundnessDocument) -> Table {
    let of = &document.centres_um;
    let centres = [of.lsc, of.mzc, of.mcc, of.mic];
    let rows = NAMES.into_iter().zip(document.zones.in_order()).zip(centres).enumerate();
    let rows = rows.map(|(circle, ((name, zone), [x, y]))| {
        let single = || document.per_revolution.iter().map(|of| of.zones.in_order()[circle]);
        let (least, most) = (single().fold(f64::INFINITY, f64::min), single().fold(f64::NEG_INFINITY, f64::max));
        std::iter::once(name.into()).chain([zone, x, y, least, most].map(|um| Cell::fixed(um, 3))).collect()
    });
    let header = [
        "circle",
        "zone, µm",
        "centre x, µm",
        "centre y, µm",
        "single revolutions from, µm",
        "single revolutions to, µm",
    ];
    Table::new(caption, header, rows)
}

/// Each probe against the others.
fn probes(agreement: &AgreementEntry) -> Table {
    let rows = agreement.probes.iter().enumerate().map(|(index, of)| {
        let with = |value: Option<f64>, error: Option<f64>, scale: f64| {
            let uncertainty = error.map(|error| Uncertainty::foreseen(scale * error));
            match uncertainty {
                Some(uncertainty) => [uncertainty.value(value.map(|value| scale * value)), uncertainty.cell()],
                None => [Cell::from("–"), Cell::from("–")],
            }
        };
        let angle = with(of.angle_error_deg, of.angle_error_standard_error_deg, 1.0);
        let sensitivity = with(of.sensitivity_error, of.sensitivity_error_standard_error, 100.0);
        let without = of.noise_without_um.map_or(Cell::from("–"), |um| Cell::number(um, 3));
        [Cell::count(index + 1), Cell::shortest(of.angle_deg), Cell::number(of.residual_um, 3), without]
            .into_iter()
            .chain(angle)
            .chain(sensitivity)
            .collect()
    });
    let caption = format!(
        "The probes against one another: they contradict each other like {} µm of noise",
        significant(agreement.noise_um, 3)
    );
    let header = [
        "probe",
        "angle, °",
        "contradiction, µm RMS",
        "noise without it, µm",
        "angle error, °",
        "±, °",
        "sensitivity error, %",
        "±, %",
    ];
    Table::new(caption, header, rows)
}

fn spindle(document: &RoundnessDocument) -> Table {
    let row = |(name, of): (&str, &SpindleDirection)| {
        let um = |um: Option<f64>| Cell::fixed(um, 3);
        vec![
            name.into(),
            um(Some(of.synchronous_um)),
            um(of.asynchronous_um),
            um(Some(of.total_um)),
            um(Some(of.once_per_revolution_um)),
            Cell::fixed(of.once_per_revolution_phase_deg, 1),
        ]
    };
    let header =
        ["direction", "synchronous, µm", "asynchronous, µm", "total, µm", "once per revolution, µm", "its phase, °"];
    let rows = DIRECTIONS.into_iter().zip([&document.spindle.x, &document.spindle.y]).map(row);
    Table::new("Error motion of the spindle, ISO 230-7", header, rows)
}

/// Zones and error motion of every revolution; nothing for a single one.
fn development(revolutions: &[Revolution]) -> Vec<Plot> {
    if revolutions.len() < 2 {
        return Vec::new();
    }
    let plot = |title: &str, quantity, curves| Plot {
        section: "Development over the revolutions",
        title: title.into(),
        x: ("revolution".into(), ""),
        y: (quantity, "µm"),
        look: Look::Dotted,
        at: revolutions.iter().map(|of| of.revolution as f64).collect(),
        curves,
        ..Plot::default()
    };
    let zone = |(circle, colour): (usize, usize)| {
        let values = revolutions.iter().map(|of| of.zones.in_order()[circle]);
        Curve::new(&NAMES[circle][..3], colour, values.collect())
    };
    let [x, y] = [|of: &Revolution| of.x_from_mean_um, |of: &Revolution| of.y_from_mean_um]
        .map(|of| revolutions.iter().map(of).collect());
    let directions = DIRECTIONS.into_iter().zip([x, y]).enumerate();
    let directions = directions.map(|(colour, (name, values))| Curve::new(name, colour, values));
    vec![
        plot("Roundness of every revolution", "zone", [6, 5, 3, 7].into_iter().enumerate().map(zone).collect()),
        plot("Largest distance of every revolution from the mean contour", "distance", directions.collect()),
    ]
}
