//! Growth of machine and part while the part is cut, by own formulas.

use std::fmt::Write;
use std::path::Path;
use trueaxis_evaluation::predict::{
    Growth, GrowthModel, Options, Part, PredictDocument, Predicted, Start, TEMPERATURES, TemperatureRecord, predict,
};
use trueaxis_evaluation::rows::Rows;
use trueaxis_sim::program::Program;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;

/// Two holes 100 mm apart along X and Y, 60 mm and 80 mm; all motion at 1 mm/s: each stroke takes 7 s, the way 100 s.
const PROGRAM: &str = "G21 G90 G17 G94 F60\nG1 X0 Y0 Z2\nG1 Z-5\nG1 Z2\nG1 X60 Y80\nG1 Z-5\nG1 Z2\nM2\n";
/// Time between the middles of the two strokes, and from the start to the first, s.
const APART_S: f64 = 3.5 + 7.0 + 100.0 + 3.5;
const FIRST_S: f64 = 2.0 + 3.5;
const PART: &str = "name = \"two\"\nat_mm = [0, 0, -50]\n\
                    [[feature]]\nname = \"one\"\nkind = \"hole\"\nlines = [3, 3]\n\
                    [[feature]]\nname = \"two\"\nkind = \"hole\"\nlines = [6, 6]\n\
                    [[tolerance]]\nfeature = \"two\"\nkind = \"distance\"\nfrom = \"one\"\nlimits_um = [-5, 5]\n\
                    [[tolerance]]\nfeature = \"one\"\nkind = \"position\"\nwidth_um = 5\n";

fn machine(thermal: &str) -> (Machine, Uncertainties) {
    let toml = format!(
        "name = \"small\"\nchain = \"w X' Y' b Z t\"\n[axis.X]\ntable = \"x.csv\"\ntravel_mm = [-10, 200]\n\
         [axis.Y]\ntravel_mm = [-10, 200]\n[axis.Z]\ntravel_mm = [-100, 0]\n{thermal}"
    );
    let files = Memory::new([("machine.toml", toml.as_str()), ("x.csv", "X_mm,EXX_um\n-10,0\n200,0\n")]);
    let file = Path::new("machine.toml");
    (Machine::read_from(&files, file, &mut |_| {}).unwrap(), Uncertainties::read_from(&files, file).unwrap())
}

fn part(temperature: &str) -> Part {
    Part::read(&format!("{PART}{temperature}"), Path::new("part.toml")).unwrap()
}

fn predicted(machine: &(Machine, Uncertainties), part: &Part) -> anyhow::Result<PredictDocument> {
    let program = Program::parse("two", PROGRAM, "two.ngc").unwrap();
    predict(&machine.0, &machine.1, &program, part, Options { trials: 4000, seed: 3 })
}

fn read(text: &str) -> anyhow::Result<TemperatureRecord> {
    TemperatureRecord::read(Rows::new(text.as_bytes(), Path::new("shift.csv"), &TEMPERATURES, |_| {})?)
}

/// A row every 20 s from `from_s` on, 20 °C and this rise in K per second.
fn ramp(from_s: f64, rows: u32, rise: f64) -> String {
    let mut text = String::from("t_s,T1_c\n");
    for row in 0..rows {
        let t = 20.0 * f64::from(row);
        writeln!(text, "{},{}", from_s + t, 20.0 + rise * t).unwrap();
    }
    text
}

fn share(of: &Predicted, term: &str) -> f64 {
    let budget = &of.known.as_ref().unwrap().budget;
    budget.iter().find(|one| one.term == term).map_or(0.0, |one| one.standard_um)
}

#[test]
fn a_constant_rise_lengthens_distances_and_a_warm_part_shrinks() {
    let machine = machine(
        "[axis.X.thermal]\nexpansion_um_per_m_k = 11.5\n[axis.Y.thermal]\nexpansion_um_per_m_k = 11.5\n\
         [uncertainty]\nsensor_k = 0.2\nexpansion_um_per_m_k = 1.0\n",
    );
    let cold = predicted(&machine, &part("")).unwrap();
    assert!(cold.features[0].uncorrected_um.abs() < 1e-6 && cold.temperature.is_none());
    let grown = 100.0 * 11.5e-3 * 3.5;
    let warm = predicted(&machine, &part("[temperature]\nmachine_c = 23.5\n")).unwrap();
    let distance = &warm.features[0];
    assert!((distance.uncorrected_um - grown).abs() < 1e-3, "{} for {grown}", distance.uncorrected_um);
    assert!(distance.corrected_um.abs() < 1e-5, "{}", distance.corrected_um);
    // 0.2 K at 11.5 µm/(m K), and 1 µm/(m K) over 3.5 K, both over 100 mm.
    let [sensor, expansion] = ["temperature sensor", "expansion while cutting"].map(|term| share(distance, term));
    assert!((sensor - 0.23).abs() < 0.01 && (expansion - 0.35).abs() < 0.015, "{sensor}, {expansion}");
    let expanded = distance.known.as_ref().unwrap().expanded_um;
    assert!((expanded - 1.96 * f64::hypot(0.23, 0.35)).abs() < 0.03, "{expanded}");

    let text = "[temperature]\nmachine_c = 23.5\npart_c = 26\npart_expansion_um_per_m_k = 23\npart_u_k = 0.5\n";
    let both = predicted(&machine, &part(text)).unwrap();
    let distance = &both.features[0];
    let shrunk = 1e5 / (1.0 + 23e-6 * 6.0) - 1e5;
    assert!((distance.uncorrected_um - grown - shrunk).abs() < 0.002, "{}", distance.uncorrected_um);
    assert!((distance.corrected_um - shrunk).abs() < 1e-3, "{}", distance.corrected_um);
    assert!((share(distance, "part temperature") - 100.0 * 23e-3 * 0.5).abs() < 0.03);
    // The same by the function for any temperature.
    let model = GrowthModel::of(&machine.0, None).unwrap();
    let again = predicted(&machine, &part("").at_temperature(model, 23.5).unwrap()).unwrap();
    assert_eq!(again.features[0].uncorrected_um, warm.features[0].uncorrected_um);
}

#[test]
fn a_ramp_shifts_the_later_hole_by_what_the_record_says() {
    let machine = machine("[axis.X.thermal]\noffset_um_per_k = 5\n");
    let model = || GrowthModel::of(&machine.0, None).unwrap();
    let rise = 1.0 / 60.0;
    let growth = |start| Growth::recorded(model(), &read(&ramp(28_800.0, 100, rise)).unwrap(), start).unwrap();
    for start in [Start::After(600.0), Start::At(29_400.0)] {
        let of = predicted(&machine, &Part { growth: Some(growth(start)), ..part("") }).unwrap();
        let between = 5.0 * rise * APART_S;
        let was = (60.0 + 1e-3 * between).hypot(80.0);
        let [distance, position] = &of.features[..] else { panic!() };
        let wanted = 1e3 * (was - 100.0);
        assert!((distance.uncorrected_um - wanted).abs() < 0.02, "{} for {wanted}", distance.uncorrected_um);
        assert!(distance.corrected_um.abs() < 1e-5);
        let wanted = 2.0 * 5.0 * rise * (600.0 + FIRST_S);
        assert!((position.uncorrected_um - wanted).abs() < 0.05, "{} for {wanted}", position.uncorrected_um);
        assert!(position.corrected_um.abs() < 1e-5);
        let temperature = of.temperature.unwrap();
        assert_eq!(temperature.start_s, Some(600.0));
        let [first, last] = temperature.sensors[0].celsius;
        assert!((first - 20.0 - rise * 602.0).abs() < 0.01, "{first}");
        assert!((last - first - rise * (APART_S + 7.0)).abs() < 0.01, "{last}");
    }
}

/// A limit of 8 µm leaves the rest of a growth of 10 µm.
#[test]
fn the_limit_of_an_axis_limits_the_thermal_compensation() {
    let machine = machine("[axis.X.thermal]\noffset_um_per_k = 5\n[axis.X.limits]\nmagnitude_um = 8\n");
    let of = predicted(&machine, &part("[temperature]\nmachine_c = 22\n")).unwrap();
    let position = &of.features[1];
    assert!((position.uncorrected_um - 20.0).abs() < 1e-3 && (position.corrected_um - 4.0).abs() < 1e-3);
    assert!(of.warnings.iter().any(|note| note.contains("magnitude_um is 8")), "{:?}", of.warnings);
}

/// Drills a hole in a second set-up.
const SECOND: &str = "G21 G90 G17 G94 F60\nG1 X0 Y0 Z2\nG1 Z-5\nG1 Z2\nM2\n";
/// How long the first program takes, s: a way of 2 mm, four strokes of 7 mm, a way of 100 mm.
const LASTS_S: f64 = 2.0 + 4.0 * 7.0 + 100.0;

/// The hole of the second set-up is where the second of the first one is, with the part turned by a quarter; `start`: of the
/// second set-up.
fn turned_over(start: &str) -> anyhow::Result<Part> {
    let text = format!(
        "{PART}[[setup]]\nname = \"turned\"\nprogram = \"second.ngc\"\nat_mm = [0, 0, -50]\nzero_mm = [60, 80, 0]\n\
         turned_deg = [0, 0, 90]\n{start}\n[[feature]]\nname = \"three\"\nkind = \"hole\"\nlines = [3, 3]\n\
         setup = \"turned\"\n[[tolerance]]\nfeature = \"three\"\nkind = \"position\"\nwidth_um = 5\n\
         [[tolerance]]\nfeature = \"three\"\nkind = \"distance\"\nfrom = \"one\"\nlimits_um = [-5, 5]\n"
    );
    let mut part = Part::read(&text, Path::new("part.toml"))?;
    part.read_setups(|file| Program::parse("second", SECOND, file))?;
    Ok(part)
}

/// X grows by 5 µm/K. The quarter turn brings the growth of the second set-up to the part's −Y.
#[test]
fn a_set_up_grows_as_the_record_says_when_it_is_cut() {
    let machine = machine("[axis.X.thermal]\noffset_um_per_k = 5\n");
    let rise = 1.0 / 600.0;
    let grown = |after_s: f64| 5.0 * rise * (after_s + FIRST_S);
    for (start, begins_s) in
        [("", 600.0 + LASTS_S), ("start_s = 2400", 2400.0), ("start_at = \"08:50\"", 3000.0), ("start_s = 730", 730.0)]
    {
        let model = GrowthModel::of(&machine.0, None).unwrap();
        let record = read(&ramp(28_800.0, 200, rise)).unwrap();
        let growth = Some(Growth::recorded(model, &record, Start::At(29_400.0)).unwrap());
        let of = predicted(&machine, &Part { growth, ..turned_over(start).unwrap() }).unwrap();
        let [_, one, three, distance] = &of.features[..] else { panic!() };
        let [first, second] = [grown(600.0), grown(begins_s)];
        let apart = 1e3 * ((60.0 - 1e-3 * first).hypot(80.0 - 1e-3 * second) - 100.0);
        for (of, wanted) in [(one, 2.0 * first), (three, 2.0 * second), (distance, apart)] {
            let case = format!("{start}: {} {}: {} for {wanted}", of.feature, of.kind, of.uncorrected_um);
            // The planner's ramps take half a second in all.
            assert!((of.uncorrected_um - wanted).abs() < 0.01, "{case}");
            assert!(of.corrected_um.abs() < 1e-5, "{case}");
        }
        let temperature = of.temperature.unwrap();
        let [_, last] = temperature.sensors[0].celsius;
        assert!((last - 20.0 - rise * (begins_s + 9.0)).abs() < 0.02, "{start}: {last}");
        assert!((temperature.setups[0].start_s - begins_s).abs() < 1.0, "{start}: {:?}", temperature.setups);
        assert!(of.warnings.iter().all(|note| !note.contains("set-up")), "{:?}", of.warnings);
    }
    // Without a record the start has no effect, and a note says so.
    for temperature in ["", "[temperature]\nmachine_c = 22\n"] {
        let [with, without] = ["start_s = 2400", ""]
            .map(|start| predicted(&machine, &turned_over(&format!("{start}\n{temperature}")).unwrap()).unwrap());
        assert_eq!(with.features[3].uncorrected_um, without.features[3].uncorrected_um);
        let notes = |of: &PredictDocument| of.warnings.iter().filter(|note| note.contains("set-up turned")).count();
        assert_eq!([notes(&with), notes(&without)], [1, 0], "{:?}", with.warnings);
    }
}

/// `t_s` goes on after midnight, the clock begins again.
#[test]
fn a_part_is_cut_after_midnight() {
    let machine = machine("[axis.X.thermal]\noffset_um_per_k = 5\n");
    let starts = |first_s: f64, start: &str| {
        let record = read(&ramp(84_600.0, 200, 0.001)).unwrap();
        let growth = Growth::recorded(GrowthModel::of(&machine.0, None).unwrap(), &record, Start::At(first_s)).unwrap();
        let of = predicted(&machine, &Part { growth: Some(growth), ..turned_over(start).unwrap() }).unwrap();
        let temperature = of.temperature.unwrap();
        [temperature.start_s.unwrap(), temperature.setups[0].start_s]
    };
    assert_eq!(starts(85_200.0, "start_at = \"00:20\""), [600.0, 3000.0]);
    assert_eq!(starts(600.0, "start_at = \"00:20\""), [2400.0, 3000.0]);
}

/// The first program is only a place to measure from.
#[test]
fn a_first_set_up_may_cut_nothing() {
    let machine = machine("[axis.X.thermal]\noffset_um_per_k = 5\n");
    let record = read(&ramp(0.0, 200, 0.01)).unwrap();
    let growth = Growth::recorded(GrowthModel::of(&machine.0, None).unwrap(), &record, Start::After(100.0)).unwrap();
    let mut part = turned_over("").unwrap();
    part.features.retain(|feature| feature.setup.is_some());
    part.tolerances.retain(|tolerance| tolerance.feature == 2 && tolerance.datums.is_empty());
    part.tolerances.iter_mut().for_each(|tolerance| tolerance.feature = 0);
    part.growth = Some(growth);
    let program = Program::parse("nothing", "G21 G90\nM2\n", "nothing.ngc").unwrap();
    let of = predict(&machine.0, &machine.1, &program, &part, Options { trials: 200, seed: 1 }).unwrap();
    assert_eq!(of.temperature.unwrap().setups[0].start_s, 100.0);
}

#[test]
fn set_ups_out_of_time_are_refused() {
    let machine = machine("[axis.X.thermal]\noffset_um_per_k = 5\n");
    let refused = |start: &str, rows: u32| {
        let record = read(&ramp(0.0, rows, 0.01)).unwrap();
        let growth =
            Growth::recorded(GrowthModel::of(&machine.0, None).unwrap(), &record, Start::After(100.0)).unwrap();
        predicted(&machine, &Part { growth: Some(growth), ..turned_over(start).unwrap() }).unwrap_err().to_string()
    };
    let line = PART.lines().count() + 7;
    for (start, begins) in [("start_s = 200", "200.0"), ("start_s = 0", "0.0"), ("start_at = \"00:02\"", "120.0")] {
        let early = refused(start, 40);
        let found = format!("part.toml:{line}: found the set-up turned that starts {begins} s into the record");
        assert!(early.contains(&found) && early.contains("or later, when the first set-up has ended"), "{early}");
        assert!(early.contains("needed 230."), "{early}");
    }
    // The last hole is cut 9 s after the start of the second set-up.
    let short = refused("start_s = 800", 40);
    for part in ["shift.csv:41", "found the last row 780.0 s after the first", "needed rows until 80"] {
        assert!(short.contains(part), "{part}: {short}");
    }
    for (start, needed) in [
        ("start_s = -1", "start_s"),
        ("start_s = 9e9", "needed 0 to 2700000 s after the first row of the record"),
        ("start_at = \"24:10\"", "start_at: found \"24:10\", needed hours and minutes"),
        ("start_at = \"+9:+5\"", "needed hours and minutes, 00:00 to 23:59"),
        ("start_at = \"8:5\"", "needed hours and minutes, 00:00 to 23:59"),
        ("start_s = 5\nstart_at = \"08:50\"", "start_s or start_at, one of them"),
    ] {
        let error = turned_over(start).unwrap_err().to_string();
        assert!(error.contains("part.toml:") && error.contains(needed), "{error}");
    }
}

const THERMAL: &str = "reference_temperature_c = 20\n[[sensor]]\nname = \"T1\"\nlag_s = 900\nknots_c = [10, 40]\n\
                       [[sensor]]\nname = \"T2\"\nknots_c = [10, 40]\n\
                       [axis.X]\nuncertainty_um = 1.5\n[axis.X.sensor.T1]\noffset_um = [-100, 200]\n\
                       [axis.X.sensor.T2]\nslope_um_per_m = [-50, 100]\n";

/// θ = 20 °C + r (t − τ (1 − exp(−t/τ))): 10 µm/K behind its lag along X, and 5 µm/(m K) without one.
#[test]
fn a_thermal_toml_grows_behind_its_lags() {
    let (machine, stated) = machine("[uncertainty]\nsensor_k = 0.1\n");
    let rise = 1.0 / 60.0;
    let mut text = String::from("t_s,cycle,spindle_rpm,T1_c,T2_c,T3_c\n");
    for row in 0..60 {
        let t = 20.0 * f64::from(row);
        writeln!(text, "{t},0,0,{},{},21", 20.0 + rise * t, 20.0 + 0.5 * rise * t).unwrap();
    }
    let model = GrowthModel::of(&machine, Some((THERMAL, Path::new("thermal.toml")))).unwrap();
    let growth = Growth::recorded(model, &read(&text).unwrap(), Start::After(300.0)).unwrap();
    let of = predicted(&(machine, stated), &Part { growth: Some(growth), ..part("") }).unwrap();
    let grown = |t: f64, x: f64| {
        let lagged = rise * (t - 900.0 * (1.0 - (-t / 900.0).exp()));
        10.0 * lagged + 0.005 * 0.5 * rise * t * x
    };
    let first = 300.0 + FIRST_S;
    let [one, two] = [grown(first, 0.0), grown(first + APART_S, 60.0)];
    let wanted = 1e3 * ((60.0 + 1e-3 * (two - one)).hypot(80.0) - 100.0);
    let [distance, position] = &of.features[..] else { panic!() };
    assert!((distance.uncorrected_um - wanted).abs() < 0.03, "{} for {wanted}", distance.uncorrected_um);
    assert!((position.uncorrected_um - 2.0 * one).abs() < 0.05, "{} for {}", position.uncorrected_um, 2.0 * one);
    assert!(distance.corrected_um.abs() < 1e-4 && position.corrected_um < 1e-4);
    // A growth that is the same for both holes leaves their distance.
    assert!(share(distance, "growth of X") < 1e-6 && share(position, "growth of X") > 1.0);
    let budget = &position.known.as_ref().unwrap().budget;
    let [model, sensor] =
        ["growth of X", "temperature sensor T1"].map(|term| budget.iter().find(|one| one.term == term).unwrap().share);
    assert!((sensor / model - (1.0_f64 / 1.5).powi(2)).abs() < 0.02, "{sensor} of {model}");
    assert!(of.warnings.iter().any(|note| note.contains("does not take T3")), "{:?}", of.warnings);
}

#[test]
fn records_that_say_too_little_are_refused() {
    let grows = machine("[axis.X.thermal]\noffset_um_per_k = 5\n");
    let still = machine("");
    let error = |found: anyhow::Result<Growth>| format!("{:#}", found.unwrap_err());
    let model = |thermal: Option<&str>| {
        GrowthModel::of(&grows.0, thermal.map(|text| (text, Path::new("thermal.toml")))).unwrap()
    };
    // The last feature is cut until 123 s.
    let short = Growth::recorded(model(None), &read(&ramp(0.0, 7, 0.01)).unwrap(), Start::After(100.0)).unwrap();
    let refused = predicted(&grows, &Part { growth: Some(short), ..part("") }).unwrap_err().to_string();
    for part in ["shift.csv:8", "t_s", "found the last row 120.0 s", "needed rows until 22", "starts at 100.0 s"] {
        assert!(refused.contains(part), "{part}: {refused}");
    }
    let late = error(Growth::recorded(model(None), &read(&ramp(0.0, 7, 0.01)).unwrap(), Start::After(121.0)));
    assert!(late.contains("shift.csv:8") && late.contains("a start within the record, 0 to 120 s"), "{late}");
    for (record, parts) in [
        ("t_s,machine_c\n0,20\n", &["shift.csv:1", "machine_c", "needed"][..]),
        ("t_s\n0\n", &["shift.csv", "needed", "T1_c"]),
        ("t_s,T1_c\n60,20\n0,20\n", &["shift.csv:3", "t_s", "at least 60"]),
        ("t_s,T1_c\n0,2000\n", &["shift.csv:2", "T1_c", "degrees Celsius"]),
    ] {
        let refused = read(record).unwrap_err().to_string();
        assert!(parts.iter().all(|part| refused.contains(part)), "{parts:?}: {refused}");
    }
    let lacking = error(Growth::recorded(model(Some(THERMAL)), &read("t_s,T1_c\n0,20\n").unwrap(), Start::After(0.0)));
    assert!(lacking.contains("shift.csv:1") && lacking.contains("needed the column T2_c"), "{lacking}");
    let jumps = "t_s,T1_c,T2_c\n0,20,20\n60,20,40\n";
    let jumps = error(Growth::recorded(model(Some(THERMAL)), &read(jumps).unwrap(), Start::After(0.0)));
    assert!(jumps.contains("shift.csv:3") && jumps.contains("sensor T2 has jumped"), "{jumps}");
    let spindle =
        format!("{THERMAL}[axis.X.spindle]\ngrowth_um = [0, 5]\n[spindle]\nlag_s = 60\nknots_rpm = [0, 6000]\n");
    let record = read("t_s,T1_c,T2_c\n0,20,20\n").unwrap();
    let speed = error(Growth::recorded(model(Some(&spindle)), &record, Start::After(0.0)));
    assert!(speed.contains("needed the column spindle_rpm"), "{speed}");

    let refused = predicted(&still, &part("[temperature]\nmachine_c = 25\n")).unwrap_err().to_string();
    assert!(refused.contains("needed a thermal.toml") && refused.contains("expansion_um_per_m_k"), "{refused}");
    for (text, needed) in [
        ("machine_c = 500", "needed -20 to 200 degrees Celsius"),
        ("part_c = 25", "part_expansion_um_per_m_k"),
        ("part_u_k = 1", "part_c"),
        ("", "machine_c, or part_c"),
        ("machine_k = 25", "machine_c"),
    ] {
        let text = format!("{PART}[temperature]\n{text}\n");
        let refused = Part::read(&text, Path::new("part.toml")).unwrap_err().to_string();
        assert!(refused.contains("part.toml:") && refused.contains(needed), "{needed}: {refused}");
    }
    let unknown = predicted(&grows, &part("[temperature]\nmachine_c = 22\n")).unwrap();
    for key in ["uncertainty.sensor_k", "axis.X.uncertainty.growth_um"] {
        assert!(unknown.not_stated.iter().any(|own| own == key), "{key}: {:?}", unknown.not_stated);
    }
}
