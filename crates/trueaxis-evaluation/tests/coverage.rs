//! Coverage of the bands on simulated repeats: of 100 intervals of 95 %, 95 contain the truth.
//!
//! `TRUEAXIS_REPEATS=1000 cargo test -p trueaxis-evaluation --test evaluation coverage -- --nocapture` counts the full table
//! of docs/uncertainty.md. Without the variable the tests count fewer repeats, with a margin for chance. They generate the
//! true values and use no code of the Monte Carlo.

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;
use trueaxis::machine::{AXES, Axis};
use trueaxis_evaluation::uncertainty::{Options, band_factor, evaluate};
use trueaxis_metrology::accuracy::{Approach, Direction, Measurement, evaluate as figures_of};
use trueaxis_metrology::ballbar::{Cause, Reading, evaluate as circle};
use trueaxis_metrology::identification::{AngleReadings, Ball, BallTest, Offsets, identify};
use trueaxis_metrology::uncertainty::{Draws, Instrument, positioning};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::uncertainty::Uncertainties;

fn repeats(few: usize) -> usize {
    std::env::var("TRUEAXIS_REPEATS").ok().and_then(|text| text.parse().ok()).unwrap_or(few)
}

/// Counts of intervals that contained the truth, by name.
struct Coverage {
    names: Vec<String>,
    held: Vec<usize>,
    of: Vec<usize>,
}

impl Coverage {
    fn new() -> Coverage {
        Coverage { names: Vec::new(), held: Vec::new(), of: Vec::new() }
    }

    fn count(&mut self, name: &str, held: bool) {
        let at = self.names.iter().position(|own| own == name).unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.held.push(0);
            self.of.push(0);
            self.names.len() - 1
        });
        self.held[at] += usize::from(held);
        self.of[at] += 1;
    }

    fn share(&self, name: &str) -> f64 {
        let at = self.names.iter().position(|own| own == name).unwrap();
        self.held[at] as f64 / self.of[at] as f64
    }

    /// Checks that every share is within 2 % of 95 %.
    fn check(&self, title: &str) {
        self.check_within(title, [0.93, 0.97]);
    }

    /// Checks that every share is within two bounds, widened by 3.5 standard deviations for a small count.
    fn check_within(&self, title: &str, [least, most]: [f64; 2]) {
        for (name, (held, of)) in self.names.iter().zip(self.held.iter().zip(&self.of)) {
            let share = *held as f64 / *of as f64;
            println!("{title:<28}{name:<22}{:>6.1} % of {of}", 100.0 * share);
            let chance = if *of >= 1000 { 0.0 } else { 3.5 * (0.95 * 0.05 / *of as f64).sqrt() };
            assert!(share >= least - chance && share <= most + chance, "{title}, {name}: {share}");
        }
    }
}

const COUNT: usize = 21;

/// 21 positions over 600 mm, five runs both ways, scatter of 0.5 µm, reversal of 1.5 µm.
fn axis(draws: &mut Draws, scatter: f64) -> Vec<Approach> {
    let mut approaches = Vec::new();
    for i in 0..COUNT {
        let position = -300.0 + 30.0 * i as f64;
        let own = 10.0 * (position / 100.0).sin() + 0.02 * position;
        for run in 1..=5 {
            for (direction, reversal) in [(Direction::Up, 0.0), (Direction::Down, -1.5)] {
                let deviation = own + reversal + scatter * draws.normal();
                approaches.push(Approach { position, run, direction, deviation });
            }
        }
    }
    approaches
}

/// Readings of the axis by an instrument.
fn read(draws: &mut Draws, truth: &[Approach], instrument: Instrument) -> Measurement {
    let scale = instrument.per_length * draws.normal();
    let read = truth.iter().map(|approach| Approach {
        deviation: approach.deviation + scale * approach.position + instrument.reading * draws.normal(),
        ..*approach
    });
    Measurement::new(Axis::X, read.collect()).unwrap()
}

#[test]
fn figures_of_iso_230_2() {
    let repeats = repeats(150);
    let mut naive = Coverage::new();
    for (title, instrument, scatter, bounds) in [
        ("laser in a workshop", Instrument { per_length: 0.6e-3, reading: 0.3 }, 0.5, [0.93, 0.97]),
        ("scale well known", Instrument { per_length: 0.0, reading: 0.3 }, 0.5, [0.93, 0.97]),
        // If a reading is uncertain by more than twice the scatter, R covers up to 98 %.
        ("drift above the scatter", Instrument { per_length: 0.0, reading: 0.5 }, 0.2, [0.93, 0.98]),
        ("quiet room", Instrument { per_length: 0.3e-3, reading: 0.1 }, 0.5, [0.93, 0.97]),
        // The scatter is hardly visible any more: a note says so.
        ("scatter of a sixth", Instrument { per_length: 0.0, reading: 0.3 }, 0.05, [0.7, 0.98]),
    ] {
        let mut coverage = Coverage::new();
        for repeat in 0..repeats {
            let mut draws = Draws::new(20, repeat as u64);
            let truth = axis(&mut draws, scatter);
            let measurement = read(&mut draws, &truth, instrument);
            let wanted = positioning(
                &Measurement::new(Axis::X, truth).unwrap(),
                Instrument { per_length: 0.0, reading: 0.0 },
                0.95,
                1,
                1,
            )
            .unwrap();
            let found = positioning(&measurement, instrument, 0.95, 400, repeat as u64).unwrap();
            assert_eq!(found.figures.len(), 12);
            let measured = figures_of(&measurement).unwrap();
            assert_eq!(found.of("R").unwrap().value, measured.both.unwrap().repeatability);
            for band in &found.figures {
                let truth = wanted.of(band.figure).unwrap().value;
                if ["A", "E", "R", "M", "B", "B_mean", "R_up", "A_up"].contains(&band.figure) {
                    coverage.count(band.figure, band.interval.contains(truth));
                    naive.count(band.figure, (band.value - truth).abs() <= band.expanded);
                }
            }
        }
        coverage.check_within(title, bounds);
    }
    // The naive form: the same width centred on the measured value. Reading errors can only increase A and R.
    for figure in ["A", "R", "B"] {
        println!("{:<28}{figure:<22}{:>6.1} %", "value ± U about measured", 100.0 * naive.share(figure));
    }
    assert!(naive.share("R") < 0.9 && naive.share("A") < 0.9);
}

#[test]
fn errors_of_a_rotary_axis() {
    let mut coverage = Coverage::new();
    let set_ups = [(200.0, 0.0), (200.0, 120.0), (300.0, 60.0)];
    let balls: Vec<Ball> =
        set_ups.iter().map(|&(vertical_mm, horizontal_mm)| Ball { vertical_mm, horizontal_mm }).collect();
    for repeat in 0..repeats(300) {
        let mut draws = Draws::new(21, repeat as u64);
        // A perfect axis, since the fit is linear; few angles for few degrees of freedom.
        let angles = (0..2).map(|k| AngleReadings {
            angle_rad: f64::from(k) * 1.3,
            deviations_mm: (0..3).map(|_| std::array::from_fn(|_| 0.5e-3 * draws.normal())).collect(),
        });
        let test = BallTest { axis: Axis::C, balls: balls.clone(), angles: angles.collect() };
        let found = identify(&test, Offsets::Known).unwrap();
        let factor = band_factor(found.degrees_of_freedom as f64);
        for angle in &found.angles {
            for (name, component) in [("EXC", 0), ("EZC", 2), ("EAC", 3), ("ECC", 5)] {
                let (error, s) = (angle.errors[component], angle.standard_errors[component]);
                coverage.count(name, error.abs() <= factor * s);
                coverage.count(&format!("{name}, ± 2 s"), true);
                if error.abs() > 2.0 * s {
                    let at = coverage.names.iter().position(|own| *own == format!("{name}, ± 2 s")).unwrap();
                    coverage.held[at] -= 1;
                }
            }
        }
        assert_eq!(found.degrees_of_freedom, 6);
    }
    // With six degrees of freedom 2 s is too narrow: t_6 = 2.447.
    let two = coverage.share("EXC, ± 2 s");
    println!("rotary axis, 6 dof           EXC, naive ± 2 s {:>6.1} %", 100.0 * two);
    assert!(two < 0.94, "{two}");
    let keep: Vec<usize> = (0..coverage.names.len()).filter(|at| !coverage.names[*at].contains("2 s")).collect();
    let kept = Coverage {
        names: keep.iter().map(|at| coverage.names[*at].clone()).collect(),
        held: keep.iter().map(|at| coverage.held[*at]).collect(),
        of: keep.iter().map(|at| coverage.of[*at]).collect(),
    };
    kept.check("rotary axis, 6 dof");
}

/// Spikes that are visible, absent, or within the noise, narrow and wide.
#[test]
fn causes_of_a_circle() {
    counted_on_circles("ballbar, spikes of 3 µm", 3e-3, 0.12);
    counted_on_circles("ballbar, no spikes", 0.0, 0.12);
    counted_on_circles("ballbar, 0.3 µm", 0.3e-3, 0.12);
    counted_on_circles("ballbar, 0.3 µm, 0.04 rad", 0.3e-3, 0.04);
}

/// Spikes of `height` mm, `width` rad after the reversals of both axes.
fn counted_on_circles(name: &str, height: f64, width: f64) {
    let mut coverage = Coverage::new();
    let (squareness, scale, backlash) = (40e-6, 30e-6, 4e-3);
    let spike = |since: f64| {
        let since = since.rem_euclid(PI) / width;
        height * since * (1.0 - since).exp()
    };
    for repeat in 0..repeats(60) {
        let mut draws = Draws::new(22, repeat as u64);
        let mut readings = Vec::new();
        for counterclockwise in [true, false] {
            let d = if counterclockwise { 1.0 } else { -1.0 };
            for k in 0..180 {
                let angle_rad = (2.0 * f64::from(k) + 1.0).to_radians();
                let (sin, cos) = angle_rad.sin_cos();
                let deviation_mm = 50.0 * (scale * (2.0 * angle_rad).cos() - squareness * (2.0 * angle_rad).sin())
                    + 0.5 * d * backlash * sin.signum() * cos
                    + [0.0, FRAC_PI_2].into_iter().map(|from| spike(d * (angle_rad - from))).sum::<f64>()
                    + 0.5e-3 * draws.normal();
                readings.push(Reading { angle_rad, deviation_mm, counterclockwise });
            }
        }
        let found = circle(100.0, &readings, [Some(10.0), Some(10.0)]).unwrap();
        let factor = band_factor(found.degrees_of_freedom as f64);
        for (cause, truth) in [
            (Cause::Squareness, squareness),
            (Cause::ScaleMismatch, scale),
            (Cause::Backlash(0), backlash),
            (Cause::Backlash(1), 0.0),
            (Cause::Centre(0), 0.0),
            (Cause::ServoMismatch, 0.0),
        ] {
            let term = found.term(cause).unwrap();
            coverage.count(&format!("{cause:?}"), (term.value - truth).abs() <= factor * term.standard_error);
        }
    }
    coverage.check(name);
}

/// The sample mill is the true machine; it is measured with errors and corrected by the measurement. Every repeat estimates
/// the standard uncertainties again, with the degrees of freedom that the machine states.
#[test]
fn the_corrected_position() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-3axis");
    let (truth, known) = (Machine::read(&folder).unwrap(), Uncertainties::read(&folder).unwrap());
    let at = [-300.0, 180.0, -350.0, 0.0, 0.0, 0.0];
    let mut coverage = Coverage::new();
    for repeat in 0..repeats(150) {
        let mut draws = Draws::new(23, repeat as u64);
        let (mut measured, mut stated) = (truth.clone(), known.clone());
        let mut sent = [0.0; AXES];
        let device = known.instrument.device_per_length.unwrap() * draws.normal();
        let kelvin = known.instrument.temperature_k.unwrap() * draws.normal();
        let expansion = known.instrument.expansion_per_k.unwrap()
            * draws.normal()
            * known.instrument.temperature_difference_k.unwrap();
        let reading = known.instrument.device.unwrap().hypot(known.instrument.eve.unwrap());
        for (slot, own) in known.axes.iter().enumerate() {
            let nu = own.degrees_of_freedom.unwrap();
            let settings = &mut measured.settings.axes[slot];
            let [low, high] = settings.travel;
            let lateral = known.instrument.misalignment.unwrap() * draws.normal() / (high - low);
            let scale = device + settings.thermal.expansion_per_k * kelvin + expansion - 0.5 * lateral * lateral;
            settings.backlash += own.backlash.unwrap() * draws.normal();
            sent[slot] = own.repeatability.unwrap() * draws.normal();
            for row in &mut measured.tables[slot].as_mut().unwrap().rows {
                for component in 0..6 {
                    let mut by = own.columns[component].unwrap_or(0.0) * draws.normal();
                    if component == slot {
                        by += scale * row.position + reading * draws.normal();
                    }
                    row.forward[component] += by;
                    row.reverse[component] += by;
                }
            }
            let estimate = &mut stated.axes[slot];
            for u in estimate.columns.iter_mut().chain([&mut estimate.backlash, &mut estimate.repeatability]) {
                *u = u.map(|u| u / draws.spread(nu));
            }
        }
        let nu = known.location.degrees_of_freedom.unwrap();
        let location = &mut measured.settings.location;
        for (which, value) in [&mut location.a0z, &mut location.b0z, &mut location.c0y].into_iter().enumerate() {
            let u = known.location.squareness[which].unwrap();
            *value += u * draws.normal();
            stated.location.squareness[which] = Some(u / draws.spread(nu));
        }
        let options = Options { at: Some(at), points: 2, trials: 100, ..Options::default() };
        let found = evaluate(&measured, &stated, &options).unwrap().at.unwrap().jacobian;
        // The error according to the measured tables, by exact geometry, compared with the true machine: both in negative
        // travel.
        let reverse = [1.0; AXES];
        let (compensated, real) = (Geometry::new(&measured, 0.0).unwrap(), Geometry::new(&truth, 0.0).unwrap());
        let mut scattered = at;
        scattered.iter_mut().zip(sent).for_each(|(q, by)| *q += by);
        let expected = compensated.tip_error(&at, &reverse);
        let there = real.pose_error_of(&real.commanded(&at), &scattered, &reverse).tip_mm;
        let d: [f64; 3] = std::array::from_fn(|i| 1e3 * (there[i] - expected[i]));
        for (i, name) in ["X", "Y", "Z"].into_iter().enumerate() {
            coverage.count(name, d[i].abs() <= found.expanded_um[i]);
        }
        let distance = d.iter().map(|d| d * d).sum::<f64>().sqrt();
        coverage.count("radius", distance <= found.radius_um);
    }
    coverage.check("tip of mill-3axis");
}
