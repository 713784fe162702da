//! Logs of probing programs: `trueaxis calibrate solve`.

use crate::choice::one_in;
use crate::{Target, no_repair, outcome, refusal, small};
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;
use trueaxis_evaluation::calibrate::{Dialect, Plan, Task, calibrate, read_log, trips};
use trueaxis_tables::Machine;
use trueaxis_tables::text::decode;

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "probe_log",
    about: "logs of probing programs as LinuxCNC, grblHAL and Klipper write them, or CSV; whole ones solved",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/probe_log.dict"),
    slowest: Duration::from_secs(5),
};

const FILE: &str = "probe.log";
const DIALECTS: [Dialect; 3] = [Dialect::LinuxCnc, Dialect::GrblHal, Dialect::Klipper];
/// Longer inputs reach nothing new.
const MOST_LINES: usize = 200;
/// One in so many complete logs is solved.
const SOLVED_ONE_IN: u64 = 64;

const TASK: &str = "machine = \"small\"\ndialect = \"linuxcnc\"\n[probe]\ntip_radius_mm = 3.0\nrepeats = 1\n\
                    tip_uncertainty_um = 1.0\n[[artefact]]\nname = \"ball\"\nkind = \"ball\"\ndiameter_mm = 25.0\n\
                    uncertainty_um = 0.3\n[[artefact.place]]\nat_mm = [0.0, 0.0, -100.0]\n";

struct Planned {
    task: Task,
    machine: Machine,
    plan: Plan,
}

fn planned() -> &'static Planned {
    static PLANNED: OnceLock<Planned> = OnceLock::new();
    PLANNED.get_or_init(|| {
        let task = Task::read(TASK, Path::new("task.toml")).expect("a good task");
        let machine = small::machine("w b X Y Z t");
        let plan = Plan::new(&task, &machine).expect("a good plan");
        Planned { task, machine, plan }
    })
}

fn run(bytes: &[u8]) {
    if bytes.iter().filter(|byte| **byte == b'\n').count() > MOST_LINES {
        return;
    }
    let file = Path::new(FILE);
    let text = match decode(bytes.to_vec(), file, &['#', ';']) {
        Ok(text) => text,
        Err(error) => return refusal::of_file(&error.to_string(), FILE, bytes),
    };
    let Planned { task, machine, plan } = planned();
    for dialect in DIALECTS {
        let log = match read_log(&text, file, dialect, outcome::refused) {
            Ok(log) => log,
            Err(error) => {
                refusal::of_file(&format!("{error:#}"), FILE, bytes);
                continue;
            }
        };
        assert!(log.touches.values().all(|touch| touch.position.iter().all(|value| value.abs() <= 1e6)), "{log:?}");
        outcome::accepted();
        outcome::saw(log.touches.len().min(3));
        match trips(task, plan, &log, file) {
            Err(error) => refusal::of_file(&format!("{error:#}"), FILE, bytes),
            Ok(trips) => {
                assert_eq!(trips.len(), plan.touches.len());
                outcome::saw("whole");
                if one_in(SOLVED_ONE_IN, bytes) {
                    match calibrate(task, machine, plan, &trips, file) {
                        Ok(found) => {
                            let json = serde_json::to_string(&found.document(task, machine)).expect("a document");
                            assert!(!json.contains("null"), "{json}");
                            outcome::saw("solved");
                        }
                        Err(error) => refusal::in_words(&format!("{error:#}")),
                    }
                }
            }
        }
    }
}

/// A log of all touches, each in the middle of its move.
fn whole() -> String {
    let Planned { plan, .. } = planned();
    let head = format!("trueaxis calibrate {:08x} touches {}\n", plan.identity, plan.touches.len());
    (1..).zip(&plan.touches).fold(head, |text, (id, touch)| {
        let [x, y, z] = [0, 1, 2].map(|k| 0.5 * (touch.start[k] + touch.end[k]));
        format!("{text}touch {id} {x:.6} {y:.6} {z:.6} 0 0 0 1.000000\n")
    })
}

fn seeds() -> Vec<Vec<u8>> {
    let parts = [
        whole(),
        "ok\n[MSG:trueaxis calibrate 0000abcd touches 2]\n[MSG:touch 1]\n[PRB:1.5,-2,3.25:1]\nok\n".into(),
        "[MSG:touch 2]\n<Idle|MPos:0,0,0>\n[PRB:1,2,3,4,5,6:1]\n".into(),
        "Recv: // trueaxis touch 1 X:1.000000 Y:2.5 Z:-3 tripped:1\n".into(),
        "# trueaxis calibrate 0000abcd\nid,x_mm,y_mm,z_mm,a_deg,tripped\n1,1,2,3,90,1\n2,1,2,3,90,1\n".into(),
        "id;x_mm;y_mm;z_mm;tripped\n1;1,5;2,5;3,5;1\n".into(),
    ];
    parts.map(String::into_bytes).into()
}
