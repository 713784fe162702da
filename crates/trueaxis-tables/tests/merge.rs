//! Sections that identifications write, merged into a machine.

use trueaxis_tables::merge_sections;

const MACHINE: &str = "\
# A mill.
name = \"mill\" # mine
chain = \"w X' b Z t\"

[axis.X]
table = \"x.csv\"  # measured in May

[axis.X.drive]
position_gain_per_s = 110   # from the drive's panel
velocity_gain_per_s = 800
reset_time_s = 0.006
velocity_feed_forward = 0.9

# Guessed.
[axis.X.friction]
coulomb_mm_per_s = 0.5 # a guess
presliding_um = 5
lead_s = 0.0001

[location]
B0Z_urad = 20
";

const FRAGMENT: &str = "\
# Identified from circle.csv.
[axis.X.friction]
coulomb_mm_per_s = 0.472
presliding_um = 6.3
stribeck_share = 0.31

# Z has had none.
[axis.Z.drive]
position_gain_per_s = 100
velocity_gain_per_s = 700
reset_time_s = 0.007

[axis.Z.friction]
coulomb_mm_per_s = 0.6
presliding_um = 7
";

/// Values are set in place; what is new stands with its comments; everything else stays to the letter.
#[test]
fn sections_are_set_or_added_and_comments_stay() {
    let merged = merge_sections(MACHINE, FRAGMENT).unwrap();
    let set = MACHINE
        .replace("coulomb_mm_per_s = 0.5 #", "coulomb_mm_per_s = 0.472 #")
        .replace("presliding_um = 5\n", "presliding_um = 6.3\n")
        .replace("lead_s = 0.0001\n", "lead_s = 0.0001\nstribeck_share = 0.31\n");
    let added = FRAGMENT.split_once("stribeck_share = 0.31\n").unwrap().1;
    let without: String = merged.replace(added, "");
    assert!(merged.contains(added), "{merged}");
    assert_eq!(without, set);
    // The same again changes nothing.
    assert_eq!(merge_sections(&merged, FRAGMENT).unwrap(), merged);
    // Line ends and the mark of a byte order are those of the machine.
    let windows = format!("\u{feff}{}", MACHINE.replace('\n', "\r\n"));
    let expected = format!("\u{feff}{}", merged.replace('\n', "\r\n"));
    assert_eq!(merge_sections(&windows, FRAGMENT).unwrap(), expected);
}

#[test]
fn feedback_is_merged_too() {
    let machine = MACHINE.replace("[location]", "[contour]\nmax_lag_mm = 2\n\n[location]");
    let fragment = FRAGMENT.to_owned() + "\n[contour.feedback]\nproportional = 0.2\n";
    let merged = merge_sections(&machine, &fragment).unwrap();
    assert!(
        merged.contains("[contour.feedback]\nproportional = 0.2\n") && merged.contains("max_lag_mm = 2"),
        "{merged}"
    );
}

#[test]
fn what_does_not_fit_is_refused() {
    for (machine, fragment, expected) in [
        (MACHINE, "name = \"other\"\n", "fragment.toml:1: key name: found name, needed sections [axis.X.drive],"),
        (
            MACHINE,
            "\n[axis.X.limits]\nmagnitude_um = 3\n",
            "fragment.toml:2: key axis.X.limits: found limits, needed sections",
        ),
        (MACHINE, "[axis.X]\ntable = \"y.csv\"\n", "fragment.toml:2: key axis.X.table: found table, needed sections"),
        (MACHINE, "[axis.X.friction\n", "fragment.toml:1: found "),
        ("name =\n", FRAGMENT, "machine.toml:1: found "),
        (
            MACHINE,
            "[axis.Y.drive]\nposition_gain_per_s = 1\nvelocity_gain_per_s = 2\nreset_time_s = 1\n",
            "machine.toml:20: key axis.Y: found Y, needed an axis of the chain (X Z) (in the machine with the sections merged; \
             nothing is written)",
        ),
        (
            MACHINE,
            "[axis.X.friction]\ncoulomb_mm_per_s = -1\n",
            "machine.toml:16: key axis.X.friction.coulomb_mm_per_s: found -1, needed 0 to 1000 mm/s (in the machine with",
        ),
        (
            MACHINE,
            "[axis.X.friction]\ncoulomb = 1\n",
            "machine.toml:19: key axis.X.friction.coulomb: found coulomb, needed one of",
        ),
    ] {
        let error = merge_sections(machine, fragment).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}\n{expected}");
    }
}
