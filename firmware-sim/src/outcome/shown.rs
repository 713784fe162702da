//! Tables of the outcome.

use super::Outcome;
use crate::report::AxisReport;
use trueaxis_evaluation::shown::{Cell, Shown, Table};
use trueaxis_report::number::{count, percent, quantity};
use trueaxis_sim::Scenario;
use trueaxis_sim::run::{AngleSize, ErrorSize, Kind, Tallies};

impl Outcome {
    /// Errors of the runs, cost of the step, faults and remarks; correction and limits of the axes recorded, if any.
    pub fn shown(&self, scenario: &Scenario, axes: &[AxisReport]) -> Shown {
        let settings = &scenario.machine.settings;
        let simulated_s = self.cycles as f64 * scenario.period_s();
        let runs = self.machines();
        let speed = runs.len() as f64 * simulated_s / self.wall_s.max(1e-9);
        let took = format!("{} runs in {:.1} s, {speed:.0} times real time each", runs.len(), self.wall_s);
        let mut tables = vec![contour(&runs)];
        if scenario.five_axis {
            tables.extend([orientation(&runs), reported(&runs)]);
        }
        tables.extend((!axes.is_empty()).then(|| limits(axes)));
        tables.extend([self.cost(), digests(&runs), self.fault_table(scenario)]);
        let changes = scenario.settings.changes().into_iter();
        let changes = changes.map(|(key, value, default)| format!("setting {key} = {value} (default {default})"));
        Shown {
            title: "Compensated servo step".into(),
            summary: vec![
                format!("{} ({})", settings.name, settings.chain),
                format!("{}, {simulated_s:.1} s at {} Hz", scenario.program.name, scenario.rate_hz()),
                format!("{} servo cycles", count(self.cycles)),
                if self.compensated.faults.is_empty() { "no faults" } else { "with faults" }.into(),
            ],
            result: result(
                self.uncompensated.error.max_um,
                self.full.as_ref().unwrap_or(&self.compensated).error.max_um,
            ),
            notes: changes.chain([took]).chain(self.notes(scenario)).collect(),
            tables,
            ..Shown::default()
        }
    }

    fn cost(&self) -> Table {
        let latency = self.latency.summary();
        let rows = [
            ("minimum", latency.min_ns),
            ("median", latency.p50_ns),
            ("99 %", latency.p99_ns),
            ("99.99 %", latency.p99_99_ns),
            ("maximum", latency.max_ns),
            ("budget", latency.budget_ns),
            ("period", latency.period_ns),
            ("steps over the budget", latency.over_budget),
            ("missed deadlines", latency.missed_deadlines),
        ];
        let rows = rows.map(|(name, value)| (name, Cell::count(value as usize)));
        Table::figures("Cost of one step in ns, wall time on this host (shown, never gated)", rows)
    }

    fn fault_table(&self, scenario: &Scenario) -> Table {
        let rows = self.faults(scenario).map(|fault| {
            let cycles = Cell::count(fault.cycles as usize);
            let place = format!("axis {}, line {}", fault.axis, fault.line);
            vec![
                fault.fault.as_str().into(),
                Cell::count(fault.code.into()),
                Cell::fixed(fault.time_s, 4),
                cycles,
                place.into(),
            ]
        });
        Table::new("Faults, corrected", ["fault", "code", "first at, s", "cycles", "where"], rows)
    }
}

/// The change of the largest contour error from the first run to the best.
fn result(before: f64, after: f64) -> String {
    let size = |um: f64| quantity(um, "µm");
    if (after - before).abs() > 0.0 {
        let verb = if after < before { "fell" } else { "rose" };
        let share = if before > 0.0 { format!(" (to {})", percent(after, before)) } else { String::new() };
        format!("The largest contour error of the tool tip {verb} from {} to {}{share}.", size(before), size(after))
    } else {
        format!("The largest contour error of the tool tip stayed at {}.", size(before))
    }
}

fn contour(runs: &[(Kind, Tallies)]) -> Table {
    let first = runs.first().map_or(ErrorSize::default(), |(_, run)| run.error);
    let rows = runs.iter().map(|(kind, run)| {
        let [max, rms] = [run.error.max_um, run.error.rms_um];
        let [max_left, rms_left] = [max / first.max_um, rms / first.rms_um].map(|share| Cell::fixed(100.0 * share, 1));
        vec![kind.words().into(), Cell::fixed(max, 3), Cell::fixed(rms, 3), max_left, rms_left]
    });
    let head = ["", "largest, µm", "RMS, µm", "largest left, %", "RMS left, %"];
    Table::new("True contour error of the tool tip while cutting", head, rows)
}

fn orientation(runs: &[(Kind, Tallies)]) -> Table {
    let rows = runs.iter().map(|(kind, Tallies { orientation: AngleSize { max_urad, rms_urad }, .. })| {
        vec![kind.words().into(), Cell::fixed(*max_urad, 2), Cell::fixed(*rms_urad, 2)]
    });
    Table::new("True angle of the tool from the programmed direction", ["", "largest, µrad", "RMS, µrad"], rows)
}

/// Without the servo alone: the step would report its tables' errors, which that machine does not have.
fn reported(runs: &[(Kind, Tallies)]) -> Table {
    let rows = runs.iter().filter(|(kind, _)| *kind != Kind::ServoOnly).map(|(kind, run)| {
        let (tip, angle) = (run.estimated, run.estimated_orientation);
        let tip = [tip.max_um, tip.rms_um].map(|um| Cell::fixed(um, 3));
        let angle = [angle.max_urad, angle.rms_urad].map(|urad| Cell::fixed(urad, 2));
        std::iter::once(kind.words().into()).chain(tip).chain(angle).collect()
    });
    let head = ["", "largest, µm", "RMS, µm", "largest, µrad", "RMS, µrad"];
    Table::new("Both as the step itself reports them", head, rows)
}

fn digests(runs: &[(Kind, Tallies)]) -> Table {
    let rows = runs.iter().map(|(kind, run)| vec![kind.words().into(), format!("{:08x}", run.digest).into()]);
    Table::new("Digest of every output", ["", "CRC-32"], rows)
}

/// Largest magnitude of a series; NaN if it has no defined value.
fn largest(series: &[[f64; 2]]) -> f64 {
    let magnitudes = series.iter().map(|point| point[1].abs()).filter(|value| value.is_finite());
    magnitudes.max_by(f64::total_cmp).unwrap_or(f64::NAN)
}

fn limits(axes: &[AxisReport]) -> Table {
    let rows = axes.iter().map(|axis| {
        let used = |series: &[[f64; 2]], limit: f64| {
            let found = largest(series);
            [Cell::number(found, 3), Cell::number(limit, 3), Cell::number(100.0 * found / limit, 3)]
        };
        let unit = if axis.rotary { "µrad, mrad/s, rad/s²" } else { "µm, mm/s, m/s²" };
        let correction = used(&axis.correction, axis.magnitude_limit);
        let slope = used(&axis.slope, axis.slope_limit);
        let acceleration = [Cell::number(axis.acceleration_limit, 3), unit.into()];
        std::iter::once(axis.name.as_str().into()).chain(correction).chain(slope).chain(acceleration).collect()
    });
    let head = [
        "axis",
        "largest correction",
        "limit",
        "used, %",
        "largest slope",
        "limit",
        "used, %",
        "acceleration limit",
        "units",
    ];
    Table::new("Correction and its limits", head, rows)
}

#[cfg(test)]
mod tests {
    use super::result;

    #[test]
    fn a_rise_is_not_called_a_fall() {
        assert!(result(18.4, 1.31).contains("fell from 18.4 µm to 1.31 µm (to 7.1 %)."));
        assert!(result(2.0, 3.0).contains("rose from 2.00 µm to 3.00 µm (to 150 %)"));
        assert!(result(2.0, 2.0).contains("stayed at 2.00 µm."));
        assert!(result(0.0, 3.0).contains("rose from 0.00 µm to 3.00 µm."));
        assert!(result(f64::NAN, f64::NAN).contains("stayed at – µm."));
    }
}
