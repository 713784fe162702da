//! Small machines of every kind, as files in memory: seeds for the code that reads, compiles and runs them.

use std::path::Path;
use std::sync::LazyLock;
use trueaxis::machine::MachineSettings;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;

/// Names and texts of a machine's files, `machine.toml` first.
pub type Files = &'static [(&'static str, &'static str)];

/// Three axes with the nine terms, five with twists, a grinder with its gauge, a single axis, grids of two and three axes.
pub const ALL: [Files; 5] = [THREE, FIVE, GRINDER, ONE, GRIDS];

/// Reads a machine from files that are known to be valid.
///
/// # Panics
/// Invalid files.
pub fn read(files: Files) -> Machine {
    let memory = Memory::new(files.iter().copied());
    Machine::read_from(&memory, Path::new("machine.toml"), &mut |_| {}).unwrap_or_else(|error| panic!("{error}"))
}

/// Settings of the five-axis machine.
pub fn five_axes() -> MachineSettings {
    static FIVE_AXES: LazyLock<MachineSettings> = LazyLock::new(|| read(FIVE).settings);
    FIVE_AXES.clone()
}

const GRIDS: Files = &[
    (
        "machine.toml",
        "name = \"g\"\nchain = \"w b Y X Z t\"\n[compensation]\nmodel = \"volumetric\"\n[axis.X]\ntravel_mm = [-50, 50]\n\
         [[grid]]\naxes = [\"X\", \"Y\"]\ntable = \"grid.csv\"\nfade_mm = [1.0, 10.0]\nresolution_um = 0.01\n\
         [[grid]]\naxes = [\"X\", \"Y\", \"Z\"]\ntable = \"grid-2.csv\"\nresolution_urad = 0.01\n",
    ),
    ("grid.csv", "X_mm,Y_mm,EZ_um\n0,0,1.5\n0,20,-2\n30,0,0\n30,20,3\n10,0,1\n10,20,0\n"),
    (
        "grid-2.csv",
        "Z_mm,X_mm,Y_mm,EX_um,EC_urad\n0,0,0,1,2\n0,0,9,2,1\n0,9,0,0,0\n0,9,9,1,1\n5,0,0,2,2\n5,0,9,1,-1\n5,9,0,0,4\n5,9,9,1,0\n",
    ),
];

const ONE: Files = &[
    ("machine.toml", "name = \"m\"\nchain = \"w X' b t\"\n[axis.X]\ntable = \"x.csv\"\n"),
    ("x.csv", "X_mm;EXX_fwd_um;EXX_rev_um\n0;1,5;2\n10;2;4,25\n25;0;0\n"),
];

const THREE: Files = &[
    (
        "machine.toml",
        r#"name = "mill"
chain = "w X' Y' b Z t"
tool_mm = [0.0, 0.0, 50.0]
reference_temperature_c = 20.0
[axis.X]
table = "x.csv"
interpolation = "cubic"
travel_mm = [-100.0, 100.0]
joint_mm = [-101.0, 101.0]
measured_at_mm = [0.0, 0.0, -20.0]
max_feed_mm_per_min = 15000.0
encoder_resolution_um = 0.03
hysteresis_um = 0.3
backlash_um = 2.2
[axis.X.limits]
magnitude_um = 200.0
slope_mm_per_s = 5.0
acceleration_mm_per_s2 = 5000.0
[axis.X.thermal]
offset_um_per_k = 2.0
expansion_um_per_m_k = 11.5
[axis.X.drive]
position_gain_per_s = 115.5
velocity_gain_per_s = 840
reset_time_s = 0.006
velocity_feed_forward = 0.93
[axis.X.friction]
coulomb_mm_per_s = 0.45
presliding_um = 7.2
stribeck_share = 0.3
stribeck_velocity_mm_per_s = 2
viscous = 0.00429
[axis.X.dynamic]
lag = true
acceleration = true
take_up = true
[axis.Y]
table = "y.csv"
travel_mm = [-50.0, 50.0]
[axis.Y.drive]
position_gain_per_s = 112
velocity_gain_per_s = 814.8
reset_time_s = 0.006
velocity_feed_forward = 0.93
[axis.Z]
travel_mm = [-80.0, 0.0]
[location]
A0Z_urad = 32.0
B0Z_urad = -36.0
C0Y_urad = 38.0
"#,
    ),
    (
        "x.csv",
        "# laser\nX_mm,EXX_fwd_um,EXX_rev_um,EYX_um,ECX_urad\n-100,14.5,16,6.2,-9\n-10,3,4.25,1,0\n0,0,1,0,0\n100,-7,-6,-3,11\n",
    ),
    ("y.csv", "Y_mm,EYY_um,EAY_urad\n-50,1,2\n0,0,0\n50,-2,4\n"),
];

const FIVE: Files = &[
    (
        "machine.toml",
        r#"name = "five"
chain = "w C' A' Y' b X Z t"
[compensation]
model = "volumetric"
[axis.X]
table = "x.csv"
interpolation = "cubic"
travel_mm = [-250.0, 250.0]
[axis.Y]
travel_mm = [-250.0, 250.0]
[axis.Z]
travel_mm = [-100.0, 400.0]
[axis.A]
direction = -1
travel_deg = [-120.0, 30.0]
offset_mm = [0.0, 10.0, 0.0]
[axis.C]
table = "c.csv"
travel_deg = [-36000.0, 36000.0]
backlash_urad = 12.0
[location]
EY0A_um = 11.0
EA0C_urad = 18.0
"#,
    ),
    (
        "x.csv",
        "X_mm,EXX_um,EYX_um,EZX_um,EAX_urad,EBX_urad,ECX_urad\n-250,-6,2,-3,-7,8,-8\n0,0,0,0,0,0,0\n250,4,-2,3,7,-6,5\n",
    ),
    ("c.csv", "C_deg,EXC_um,ECC_urad\n0,1,2\n120,-1,4\n240,0.5,-3\n360,1,2\n"),
];

const GRINDER: Files = &[
    ("machine.toml", include_str!("../../compensation-tables/grinder/machine.toml")),
    ("x.csv", "X_mm\tEXX_um\tEBX_urad\n-60\t-1.2\t-1.8\n0\t0\t0\n60\t2.5\t1\n"),
];
