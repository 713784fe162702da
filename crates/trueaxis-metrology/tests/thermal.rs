//! Thermal growth identified from warm-ups with known truth: temperatures and responses are integrated in steps of a second,
//! without any of the code under test.

use trueaxis::Axis;
use trueaxis::temperature::Thermal;
use trueaxis_metrology::thermal::{Missing, Record, Sample, Settings, ThermalRefusal, fit, held_out, repeatability};
use trueaxis_testing::noise::Noise;
use trueaxis_testing::scatter::{Scatter, normal};

/// True lags, s: spindle sensor, ambient, and the spindle's response.
const LAGS: [f64; 3] = [900.0, 5400.0, 1500.0];
/// Z per kelvin of the first sensor, µm; X per metre and kelvin of the second; Z at 6,000 rpm, µm; Y per mm of tool at 6,000
/// rpm, µm.
const Z_PER_K: f64 = 1.8;
const X_PER_M_K: f64 = 11.0;
const Z_AT_SPEED: f64 = 9.0;
const Y_PER_MM_AT_SPEED: f64 = 0.03;

/// Speeds of the four cycles in intervals of 40 minutes, in thousands.
const DUTY: [[u32; 6]; 4] = [[0, 6, 6, 3, 0, 3], [0, 6, 0, 6, 6, 6], [3, 0, 6, 6, 0, 3], [6, 3, 0, 0, 6, 3]];

fn record(noise_um: f64) -> Record {
    warm_up(&DUTY, 6000.0, 7, noise_um)
}

/// A warm-up with this duty, of a spindle whose sensor is 14 K warm at `hot_rpm`.
fn warm_up(duty: &[[u32; 6]], hot_rpm: f64, seed: u64, noise_um: f64) -> Record {
    recorded_every(120, duty, hot_rpm, seed, noise_um)
}

/// The same warm-up, with one row for every measuring point each `every_s` seconds.
fn recorded_every(every_s: u32, duty: &[[u32; 6]], hot_rpm: f64, seed: u64, noise_um: f64) -> Record {
    let mut noise = Noise::new(seed);
    let mut samples = Vec::new();
    let (mut t, mut nose, mut lagged, mut response) = (0.0_f64, 20.0, [20.0, 20.0], 0.0);
    // In equilibrium until the first row.
    let since = |t: f64| (t - 120.0).max(0.0);
    let air = |t: f64| 20.0 + 3.0 * (since(t) / 13_000.0).sin() + 1.5 * (since(t) / 4_100.0).sin();
    for (cycle, duty) in (1..).zip(duty) {
        for second in 0..14_400_u32 {
            // Speeds change midway between two rows: the fit treats what happens between rows as linear.
            let rpm = 1e3 * f64::from(duty[((second + every_s / 2) / 2400 % 6) as usize]);
            // A heater besides the speed, so that the two differ.
            let heat = 14.0 * (rpm / hot_rpm).powi(2) + 4.0 * (since(t) / 2_900.0).sin();
            nose += (air(t) + heat - nose) / 700.0;
            lagged[0] += (nose - lagged[0]) / LAGS[0];
            lagged[1] += (air(t) - lagged[1]) / LAGS[1];
            response += (rpm / 6000.0 - response) / LAGS[2];
            t += 1.0;
            if second % every_s != every_s - 1 {
                continue;
            }
            for (x, tool) in [(0.0, 40.0), (400.0, 40.0), (0.0, 240.0)] {
                let truth = [
                    1e-3 * X_PER_M_K * (lagged[1] - 20.0) * x,
                    Y_PER_MM_AT_SPEED * response * tool,
                    Z_PER_K * (lagged[0] - 20.0) + Z_AT_SPEED * response,
                ];
                samples.push(Sample {
                    t_s: t,
                    temperatures_c: vec![nose, air(t), 20.0 + 2.0 * (t / 1_777.0).cos()],
                    spindle_rpm: rpm,
                    cycle,
                    position_mm: [x, 0.0, 0.0],
                    tool_mm: tool,
                    error_mm: truth.iter().map(|um| 1e-3 * (um + noise_um * 3.0_f64.sqrt() * noise.signed())).collect(),
                });
            }
        }
    }
    let sensors = ["nose", "air", "clock"].map(String::from).to_vec();
    Record { sensors, axes: vec![Axis::X, Axis::Y, Axis::Z], samples }
}

fn settings() -> Settings {
    Settings { reference_c: 20.0, datum_mm: [0.0; 3], held_out: vec![], rate_k_per_min: None }
}

#[test]
fn lags_and_curves_of_a_known_machine_are_found_and_the_clock_is_left_out() {
    let record = record(0.3);
    let found = fit(&record, &settings(), &mut |_| ()).unwrap();
    let names: Vec<&str> = found.model.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
    assert_eq!((names, found.held_out.as_slice()), (vec!["nose", "air"], &[4][..]));
    assert!(found.left_out.iter().any(|out| out.name == "clock" && !out.still), "{:?}", found.left_out);
    let spindle = found.model.spindle.as_ref().unwrap();
    let lags = [found.model.sensors[0].lag_s, found.model.sensors[1].lag_s, spindle.lag_s];
    for (found, truth) in lags.into_iter().zip(LAGS) {
        assert!((found / truth - 1.0).abs() < 0.08, "{found} s for {truth} s");
    }
    assert_eq!(spindle.knots_rpm, [0.0, 3000.0, 6000.0]);

    let per_k = |axis: usize, sensor: usize, part: usize| {
        let (knots, curve) = (&found.model.sensors[sensor].knots_c, &found.axes[axis].sensors[sensor]);
        let [first, last] = [curve.first().unwrap(), curve.last().unwrap()];
        let range = knots.last().unwrap() - knots[0];
        let error = first.standard_error[part].hypot(last.standard_error[part]) / range;
        ((last.value[part] - first.value[part]) / range, error)
    };
    let near = |(found, error): (f64, f64), truth: f64, tolerance: f64, what: &str| {
        assert!((found - truth).abs() < tolerance, "{what}: {found} ± {error} for {truth}");
        assert!(error > 0.0 && error < 3.0 * tolerance, "{what}: standard error {error}");
    };
    near(per_k(2, 0, 0), 1e-3 * Z_PER_K, 4e-5, "Z with the nose");
    near(per_k(0, 1, 1), 1e-6 * X_PER_M_K, 3e-7, "X with the air");
    let last = *found.axes[2].spindle.last().unwrap();
    near((last.value[0], last.standard_error[0]), 1e-3 * Z_AT_SPEED, 4e-4, "Z at speed");
    let last = *found.axes[1].spindle.last().unwrap();
    near((last.value[1], last.standard_error[1]), 1e-3 * Y_PER_MM_AT_SPEED, 1e-6, "Y at speed");

    let bytes = found.model.encode(9).unwrap();
    assert!(Thermal::parse(&bytes).unwrap().expect_machine(9).is_ok());
    let (figures, series) = held_out(&record, &found, &bytes);
    assert_eq!((figures.len(), series.len()), (12, 36));
    for own in figures.iter().filter(|own| own.held_out) {
        // Two readings of 0.3 µm, each at its largest in 360.
        assert!(own.left_mm < 2.2e-3 && own.left_rms_mm < 0.7e-3 && own.drift_mm > 3e-3, "{own:?}");
    }
}

#[test]
fn without_a_second_position_there_is_no_slope_and_without_a_second_tool_no_tilt() {
    let mut record = record(0.1);
    record.samples.retain(|sample| sample.position_mm[0] == 0.0 && sample.tool_mm == 40.0);
    let found = fit(&record, &settings(), &mut |_| ()).unwrap();
    let slopes = found.axes.iter().flat_map(|axis| axis.sensors.iter().flatten()).map(|at| at.value[1]);
    let tilts = found.axes.iter().flat_map(|axis| &axis.spindle).map(|at| at.value[1]);
    assert!(slopes.chain(tilts).all(|value| value == 0.0));
    let growth = found.axes[1].spindle.last().unwrap().value[0];
    assert!((growth - 1e-3 * 40.0 * Y_PER_MM_AT_SPEED).abs() < 1e-4, "the tool's tilt is growth then: {growth}");
}

/// Speeds of the spindle, one row per warm-up.
type Speeds = [[u32; 6]; 4];

/// Warm-ups in which a speed, or every speed, occurs in only one fitted cycle, so that no other cycle predicts it; these
/// speeds with their cycles.
const LONE: [(Speeds, &[(f64, u32)]); 7] = [
    ([[0, 6, 6, 3, 0, 3], [0, 6, 12, 12, 6, 0], [3, 0, 6, 6, 0, 3], [6, 12, 0, 0, 6, 3]], &[(12e3, 2)]),
    ([[0, 12, 12, 0, 12, 3], [0, 6, 0, 6, 6, 3], [3, 0, 6, 6, 0, 3], [6, 3, 0, 12, 6, 3]], &[(12e3, 1)]),
    ([[0, 6, 6, 3, 0, 3], [0, 6, 0, 3, 6, 6], [3, 0, 9, 9, 0, 9], [6, 9, 0, 0, 6, 3]], &[(9e3, 3)]),
    (
        [[0, 3, 3, 0, 0, 0], [6, 6, 6, 0, 0, 0], [12, 12, 12, 0, 0, 0], [6, 6, 0, 12, 12, 0]],
        &[(3e3, 1), (6e3, 2), (12e3, 3)],
    ),
    (
        [[0, 3, 0, 3, 3, 0], [0, 6, 0, 6, 6, 0], [0, 12, 12, 0, 12, 0], [6, 3, 0, 0, 12, 12]],
        &[(3e3, 1), (6e3, 2), (12e3, 3)],
    ),
    ([[0, 12, 0, 12, 12, 0], [0, 6, 6, 0, 0, 6], [6, 0, 6, 6, 0, 6], [12, 6, 0, 0, 6, 12]], &[(12e3, 1)]),
    ([[0, 4, 0, 0, 4, 4], [0, 8, 12, 0, 8, 12], [4, 0, 4, 4, 0, 4], [12, 4, 0, 8, 4, 0]], &[(8e3, 2), (12e3, 2)]),
];

#[test]
fn a_speed_of_one_fitted_cycle_only_is_found_with_an_honest_error() {
    for (duty, lone) in LONE {
        let record = warm_up(&duty, 12_000.0, 7, 0.3);
        let found = fit(&record, &settings(), &mut |_| ()).unwrap();
        assert_eq!(found.unconfirmed, lone, "{duty:?}");
        // The noise is 0.3 µm; with the true lags the residual is 0.30 µm.
        assert!(found.axes.iter().all(|axis| axis.rms_mm < 0.31e-3), "{duty:?}: {:?}", found.axes);
        let names: Vec<&str> = found.model.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
        assert_eq!(names, ["nose", "air"], "{duty:?}");
        let near = |value: f64, error: f64, truth: f64| {
            assert!((value - truth).abs() < 3.5 * error, "{duty:?}: {value} ± {error} for {truth}");
            assert!(error < 0.03 * truth, "{duty:?}: {value} ± {error} for {truth}");
        };
        let speeds = &found.model.spindle.as_ref().unwrap().knots_rpm;
        for (knot, rpm) in speeds.iter().enumerate().skip(1) {
            let [y, z] = [found.axes[1].spindle[knot], found.axes[2].spindle[knot]];
            near(z.value[0], z.standard_error[0], 1e-3 * Z_AT_SPEED * rpm / 6000.0);
            near(y.value[1], y.standard_error[1], 1e-3 * Y_PER_MM_AT_SPEED * rpm / 6000.0);
        }
        for (axis, sensor, part, truth) in [(2, 0, 0, 1e-3 * Z_PER_K), (0, 1, 1, 1e-6 * X_PER_M_K)] {
            let (knots, curve) = (&found.model.sensors[sensor].knots_c, &found.axes[axis].sensors[sensor]);
            let ([first, last], range) = ([curve[0], curve[curve.len() - 1]], knots[knots.len() - 1] - knots[0]);
            // Both ends are one unknown times their distance from the reference.
            let error = (first.standard_error[part] + last.standard_error[part]) / range;
            near((last.value[part] - first.value[part]) / range, error, truth);
        }
    }
    let found = fit(&record(0.3), &settings(), &mut |_| ()).unwrap();
    assert!(found.unconfirmed.is_empty(), "every speed was run in several cycles");
}

#[test]
fn a_speed_that_only_the_held_out_cycle_has_is_no_knot() {
    let mut record = record(0.1);
    for sample in record.samples.iter_mut().filter(|sample| sample.cycle == 4 && sample.spindle_rpm == 3000.0) {
        sample.spindle_rpm = 4500.0;
    }
    let found = fit(&record, &settings(), &mut |_| ()).unwrap();
    assert_eq!(found.model.spindle.unwrap().knots_rpm, [0.0, 3000.0, 6000.0]);
}

/// Reason for refusing the record after `change`.
fn refused(change: impl Fn(&mut Record)) -> ThermalRefusal {
    let mut record = record(0.1);
    record.samples.retain(|sample| sample.tool_mm == 40.0 && sample.position_mm[0] == 0.0);
    change(&mut record);
    fit(&record, &settings(), &mut |_| ()).unwrap_err()
}

#[test]
fn sensors_that_fail_half_way_are_refused_with_their_row_and_figure() {
    let jump =
        refused(|record| record.samples.iter_mut().skip(200).for_each(|sample| sample.temperatures_c[0] += 30.0));
    assert!(
        matches!(&jump, ThermalRefusal::Jump { sensor, index: 200, found_k, .. } if sensor == "nose" && (found_k - 30.0).abs() < 3.0)
    );
    let stuck = refused(|record| {
        let last = record.samples[250].temperatures_c[1];
        record.samples.iter_mut().skip(250).for_each(|sample| sample.temperatures_c[1] = last);
    });
    assert!(matches!(&stuck, ThermalRefusal::Stuck { sensor, index: 250, .. } if sensor == "air"), "{stuck}");
    // The sensor sticks in every cycle from the second on, with a rest between them: no stretch is longer than all others.
    let often = refused(|record| {
        for cycle in 2..=4 {
            let rows = record.samples.iter_mut().filter(|sample| sample.cycle == cycle);
            let mut last = None;
            for sample in rows {
                sample.t_s += 20_000.0 * f64::from(cycle);
                sample.temperatures_c[0] = *last.get_or_insert(sample.temperatures_c[0]);
            }
        }
    });
    let cycle = |index: &usize| *index >= 120 && index.is_multiple_of(120);
    assert!(
        matches!(&often, ThermalRefusal::Stuck { sensor, index, .. } if sensor == "nose" && cycle(index)),
        "{often}"
    );
    // Over two cycles and the rest between them.
    let over = refused(|record| {
        let last = record.samples[250].temperatures_c[0];
        record.samples.iter_mut().filter(|sample| sample.cycle == 4).for_each(|sample| sample.t_s += 20_000.0);
        record.samples.iter_mut().skip(250).for_each(|sample| sample.temperatures_c[0] = last);
    });
    assert!(matches!(&over, ThermalRefusal::Stuck { sensor, index: 250, .. } if sensor == "nose"), "{over}");
    let twice = refused(|record| record.samples.insert(41, record.samples[40].clone()));
    assert_eq!(twice, ThermalRefusal::Twice { index: 41, first: 40 });
    let missing = refused(|record| record.samples[33].temperatures_c[1] = f64::NAN);
    assert_eq!(missing, ThermalRefusal::Row { index: 33 });
}

#[test]
fn rows_missing_for_less_than_a_lag_are_reported_and_for_longer_refused() {
    // One measuring point, every 120 s; the lags are 900, 5400 and 1500 s.
    let without = |minutes: f64| {
        let mut record = record(0.3);
        record.samples.retain(|sample| sample.tool_mm == 40.0 && sample.position_mm[0] == 0.0);
        let from = record.samples[150].t_s;
        record.samples.retain(|sample| !(from..from + 60.0 * minutes).contains(&sample.t_s));
        fit(&record, &settings(), &mut |_| ())
    };
    assert!(without(0.0).unwrap().missing.is_empty());
    let found = without(10.0).unwrap();
    let missing = Missing { cycle: 2, index: 150, rows: 5, found_s: 720.0, interval_s: 120.0, unknown_s: 720.0 };
    assert_eq!(found.missing, [missing]);
    let refused = without(16.0).unwrap_err();
    assert!(
        matches!(&refused, ThermalRefusal::Missing { missing, of, lag_s }
            if missing.unknown_s == 1080.0 && missing.rows == 8 && of == "nose" && (*lag_s / LAGS[0] - 1.0).abs() < 0.1),
        "{refused}"
    );
}

#[test]
fn uninformative_records_are_refused() {
    let short = refused(|record| record.samples.retain(|sample| sample.cycle < 3));
    assert_eq!(short, ThermalRefusal::Cycles { found: 2 });
    let twice = refused(|record| {
        record.samples.iter_mut().for_each(|s| s.temperatures_c[2] = 2.0 * s.temperatures_c[0] - 20.0)
    });
    assert!(
        matches!(&twice, ThermalRefusal::Collinear { sensors: [one, other], .. } if one == "nose" && other == "clock")
    );
    let cold = refused(|record| {
        for sample in &mut record.samples {
            (sample.temperatures_c, sample.spindle_rpm) = (vec![20.0, 20.1, 20.2], 0.0);
        }
    });
    assert_eq!(cold, ThermalRefusal::NoExcitation { found_k: 0.0 });
    let nothing = refused(|record| {
        let mut noise = Noise::new(3);
        record.samples.iter_mut().for_each(|sample| sample.error_mm.fill(0.0));
        record.samples.iter_mut().for_each(|sample| sample.error_mm[0] = 1e-4 * 3.0_f64.sqrt() * noise.signed());
    });
    assert_eq!(nothing, ThermalRefusal::NothingFound);
    let gap = refused(|record| record.samples.iter_mut().skip(40).for_each(|sample| sample.t_s += 7_000.0));
    assert!(matches!(gap, ThermalRefusal::Gap { index: 40, .. }));
    let mixed = refused(|record| record.samples[300].cycle = 1);
    assert!(matches!(mixed, ThermalRefusal::Mixed { index: 300, cycle: 1 }));
}

/// Over repeats with noise the values of the curves scatter with their covariance, across curves and axes. The lags are those that
/// predict best, not those of least squares: what depends on them scatters by up to 1.4 standard errors.
#[test]
fn curves_scatter_with_their_covariance() {
    let mut clean = recorded_every(300, &DUTY, 6000.0, 7, 0.0);
    clean.sensors.pop();
    clean.samples.iter_mut().for_each(|sample| sample.temperatures_c.truncate(2));
    // Axis, curve, knot from the end, part.
    let places = [(0, 1, 0, 1), (1, 2, 1, 1), (1, 2, 0, 1), (2, 0, 0, 0), (2, 2, 1, 0), (2, 2, 0, 0)];
    let names = ["X air", "Y spindle 1", "Y spindle 2", "Z nose", "Z spindle 1", "Z spindle 2"].map(String::from);
    let (mut noise, mut scatter, mut used) = (Noise::new(9), Scatter::default(), 0);
    for _ in 0..150 {
        let mut own = clean.clone();
        for mm in own.samples.iter_mut().flat_map(|sample| &mut sample.error_mm) {
            *mm += 1e-3 * normal(&mut noise);
        }
        let found = fit(&own, &settings(), &mut |_| ()).unwrap();
        let (mut all, mut first) = (Vec::new(), Vec::new());
        for axis in &found.axes {
            for curve in axis.sensors.iter().chain([&axis.spindle]) {
                first.push((all.len(), curve.len()));
                all.extend(curve.iter().flat_map(|at| at.value.into_iter().zip(at.standard_error)));
            }
        }
        assert_eq!(all.len(), found.covariance.len());
        for (i, (_, error)) in all.iter().enumerate() {
            assert!((found.covariance[i][i].max(0.0).sqrt() - error).abs() <= 1e-6 * error, "{i}");
        }
        // Bends differ from repeat to repeat, and with them what the curves depend on.
        let straight = found.axes[2].sensors.iter().all(|curve| curve.len() == 2);
        if found.sensors != [0, 1] || found.axes[2].spindle.len() != 3 || !straight {
            continue;
        }
        used += 1;
        let at = places.map(|(axis, curve, back, part)| {
            let (from, knots) = first[3 * axis + curve];
            from + 2 * (knots - 1 - back) + part
        });
        let covariance: Vec<Vec<f64>> =
            at.iter().map(|i| at.iter().map(|j| found.covariance[*i][*j]).collect()).collect();
        scatter.add(&at.map(|i| all[i].0), &covariance);
    }
    assert!(used > 100, "{used}");
    let largest = scatter.check(&names, 0.3);
    assert!(largest > 0.5, "nothing to compare: {largest}");
}

/// Bed of a printer: heats by 8 K a minute to 48 K above the room, and cools after two hours.
fn bed_k(in_cycle_s: f64) -> f64 {
    let heated = (8.0 / 60.0 * (in_cycle_s - 60.0)).clamp(0.0, 48.0);
    if in_cycle_s < 7200.0 { heated } else { heated * (-(in_cycle_s - 7200.0) / 1_500.0).exp() }
}

/// Lag of the bed's growth, s, and the growth per kelvin, µm.
const BED: [f64; 2] = [300.0, 1.2];

/// One measuring point with a heated bed instead of the clock, and a sensor without heat.
fn with_bed(every_s: u32) -> Record {
    let mut record = recorded_every(every_s, &DUTY, 6000.0, 7, 0.3);
    record.samples.retain(|sample| sample.tool_mm == 40.0 && sample.position_mm[0] == 0.0);
    record.sensors = ["nose", "air", "bed", "cold"].map(String::from).to_vec();
    let (mut cycle, mut begun, mut t, mut lagged) = (0, 0.0, 0.0, 0.0);
    for (row, sample) in record.samples.iter_mut().enumerate() {
        if sample.cycle != cycle {
            (cycle, begun, t) = (sample.cycle, sample.t_s, sample.t_s);
        }
        while t < sample.t_s {
            lagged += (bed_k(t - begun) - lagged) / BED[0];
            t += 1.0;
        }
        sample.temperatures_c[2] = 20.0 + bed_k(sample.t_s - begun) + 0.05 * (0.7 * row as f64).cos();
        sample.temperatures_c.push(20.0 + 0.1 * (row as f64).sin());
        sample.error_mm[2] += 1e-3 * BED[1] * lagged;
    }
    record
}

#[test]
fn a_bed_that_moves_16_k_between_rows_is_a_sensor_and_one_without_heat_is_not() {
    let record = with_bed(120);
    let found = fit(&record, &settings(), &mut |_| ()).unwrap();
    let bed = found.model.sensors.iter().find(|sensor| sensor.name == "bed").unwrap();
    assert!((bed.lag_s / BED[0] - 1.0).abs() < 0.1, "{}", bed.lag_s);
    // 16 K in two minutes, 3 K of them at once.
    assert!((13.0..=14.0).contains(&bed.jump_k[1]), "the task must accept the bed as recorded: {:?}", bed.jump_k);
    assert!(found.left_out.iter().any(|out| out.name == "cold" && out.still), "{:?}", found.left_out);
    let (figures, _) = held_out(&record, &found, &found.model.encode(0).unwrap());
    let z = figures.iter().find(|own| own.held_out && own.axis == Axis::Z).unwrap();
    assert!(z.left_mm < 0.05 * z.drift_mm, "{z:?}");

    // A bed that cools fast where each cycle ends, and heats at once after the rest.
    let mut cools = record.clone();
    for cycle in record.cycles() {
        let own = |sample: &&mut Sample| sample.cycle == cycle;
        let end_s = cools.samples.iter_mut().rfind(own).unwrap().t_s;
        for (row, sample) in cools.samples.iter_mut().filter(own).enumerate() {
            sample.temperatures_c[2] += if row == 0 { 0.0 } else { 8.0 };
            sample.temperatures_c[2] -= 0.1 * (sample.t_s - end_s + 240.0).max(0.0);
            sample.t_s += 20_000.0 * f64::from(sample.cycle);
        }
    }
    fit(&cools, &settings(), &mut |_| ()).unwrap();

    // A whole heating between two rows.
    let apart = with_bed(900);
    let names = fit(&apart, &settings(), &mut |_| ()).unwrap().model.sensors;
    assert!(names.iter().any(|sensor| sensor.name == "bed"), "{names:?}");

    let stated = Settings { rate_k_per_min: Some(3.0), ..settings() };
    let refused = fit(&record, &stated, &mut |_| ()).unwrap_err();
    assert!(matches!(&refused, ThermalRefusal::Jump { sensor, most_k: 11.0, .. } if sensor == "bed"), "{refused}");
}

#[test]
fn a_bed_that_falls_off_or_reads_wrong_for_a_row_is_refused() {
    let jump = |change: &dyn Fn(usize, &mut f64)| {
        let mut record = with_bed(120);
        record.samples.iter_mut().enumerate().for_each(|(row, sample)| change(row, &mut sample.temperatures_c[2]));
        fit(&record, &settings(), &mut |_| ()).unwrap_err()
    };
    let at = |refused: &ThermalRefusal, row: usize| matches!(refused, ThermalRefusal::Jump { sensor, index, .. } if sensor == "bed" && *index == row);
    let off = jump(&|row, reading| *reading -= if row >= 160 { 40.0 } else { 0.0 });
    assert!(at(&off, 160), "{off}");
    // Rows of the same moment have no rate.
    let mut both = with_bed(120);
    let second = Sample { tool_mm: 240.0, ..both.samples[160].clone() };
    both.samples.insert(161, second);
    both.samples.iter_mut().skip(161).for_each(|sample| sample.temperatures_c[2] -= 40.0);
    let both = fit(&both, &settings(), &mut |_| ()).unwrap_err();
    assert!(at(&both, 161), "{both}");
    // In two cycles alike, as a sensor does that reads 85 °C after a loss of power.
    let wrong = jump(&|row, reading| *reading = if row == 40 || row == 280 { 85.0 } else { *reading });
    assert!(at(&wrong, 40), "{wrong}");
}

#[test]
fn each_cycle_in_turn_is_predicted_by_the_others() {
    let mut record = record(0.1);
    let each = Settings { held_out: vec![1, 2, 3, 4], ..settings() };
    let found = fit(&record, &each, &mut |_| ()).unwrap();
    assert_eq!((found.held_out.len(), found.turns.len()), (4, 4));
    let figures = held_out(&record, &found, &found.model.encode(0).unwrap()).0;
    for own in figures.iter().filter(|own| own.axis == Axis::Z) {
        assert!(own.held_out && own.left_mm < 0.05 * own.drift_mm, "{own:?}");
    }
    // One cycle drifts half as much again: its curves come from the others, those of the model from all cycles.
    record.samples.iter_mut().filter(|s| s.cycle == 2).for_each(|s| s.error_mm[2] *= 1.5);
    let mut found = fit(&record, &each, &mut |_| ()).unwrap();
    let mut share = |in_turn: bool| {
        if !in_turn {
            found.turns.clear();
        }
        let figures = held_out(&record, &found, &found.model.encode(0).unwrap()).0;
        let own = figures.into_iter().find(|own| own.axis == Axis::Z && own.cycle == 2).unwrap();
        own.left_rms_mm / own.drift_rms_mm
    };
    let [by_others, by_all] = [true, false].map(&mut share);
    assert!(by_others > 0.2 && by_others > 1.2 * by_all, "{by_others} by the others, {by_all} by all");
}

/// Four cycles of one sensor, which begin `apart_k` apart; the drift follows it, with an additional part of ±2 µm that it does
/// not show.
fn repeated(apart_k: f64) -> Option<f64> {
    let mut samples = Vec::new();
    for row in 0..240_u32 {
        let (cycle, at) = (row / 60, f64::from(row % 60));
        let warm = 10.0 * (1.0 - (-at / 15.0).exp()) + apart_k * f64::from(cycle);
        let unseen = if cycle % 2 == 0 { 2.0 } else { -2.0 } * (std::f64::consts::TAU * at / 30.0).sin();
        samples.push(Sample {
            t_s: 120.0 * at + 30_000.0 * f64::from(cycle),
            temperatures_c: vec![20.0 + warm],
            spindle_rpm: 0.0,
            cycle,
            position_mm: [0.0; 3],
            tool_mm: 0.0,
            error_mm: vec![1e-3 * (5.0 * warm + unseen)],
        });
    }
    let record = Record { sensors: vec!["T1".into()], axes: vec![Axis::Z], samples };
    let found = fit(&record, &settings(), &mut |_| ()).unwrap();
    let bytes = found.model.encode(0).unwrap();
    let (_, series) = held_out(&record, &found, &bytes);
    repeatability(&record, &found, &bytes, &series)[0].repeat_mm
}

#[test]
fn repeatability_is_how_much_cycles_with_the_same_temperatures_differ() {
    // Of six pairs four differ by twice the unseen part: the mean square is 4/6 × (2 × 2)²/2 × 1/2 µm².
    let found = repeated(0.0).unwrap();
    assert!((1e3 * found / (8.0_f64 / 3.0).sqrt() - 1.0).abs() < 0.05, "{found}");
    assert_eq!(repeated(15.0), None);
}

/// A printer's warm-up as recorded, if available; it is not part of this repository.
#[test]
fn each_cycle_of_a_printer_is_predicted_by_the_others() {
    let folder = std::env::var_os("TRUEAXIS_REFERENCE_DATA").map(std::path::PathBuf::from);
    let Some(text) = folder.and_then(|folder| std::fs::read_to_string(folder.join("real/warm-up.csv")).ok()) else {
        println!("skipped: TRUEAXIS_REFERENCE_DATA names no folder with real/warm-up.csv");
        return;
    };
    let sample = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        Sample {
            t_s: cells[0],
            temperatures_c: cells[2..5].to_vec(),
            spindle_rpm: 0.0,
            cycle: cells[1] as u32,
            position_mm: [0.0; 3],
            tool_mm: 0.0,
            error_mm: vec![1e-3 * cells[5]],
        }
    };
    let sensors = ["frame", "chamber", "bed"].map(String::from).to_vec();
    let record = Record { sensors, axes: vec![Axis::Z], samples: text.lines().skip(1).map(sample).collect() };
    let found = fit(&record, &Settings { held_out: vec![1, 2, 3, 4], ..settings() }, &mut |_| ()).unwrap();
    let bytes = found.model.encode(0).unwrap();
    let (figures, series) = held_out(&record, &found, &bytes);
    for own in &figures {
        assert!(own.held_out && own.left_mm < 0.15 * own.drift_mm, "{own:?}");
    }
    let own = repeatability(&record, &found, &bytes, &series)[0];
    let repeat_mm = own.repeat_mm.unwrap();
    assert!(repeat_mm > 2e-3 && repeat_mm < own.left_mm && own.left_mm < 6e-3, "{own:?}");
}
