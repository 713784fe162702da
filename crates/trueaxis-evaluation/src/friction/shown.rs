//! Tables of the friction found.

use super::document::axis;
use super::{AxisFound, Deviation, FrictionDocument};
use crate::shown::{Cell, EXPANDED, Quantity, Shown, Table, Uncertainty};
use trueaxis_metrology::friction::Identified;
use trueaxis_report::number::significant;

/// Figures of an axis: quantity, symbol, unit. First those of friction, then those of its drive.
const FIGURES: [(&str, &str, &str); 9] = [
    ("Coulomb friction", "F_c/K_vp", "mm/s"),
    ("pre-sliding", "z", "µm"),
    ("Stribeck share", "s", ""),
    ("Stribeck velocity", "v_s", "mm/s"),
    ("viscous friction", "d/K_vp", ""),
    ("position gain", "K_v", "1/s"),
    ("velocity gain", "K_vp", "1/s"),
    ("reset time", "τ", "s"),
    ("velocity feed-forward", "k_ff", ""),
];
/// Number of figures of friction among [`FIGURES`].
const OF_FRICTION: usize = 5;

/// The figures of an axis, in the order of [`FIGURES`].
fn quantities(own: &AxisFound) -> impl Iterator<Item = Quantity> {
    let (f, d) = (&own.friction, &own.drive);
    let (fe, de) = (&own.expanded_uncertainties.friction, &own.expanded_uncertainties.drive);
    let known = [
        (f.coulomb_mm_per_s, fe.coulomb_mm_per_s),
        (f.presliding_um, fe.presliding_um),
        (f.stribeck_share, fe.stribeck_share),
        (f.stribeck_velocity_mm_per_s, fe.stribeck_velocity_mm_per_s),
        (f.viscous, fe.viscous),
        (d.position_gain_per_s, de.position_gain_per_s),
        (d.velocity_gain_per_s, de.velocity_gain_per_s),
        (d.reset_time_s, de.reset_time_s),
        (d.velocity_feed_forward, de.velocity_feed_forward),
    ];
    let drive = if own.drive_found { "held" } else { "the machine's" };
    FIGURES.into_iter().zip(known).enumerate().map(move |(k, ((quantity, symbol, unit), (value, half_width)))| {
        let held = Uncertainty::Held(if k < OF_FRICTION { "held" } else { drive });
        let uncertainty = half_width.map_or(held, Uncertainty::expanded);
        Quantity::new(quantity, unit, value, uncertainty).symbol(symbol)
    })
}

/// A table of spikes or errors: name, largest magnitude, root mean square.
pub fn deviations(caption: &str, name: &str, rows: impl IntoIterator<Item = (String, Deviation)>) -> Table {
    let rows = rows.into_iter().map(|(name, of)| vec![name.into(), Cell::number(of.max, 3), Cell::number(of.rms, 3)]);
    Table::new(caption, [name, "largest, µm", "RMS, µm"], rows)
}

/// The figures of all axes side by side, with those of simulated drives if there are any.
fn figures<'f>(caption: &str, axes: impl IntoIterator<Item = (&'f AxisFound, Option<[f64; FIGURES.len()]>)>) -> Table {
    let mut header = vec!["figure".to_owned()];
    let mut rows: Vec<Vec<Cell>> = FIGURES.map(|_| Vec::new()).into();
    for (own, truth) in axes {
        header.extend([own.axis.clone(), format!("{EXPANDED}, {}", own.axis)]);
        header.extend(truth.map(|_| format!("{}, true", own.axis)));
        for (k, (row, of)) in rows.iter_mut().zip(quantities(own)).enumerate() {
            if row.is_empty() {
                row.push(of.label().into());
            }
            row.extend(of.cells());
            row.extend(truth.map(|truth| Cell::number(truth[k], 4)));
        }
    }
    Table::new(caption, header, rows)
}

/// The figures found beside the true ones of simulated drives, of friction first, then of the drive.
pub fn against(found: &[Identified], truth: &[[f64; FIGURES.len()]]) -> Table {
    let found: Vec<AxisFound> = found.iter().map(axis).collect();
    figures("Found against the simulated drives", found.iter().zip(truth.iter().copied().map(Some)))
}

impl FrictionDocument {
    /// Resonances of all axes: one line each, also where none was found; `None` if they were not searched for.
    fn resonances(&self) -> Option<Table> {
        if self.axes.iter().all(|own| own.resonance.is_none() && own.resonance_not_found.is_none()) {
            return None;
        }
        let rows = self.axes.iter().map(|own| {
            let Some(found) = own.resonance else {
                let blank = || Cell::from("–");
                return vec![own.axis.as_str().into(), "not found".into(), blank(), blank(), blank(), blank(), blank()];
            };
            let of = |value: f64, half_width: f64| {
                let uncertainty = Uncertainty::expanded(half_width);
                [uncertainty.value(value), uncertainty.cell()]
            };
            let e = &found.expanded_uncertainties;
            let mut row = vec![own.axis.as_str().into()];
            row.extend(of(found.resonance_hz, e.resonance_hz));
            row.extend(of(100.0 * found.resonance_damping, 100.0 * e.resonance_damping));
            row.extend(of(found.load_share, e.load_share));
            row
        });
        let head = ["axis", "resonance, Hz", EXPANDED, "damping, %", EXPANDED, "share of the load", EXPANDED];
        Some(Table::new("Resonance of motor and load", head, rows))
    }

    /// Tables of the document: the figures of all axes side by side, spikes, fit.
    pub fn shown(&self) -> Shown {
        let spikes = self.axes.iter().flat_map(|AxisFound { axis, glitch_um: g, .. }| {
            [
                (format!("{axis} before, recorded"), g.before),
                (format!("{axis} predicted by the model"), g.predicted),
                (format!("{axis} after, expected"), g.after),
            ]
        });
        let fit = self.axes.iter().map(|own| {
            vec![
                own.axis.as_str().into(),
                Cell::count(own.reversals),
                Cell::count(own.fitted),
                Cell::number(own.residual_um, 3),
                Cell::number(100.0 * own.explained, 4),
                Cell::number(own.condition, 3),
            ]
        });
        let head = ["axis", "reversals", "parameters", "residual, µm", "explained, %", "condition number"];
        Shown {
            title: "Friction at reversals".into(),
            summary: vec![format!("{} samples at {} Hz", self.samples, significant(1.0 / self.period_s, 4))],
            notes: self.warnings.clone(),
            tables: [Some(figures("Figures found", self.axes.iter().map(|own| (own, None)))), self.resonances()]
                .into_iter()
                .flatten()
                .chain([deviations("Spikes at the reversals", "spikes", spikes), Table::new("Fit", head, fit)])
                .collect(),
            ..Shown::default()
        }
    }
}
