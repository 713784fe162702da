//! Tables and plots of roundness and spindle error.

use super::{Plan, Revolution, RoundnessDocument, SpindleDirection, Zones};
use crate::circle::NAMES;
use crate::shown::{Cell, Curve, Look, Plot, Shown, Table};
use trueaxis_report::number::shortest;
use trueaxis_tables::text::counted;

/// The two directions of the spindle's error motion.
const DIRECTIONS: [&str; 2] = ["X, across probe 1", "Y, along probe 1"];

impl Zones {
    /// In the order of [`trueaxis_report::CIRCLES`].
    fn in_order(&self) -> [f64; 4] {
        [self.lsc_um, self.mzc_um, self.mcc_um, self.mic_um]
    }
}

impl Plan {
    /// Zones of the profile, error motion of the spindle, and their development over the revolutions.
    pub fn shown(&self, document: &RoundnessDocument) -> Shown {
        let filter = document.upr.map_or("no filter".to_owned(), |upr| format!("Gaussian filter {upr} UPR"));
        let revolutions = counted(document.revolutions, "revolution");
        let [phi2, phi3] = [self.gain().phi2(), self.gain().phi3()].map(|phi| shortest(phi.to_degrees()));
        let caption = format!("Roundness of the mean of {revolutions}, {filter}");
        let mut notes = document.warnings.clone();
        if document.revolutions < 2 {
            notes.push("a single revolution has no development and no asynchronous error motion".into());
        }
        Shown {
            title: "Roundness and spindle error".into(),
            summary: vec![
                format!("{revolutions} of {} points", document.n),
                format!("φ2 = {phi2}°, φ3 = {phi3}°"),
                filter,
            ],
            notes,
            tables: vec![zones(caption, document), spindle(document)],
            plots: development(&document.per_revolution),
            ..Shown::default()
        }
    }
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
        caption: "",
        at: revolutions.iter().map(|of| of.revolution as f64).collect(),
        curves,
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
