//! The LinuxCNC script that writes a record leaves the old file or the new one, as the programs do. LinuxCNC is not needed.

use std::fs;
use std::path::Path;
use std::process::Output;
use trueaxis_testing::command::Folder;

/// Runs lines of Python with the script's functions; LinuxCNC's module is replaced by an empty one.
fn python(folder: &Folder, lines: &str) -> Option<Output> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../integrations/linuxcnc/record-circles.py");
    let program = format!(
        "import importlib.util, resource, signal, sys, types\n\
         sys.modules['linuxcnc'] = types.ModuleType('linuxcnc')\n\
         sys.dont_write_bytecode = True\n\
         spec = importlib.util.spec_from_file_location('circles', {:?})\n\
         circles = importlib.util.module_from_spec(spec)\n\
         spec.loader.exec_module(circles)\n\
         {lines}",
        script.to_str().unwrap()
    );
    let done = folder.command(&["-c", &program]).output().ok();
    if done.is_none() {
        eprintln!("not tested: found no python3");
    }
    done
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_record_of_circles_is_written_whole_or_not_at_all() {
    let folder = Folder::new("python3");
    let at = |name: &str| folder.join(name);
    fs::write(at("r.csv"), "old").unwrap();
    fs::write(at("r.csv.Ab12Cd.trueaxis-tmp"), "left").unwrap();
    let Some(done) = python(&folder, "circles.write('r.csv', 'new')") else { return };
    assert!(done.status.success(), "{done:?}");
    assert_eq!(fs::read_to_string(at("r.csv")).unwrap(), "new");
    assert_eq!(names(folder.path()), ["r.csv"], "what was left is swept");

    // No room after 100 bytes.
    let lines = "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n\
                 resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))\n\
                 circles.write('r.csv', 'x' * 1000)";
    let done = python(&folder, lines).unwrap();
    assert!(!done.status.success() && String::from_utf8_lossy(&done.stderr).contains("File too large"), "{done:?}");
    assert_eq!(fs::read_to_string(at("r.csv")).unwrap(), "new");
    assert_eq!(names(folder.path()), ["r.csv"]);

    // Killed while writing.
    let lines = "circles.os.fsync = lambda handle: circles.os.kill(circles.os.getpid(), 9)\n\
                 circles.write('r.csv', 'x' * 1000)";
    assert!(!python(&folder, lines).unwrap().status.success());
    assert_eq!(fs::read_to_string(at("r.csv")).unwrap(), "new");
    assert_eq!(names(folder.path()).len(), 2, "its unfinished file");
    assert!(python(&folder, "circles.write('r.csv', 'newer')").unwrap().status.success());
    assert_eq!((fs::read_to_string(at("r.csv")).unwrap().as_str(), names(folder.path()).len()), ("newer", 1));

    // A device is written to, not replaced; overwriting an input is refused.
    assert!(!python(&folder, "circles.write('/dev/full', 'x')").unwrap().status.success());
    let lines = "circles.refuse_inputs(types.SimpleNamespace(output='./r.csv', friction=None, machine='r.csv'))";
    let done = python(&folder, lines).unwrap();
    assert!(String::from_utf8_lossy(&done.stderr).contains("found the input r.csv"), "{done:?}");
}
