//! Result of a comparison.

use super::image::Core;
use super::outputs::Row;
use serde_json::{Value, json};
use std::time::Duration;
use trueaxis::contour::Flags;
use trueaxis::telemetry::Status;
use trueaxis::temperature::Growth;
use trueaxis_evaluation::shown::{Cell, Shown, Table};
use trueaxis_recording::Header;
use trueaxis_report::number::count;
use trueaxis_tables::text::counted;

/// Differences between two runs in nanometres, cycle by cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    /// Bound on the correction's difference in 99.9 % of the cycles. The direction of travel is decided at a threshold: where
    /// rounding decides a cycle earlier, lost motion is applied a cycle earlier.
    pub correction_p99_9_nm: f64,
    /// Largest difference of a correction.
    pub correction_max_nm: f64,
    /// Bound on the difference of the tip's contour error in 99.9 % of the cycles; a cycle that cannot be compared (`other`)
    /// exceeds any bound.
    pub contour_p99_9_nm: f64,
    /// Largest difference of the contour error among the comparable cycles.
    pub contour_max_nm: f64,
    /// Cycles in which only one run has a contour error, or the feet or faults differ.
    pub other: usize,
}

impl Difference {
    /// Compares two runs of the same recording.
    pub fn between(a: &[Row], b: &[Row]) -> Difference {
        let mut difference = Difference::default();
        let mut contour = Vec::with_capacity(a.len());
        let mut correction = Vec::with_capacity(a.len());
        let kinds = |row: &Row| (row.fault, row.status, row.flags & SAME);
        for (a, b) in a.iter().zip(b) {
            correction.push(a.correction.iter().zip(b.correction).map(|(a, b)| apart_nm(*a, b)).fold(0.0, f64::max));
            if kinds(a) != kinds(b) {
                difference.other += 1;
            } else if a.status & Status::CONTOUR.0 != 0 {
                contour.push(apart_nm(a.tip, b.tip));
            }
        }
        difference.contour_max_nm = contour.iter().copied().fold(0.0, f64::max);
        contour.resize(contour.len() + difference.other, f64::INFINITY);
        difference.contour_p99_9_nm = nearly_all(&mut contour);
        difference.correction_p99_9_nm = nearly_all(&mut correction);
        difference.correction_max_nm = correction.last().copied().unwrap_or(0.0);
        difference
    }
}

/// Sorts the values and returns the bound that 99.9 % of them stay below.
fn nearly_all(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get((0.999 * values.len() as f64) as usize).copied().unwrap_or(0.0)
}

/// Difference in nm of two values in mm; infinite if either is NaN.
fn apart_nm(a: f64, b: f64) -> f64 {
    let nm = 1e6 * (a - b).abs();
    if nm.is_nan() { f64::INFINITY } else { nm }
}

/// Flags that must agree for two feet to count as the same.
const SAME: u8 = Flags::AT_END.bits() | Flags::NOT_FOUND.bits() | Flags::COLD.bits();

/// Thermal growth over a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grown {
    /// Number of growths that took effect.
    pub in_force: usize,
    /// How many of these had a frozen share or a frozen line.
    pub not_good: usize,
    /// Smallest and largest offset of a line, mm.
    pub offset_mm: [f64; 2],
}

impl Grown {
    /// Summarises the growths that took effect.
    pub fn of(growths: &[Growth]) -> Grown {
        let offsets = || growths.iter().flat_map(|growth| growth.lines.into_iter().flatten()).map(|[offset, _]| offset);
        Grown {
            in_force: growths.len(),
            not_good: growths.iter().filter(|growth| !growth.is_good()).count(),
            offset_mm: [offsets().fold(0.0, f64::min), offsets().fold(0.0, f64::max)],
        }
    }
}

/// One core compared with the host.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The core.
    pub core: Core,
    /// Cycles run by the image.
    pub cycles: usize,
    /// Cycles run by the host.
    pub cycles_on_host: usize,
    /// Cycles in which image and host, in the same scalar, differ in any bit.
    pub differing: usize,
    /// The cycle from which the second tables were in force.
    pub exchange_at: Option<u32>,
    /// Telemetry records received.
    pub frames: usize,
    /// Telemetry records that cannot be decoded.
    pub frames_damaged: usize,
    /// Telemetry records that contradict the outputs.
    pub frames_contradicting: usize,
    /// Number of revolution records.
    pub revolutions: usize,
    /// Whether the host's revolutions are identical.
    pub revolutions_equal: bool,
    /// Thermal growth, if the run has any.
    pub growth: Option<Grown>,
    /// Wall time of the image.
    pub took: Duration,
    /// Difference between the image and the host in double precision.
    pub against_double: Difference,
    /// Fault codes, each with its number of cycles.
    pub faults: Vec<(u8, usize)>,
    /// The image's cycles.
    pub image: Vec<Row>,
    /// The host's cycles in the image's scalar.
    pub host: Vec<Row>,
    /// The host's cycles in double precision.
    pub double: Vec<Row>,
}

impl Comparison {
    /// Whether every cycle ran, equals the host's bit for bit, and was reported correctly.
    pub fn is_equal(&self) -> bool {
        self.cycles == self.cycles_on_host
            && self.differing == 0
            && self.frames == self.cycles
            && self.frames_damaged == 0
            && self.frames_contradicting == 0
            && self.revolutions_equal
    }

    /// Whether single and double precision agree within 2 nm in 99.9 % of the cycles, in correction and contour error.
    pub fn is_within(&self) -> bool {
        self.against_double.correction_p99_9_nm <= LIMIT_NM && self.against_double.contour_p99_9_nm <= LIMIT_NM
    }
}

/// Permitted difference between single and double precision.
const LIMIT_NM: f64 = 2.0;

pub(super) fn faults(rows: &[Row]) -> Vec<(u8, usize)> {
    let mut counts = std::collections::BTreeMap::new();
    rows.iter().filter(|row| row.fault != 0).for_each(|row| *counts.entry(row.fault).or_insert(0) += 1);
    counts.into_iter().collect()
}

/// Name of a figure, and its cell for a core.
type FigureOfCore<'f> = (&'f str, &'f dyn Fn(&Comparison) -> Cell);

/// Comparison of all cores.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Header of the recording.
    pub header: Header,
    /// The comparison of each core.
    pub comparisons: Vec<Comparison>,
}

impl Outcome {
    /// Whether all cores agree bit for bit and within the tolerance, and made the requested exchange of tables.
    pub fn is_good(&self) -> bool {
        let exchanged = |one: &Comparison| self.header.exchange_at.is_none() || one.exchange_at.is_some();
        self.comparisons.iter().all(|one| one.is_equal() && one.is_within() && exchanged(one))
    }

    /// Every core against the host.
    pub fn shown(&self) -> Shown {
        let header = &self.header;
        let cycles = format!("{} cycles at {} Hz", count(header.cycles.into()), 1e9 / f64::from(header.period_ns));
        let gauge = header.gauge.then(|| "with a gauge of three probes".into());
        let result = if self.is_good() {
            "In the same scalar image and host agree in every bit; single and double precision agree within 2 nm in 99.9 % of \
             the cycles."
        } else {
            "Image and host do not agree, although they must: see the table."
        };
        Shown {
            title: "Host and bare metal".into(),
            summary: [format!("recording {}", header.name), cycles].into_iter().chain(gauge).collect(),
            result: result.into(),
            notes: vec!["the recording went through the step on this host and in QEMU, cycle by cycle".into()],
            tables: vec![self.cycles(), self.differences(), self.events()],
            ..Shown::default()
        }
    }

    fn table(&self, caption: &str, rows: &[FigureOfCore<'_>]) -> Table {
        let cores = self.comparisons.iter().map(|one| one.core.title());
        let rows = rows
            .iter()
            .map(|(name, of)| std::iter::once((*name).into()).chain(self.comparisons.iter().map(of)).collect());
        Table::new(caption, std::iter::once("").chain(cores), rows)
    }

    fn cycles(&self) -> Table {
        self.table(
            "Image against host, in the same scalar",
            &[
                ("cycles in the image", &|one| Cell::count(one.cycles)),
                ("cycles on the host", &|one| Cell::count(one.cycles_on_host)),
                ("differing in a bit", &|one| Cell::count(one.differing)),
                ("telemetry records", &|one| Cell::count(one.frames)),
                ("damaged", &|one| Cell::count(one.frames_damaged)),
                ("contradicting the outputs", &|one| Cell::count(one.frames_contradicting)),
                ("revolutions of the gauge", &|one| Cell::count(one.revolutions)),
                ("wall time of the image, s", &|one| Cell::fixed(one.took.as_secs_f64(), 1)),
            ],
        )
    }

    fn differences(&self) -> Table {
        self.table(
            "Image against host in double precision",
            &[
                ("correction, 99.9 % of the cycles, nm", &|one| Cell::fixed(one.against_double.correction_p99_9_nm, 3)),
                ("correction, all, nm", &|one| Cell::fixed(one.against_double.correction_max_nm, 3)),
                ("contour error, 99.9 %, nm", &|one| Cell::fixed(one.against_double.contour_p99_9_nm, 3)),
                ("contour error, all, nm", &|one| Cell::fixed(one.against_double.contour_max_nm, 3)),
                ("cycles with another foot or fault", &|one| Cell::count(one.against_double.other)),
            ],
        )
    }

    fn events(&self) -> Table {
        let exchange = |one: &Comparison| match (one.exchange_at, self.header.exchange_at) {
            (Some(at), Some(asked)) => format!("requested in cycle {asked}, in force from {at}").into(),
            (None, Some(asked)) => format!("requested in cycle {asked}, not made").into(),
            _ => "none".into(),
        };
        let growth = |one: &Comparison| {
            one.growth.map_or("none".into(), |grown| {
                let [least, most] = grown.offset_mm.map(|mm| 1e3 * mm);
                let times = counted(grown.in_force, "time");
                format!("{times} in force, {} with a frozen share, {least:.1} to {most:.1} µm", grown.not_good).into()
            })
        };
        let faults = |one: &Comparison| {
            let faults = one.faults.iter().map(|(code, n)| format!("{code} ({})", counted(*n, "cycle")));
            let faults: Vec<String> = faults.collect();
            if faults.is_empty() { "none".into() } else { faults.join(", ").into() }
        };
        let revolutions =
            |one: &Comparison| if one.revolutions_equal { "as on the host" } else { "NOT as on the host" };
        self.table(
            "Events",
            &[
                ("revolutions of the gauge", &|one| revolutions(one).into()),
                ("exchange of tables", &exchange),
                ("thermal growth", &growth),
                ("faults: code (cycles)", &faults),
            ],
        )
    }

    /// The document that `--json` prints.
    pub fn json(&self) -> Value {
        let one = |one: &Comparison| {
            json!({
                "core": one.core.name(),
                "cycles": one.cycles,
                "cycles_on_host": one.cycles_on_host,
                "differing": one.differing,
                "exchange_at": one.exchange_at,
                "frames": one.frames,
                "frames_damaged": one.frames_damaged,
                "frames_contradicting": one.frames_contradicting,
                "revolutions": one.revolutions,
                "revolutions_equal": one.revolutions_equal,
                "growth": one.growth.map(|grown| json!({
                    "in_force": grown.in_force,
                    "not_good": grown.not_good,
                    "least_um": 1e3 * grown.offset_mm[0],
                    "largest_um": 1e3 * grown.offset_mm[1],
                })),
                "against_double_nm": {
                    "correction_p99_9": one.against_double.correction_p99_9_nm,
                    "correction_max": one.against_double.correction_max_nm,
                    "contour_p99_9": one.against_double.contour_p99_9_nm,
                    "contour_max": one.against_double.contour_max_nm,
                    "other_cycles": one.against_double.other,
                },
                "faults": one.faults.iter().map(|(code, n)| json!({"code": code, "cycles": n})).collect::<Vec<_>>(),
                "equal": one.is_equal(),
                "within_2_nm": one.is_within(),
            })
        };
        json!({
            "recording": self.header.name.as_str(),
            "cycles": self.header.cycles,
            "servo_rate_hz": 1e9 / f64::from(self.header.period_ns),
            "cores": self.comparisons.iter().map(one).collect::<Vec<_>>(),
            "good": self.is_good(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(sequence: u32) -> Row {
        Row {
            sequence,
            tables_crc: 1,
            fault: 0,
            status: Status::CONTOUR.0,
            flags: 0,
            drive: [0.0; 3],
            correction: [1e-3; 3],
            tip: 2e-3,
            lag: 0.0,
            encoder: 0.0,
        }
    }

    #[test]
    fn differences_are_those_that_were_put_in() {
        let double: Vec<Row> = (0..10_000).map(row).collect();
        assert_eq!(Difference::between(&double, &double), Difference::default());
        let mut single = double.clone();
        single[7].correction[2] += 1.5e-6;
        // Fewer than a thousandth of the cycles may differ by any amount.
        single[..8].iter_mut().for_each(|row| row.tip += 3e-6);
        single[9].fault = 2;
        let found = Difference::between(&single, &double);
        assert!((found.correction_max_nm - 1.5).abs() < 1e-6 && (found.contour_max_nm - 3.0).abs() < 1e-6, "{found:?}");
        assert_eq!((found.other, found.contour_p99_9_nm, found.correction_p99_9_nm), (1, 0.0, 0.0));
        single[10].flags = Flags::NOT_FOUND.bits();
        assert!(Difference::between(&single, &double).contour_p99_9_nm > LIMIT_NM);
        single[11].correction[0] = f64::NAN;
        assert!(Difference::between(&single, &double).correction_max_nm > LIMIT_NM);
        assert!(Difference::between(&single, &double).correction_p99_9_nm <= LIMIT_NM);
        single[20..31].iter_mut().for_each(|row| row.correction[1] += 3e-6);
        assert!(Difference::between(&single, &double).correction_p99_9_nm > LIMIT_NM);
    }
}
