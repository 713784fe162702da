//! Which findings are written into a machine.

use std::path::Path;
use trueaxis_tables::Additions;
use trueaxis_tables::files::Memory;
use trueaxis_tables::finding::{Decision, Finding, Fit, Known, Why, decide, table};

fn known(value: f64, uncertainty: f64) -> Known {
    Known { value, uncertainty: Some(uncertainty), degrees_of_freedom: None }
}

fn bare(value: f64) -> Known {
    Known { value, uncertainty: None, degrees_of_freedom: None }
}

#[test]
fn one_rule_decides() {
    // They differ by more than twice √(3² + 11²) = 11.4.
    let (written, why) = decide(Some(known(32.0, 3.0)), known(0.2174671317786221, 11.0), true);
    assert_eq!(written, Some(known(0.0, 11.0)));
    assert!(matches!(why, Why::Differs(times) if (times - 31.782_532_87 / 11.401_754_25).abs() < 1e-6), "{why:?}");
    // Scatter compared with nothing stated.
    assert_eq!(decide(None, known(0.12, 0.28), true), (None, Why::Nothing));
    assert_eq!(decide(None, known(0.6, 0.28), true), (Some(known(0.6, 0.28)), Why::New));
    // The stated value has no uncertainty, so any found value is better known.
    assert_eq!(decide(Some(bare(20.0)), known(20.04, 0.31), true), (Some(known(20.04, 0.31)), Why::BetterKnown));
    assert_eq!(decide(Some(known(20.0, 1.0)), bare(30.0), true), (None, Why::Unknown));
    // (32/9 + 25/121)/(1/9 + 1/121) = 31.515…, (1/9 + 1/121)^(−1/2) = 2.894….
    let both = decide(Some(known(32.0, 3.0)), known(25.0, 11.0), true);
    assert_eq!(both, (Some(known(31.5, 2.9)), Why::Combined));
    assert_eq!(decide(Some(known(32.0, 3.0)), known(25.0, 11.0), false), (None, Why::SameRecord));
    // Two values of equal weight: u/√2, and 8 degrees of freedom each give 16 (Welch, Satterthwaite).
    let of = |value: f64| Known { degrees_of_freedom: Some(8.0), ..known(value, 2.0) };
    let expected = Known { degrees_of_freedom: Some(16.0), ..known(11.0, 1.4) };
    assert_eq!(decide(Some(of(10.0)), of(12.0), true).0, Some(expected));
}

#[test]
fn figures_have_two_digits_of_their_uncertainty() {
    for (value, uncertainty, shown) in [
        (0.2174671317786221, 11.0, "0 (u 11)"),
        (31.5151, 2.894, "31.5 (u 2.9)"),
        (1234.5, 345.0, "1230 (u 350)"),
        (-0.04, 11.0, "0 (u 11)"),
        (0.123456, 0.0123, "0.123 (u 0.012)"),
        (50.000_000_3, 1e-9, "50 (u 0.001)"),
        (4.36, 1.0, "4.4 (u 1)"),
        (4.36, 0.995, "4.36 (u 1)"),
    ] {
        assert_eq!(known(value, uncertainty).to_string(), shown);
    }
}

const MACHINE: &str = "name = \"m\"\nchain = \"w b X Y t\"\n[location] # ours\nC0Y_urad = 10\n[axis.X]\nbacklash_um = 2.0\n[axis.Y]\n\
                       [uncertainty.location]\nC0Y_urad = 1\ndegrees_of_freedom = 5\n";

fn findings(values: &[(&str, Known)], fit: Option<Fit>) -> Additions {
    let finding = |(key, found): &(&str, Known)| Finding { key: (*key).into(), found: *found, ..Finding::default() };
    Additions { findings: values.iter().map(finding).collect(), fit, record: Some("1a".into()), ..Additions::default() }
}

fn edited(machine: &str, additions: &Additions) -> (String, Vec<Decision>) {
    let (files, name) = (Memory::new([("machine.toml", machine)]), Path::new("machine.toml"));
    let text = additions.edit(&files, name).unwrap().files.last().map_or(machine.into(), |(_, text)| text.clone());
    (text, additions.decide(&files, name).unwrap())
}

#[test]
fn values_are_written_with_how_well_they_are_known() {
    let found = [
        ("location.C0Y_urad", Known { degrees_of_freedom: Some(40.0), ..known(20.12345, 0.6) }),
        ("axis.X.backlash_um", known(2.345, 0.1)),
        ("axis.Y.backlash_um", known(0.12, 0.28)),
    ];
    let (text, decisions) = edited(MACHINE, &findings(&found, None));
    for part in [
        "[location] # ours\nC0Y_urad = 20.12\n",
        "backlash_um = 2.35\n",
        "C0Y_urad = 0.6\ndegrees_of_freedom = 5\nC0Y_degrees_of_freedom = 40\n",
        "records = [\"1a\"]",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
    assert!(
        text.contains("[axis.X.uncertainty]\nbacklash_um = 0.1\n[axis.Y]\n\n[uncertainty]"),
        "nothing of Y: {text}"
    );
    let listed = table(&decisions);
    assert!(listed.lines().count() == 4 && listed.contains("0.12 (u 0.28)") && listed.contains("10 (u 1)"), "{listed}");
    // Read again, the values come with their uncertainties.
    let known = trueaxis_tables::uncertainty::Uncertainties::read_from(
        &Memory::new([("machine.toml", text.as_str())]),
        Path::new("machine.toml"),
    );
    let known = known.unwrap();
    assert_eq!((known.location.degrees_of("C0Y"), known.location.degrees_of("A0Z")), (Some(40.0), Some(5.0)));
    assert_eq!(known.records, ["1a"]);
    // The same record changes nothing the second time.
    assert_eq!(edited(&text, &findings(&found, None)).0, text);
}

#[test]
fn a_misfit_writes_nothing() {
    let found = [("location.C0Y_urad", known(50.0, 0.1))];
    let fit = |left_um: f64, noise_um: Option<f64>| {
        Some(Fit {
            before_mm: 3.3e-3,
            left_mm: 1e-3 * left_um,
            noise_mm: noise_um.map(|um| 1e-3 * um),
            is_angle: false,
        })
    };
    for (fit, writes) in [
        (fit(3.68, None), false),
        (fit(2.4, None), false),
        (fit(2.2, None), true),
        (fit(3.68, Some(1.0)), false),
        (fit(3.2, Some(1.2)), true),
        (None, true),
    ] {
        let (text, decisions) = edited(MACHINE, &findings(&found, fit));
        assert_eq!(text != MACHINE, writes, "{fit:?}");
        assert_eq!(matches!(decisions[0].why, Why::Misfit(_)), !writes);
    }
}

/// `force` writes the found values regardless of the rule, and the reasons state the rule's decision; the controller's
/// refusals remain.
#[test]
fn forced_values_are_written_with_the_verdict_of_the_rule() {
    let found = [
        ("location.C0Y_urad", known(10.5, 2.0)),
        ("axis.X.backlash_um", known(2.345, 0.1)),
        ("axis.Y.backlash_um", known(0.12, 0.28)),
    ];
    let forced = |fit| Additions { force: true, ..findings(&found, fit) };
    let (text, decisions) = edited(MACHINE, &forced(None));
    for part in ["C0Y_urad = 10.5\n", "backlash_um = 2.35\n", "[axis.Y]\nbacklash_um = 0.12\n", "backlash_um = 0.28\n"]
    {
        assert!(text.contains(part), "{part} in {text}");
    }
    let why = decisions.iter().map(|of| of.why.to_string()).collect::<Vec<_>>();
    assert_eq!(
        why,
        [
            "forced, the rule writes 10.1 (u 0.89): agrees: weighted mean of both",
            "forced, the rule writes the same: no uncertainty is stated",
            "forced, the rule writes nothing: within 2 standard uncertainties of zero",
        ]
    );
    let misfit = Some(Fit { before_mm: 3.3e-3, left_mm: 3.2e-3, noise_mm: None, is_angle: false });
    let (other, decisions) = edited(MACHINE, &forced(misfit));
    assert_eq!(other, text);
    assert!(decisions.iter().all(|of| of.why.to_string().starts_with("forced, the rule writes nothing: misfit: ")));
    // A value that is not a number; one outside the controller's range; lost motion below zero that no hysteresis covers.
    let files = Memory::new([("machine.toml", MACHINE)]);
    for value in [f64::NAN, f64::INFINITY, 1e9] {
        let bad = Additions { force: true, ..findings(&[("location.C0Y_urad", known(value, 1.0))], None) };
        assert!(bad.edit(&files, Path::new("machine.toml")).is_err(), "{value}");
    }
    let below = Additions { force: true, ..findings(&[("axis.Y.backlash_um", known(-3.0, 0.1))], misfit) };
    let (same, decisions) = edited(MACHINE, &below);
    assert_eq!((same.as_str(), decisions[0].written, &decisions[0].why), (MACHINE, None, &Why::OverCompensated));
    // An uncertainty that is not a number becomes unknown; a residual that the machine already includes is not added again.
    let vague = Additions { force: true, ..findings(&[("axis.Y.backlash_um", known(3.0, f64::NAN))], None) };
    assert_eq!(edited(MACHINE, &vague).1[0].written, Some(bare(3.0)));
    let again = Additions { compensated: true, ..forced(None) };
    assert_eq!(edited(&text, &again).0, text);
}

/// Errors of a table are added with the share that is written.
#[test]
fn a_curve_is_added_by_its_weight() {
    let toml = "name = \"m\"\nchain = \"w b X t\"\n[axis.X]\ntable = \"x.csv\"\n[axis.X.uncertainty]\nscale_ppm = 10\n";
    let files = Memory::new([("machine.toml", toml), ("x.csv", "X_mm,EXX_um\n0,0\n100,5\n")]);
    let of = |found: Known| {
        let curve = vec![(0.0, [0.0; 6]), (100.0, [1e-4 * found.value, 0.0, 0.0, 0.0, 0.0, 0.0])];
        let finding = Finding { key: "axis.X.scale_ppm".into(), found, on_top: true, curve, ..Finding::default() };
        let additions = Additions { findings: vec![finding], ..Additions::default() };
        let edited = additions.edit(&files, Path::new("machine.toml")).unwrap();
        let file =
            |name: &str| edited.files.iter().find(|(own, _)| own == Path::new(name)).map(|(_, text)| text.clone());
        (file("x.csv"), file("machine.toml"))
    };
    // 100 ppm are 10 µm; with half of the weight each, 10 ppm add 5 µm.
    assert_eq!(of(known(100.0, 10.0)).0.unwrap(), "X_mm,EXX_um\n0,0\n100,15\n");
    let (table, text) = of(known(20.0, 10.0));
    assert_eq!(table.unwrap(), "X_mm,EXX_um\n0,0\n100,6\n");
    assert!(text.unwrap().contains("scale_ppm = 7.1\n"));
}

/// The results of one fit are written all or not at all, including values that it held fixed; if all agree, they are combined
/// with one weight.
#[test]
fn jointly_fitted_values_are_written_together() {
    let machine = "name = \"m\"\nchain = \"w b X t\"\n[axis.X]\n\
                   [axis.X.drive]\nposition_gain_per_s = 110\nvelocity_gain_per_s = 800\nreset_time_s = 0.006\n\
                   [axis.X.friction]\ncoulomb_mm_per_s = 0.50\npresliding_um = 6.0 # ours\nviscous = 0.01\n\
                   [axis.X.friction.uncertainty]\ncoulomb_mm_per_s = 0.02\npresliding_um = 0.2\nviscous = 0.005\n\
                   degrees_of_freedom = 20\n";
    let of = |[coulomb, presliding, viscous]: [Known; 3], fit| {
        let all = [("coulomb_mm_per_s", coulomb), ("presliding_um", presliding), ("viscous", viscous)];
        let all = all.map(|(key, found)| Finding {
            key: format!("axis.X.friction.{key}"),
            found: Known { degrees_of_freedom: Some(8.0), ..found },
            together: "X".into(),
            ..Finding::default()
        });
        edited(machine, &Additions { findings: all.into(), fit, ..Additions::default() })
    };
    // Coulomb friction is off by 5 combined uncertainties: pre-sliding, which agrees, and the value that the fit held are
    // written too.
    let differs = [known(0.6, 0.01), known(6.1, 0.1), bare(0.0)];
    let (text, decisions) = of(differs, None);
    for part in [
        "coulomb_mm_per_s = 0.6\npresliding_um = 6.1 # ours\nviscous = 0.0\n",
        "coulomb_mm_per_s = 0.01\npresliding_um = 0.1\ndegrees_of_freedom = 8\n",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
    assert!(matches!(decisions[0].why, Why::Differs(_)) && decisions[1].why == Why::Together);
    assert_eq!(decisions[2].written, Some(Known { degrees_of_freedom: Some(8.0), ..bare(0.0) }));
    // All agree, each found with half of the stated uncertainty: four fifths of the way, and u = √(0.64 u_f² + 0.04
    // u_s²) = 0.0089.
    let agrees = [known(0.51, 0.01), known(6.1, 0.1), known(0.015, 0.0025)];
    let (text, decisions) = of(agrees, None);
    for part in [
        "coulomb_mm_per_s = 0.508\n",
        "presliding_um = 6.08 # ours",
        "viscous = 0.014\n",
        "coulomb_mm_per_s = 0.0089\n",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
    assert!(decisions.iter().all(|of| of.why == Why::Combined));
    // A misfit writes nothing.
    let fit = Some(Fit { before_mm: 1e-3, left_mm: 9e-4, noise_mm: None, is_angle: false });
    assert_eq!(of(differs, fit).0, machine);
    // Uncertainties belong to values that the section has.
    let wrong = machine.replace("viscous = 0.005", "viscosity = 0.005");
    let refused = trueaxis_tables::Machine::read_from(
        &Memory::new([("machine.toml", wrong)]),
        Path::new("machine.toml"),
        &mut |_| {},
    );
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("machine.toml:15: key axis.X.friction.uncertainty.viscosity"), "{refused}");
}

/// Small values keep their digits, in their own units.
#[test]
fn figures_below_one_keep_their_digits() {
    for (value, uncertainty, shown) in [
        (0.0062, 0.000_52, "0.0062 (u 0.00052)"),
        (0.0, 1e-5, "0 (u 0.00001)"),
        (0.000_123_4, 2e-5, "0.000123 (u 0.00002)"),
    ] {
        assert_eq!(known(value, uncertainty).to_string(), shown);
    }
}
