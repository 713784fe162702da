//! Runs every target under a short, repeatable attack, with its seeds and corpus; and checks that the attack finds a planted
//! defect.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};
use trueaxis_fuzz::campaign::{Campaign, Until};
use trueaxis_fuzz::execution::{SLOWEST, execute};
use trueaxis_fuzz::finding;
use trueaxis_fuzz::targets::TARGETS;
use trueaxis_fuzz::{Target, corpus, for_each_target, no_repair};

/// Executions of each target: one processor minute for all of them.
const EXECUTIONS: u64 = 5_000;
const SEED: u64 = 20_260_101;

fn attack(target: &Target) {
    let mut campaign = Campaign::new(target, SEED, corpus::inputs(target).unwrap());
    if let Err(found) = campaign.run(Until::Executions(EXECUTIONS), &mut |_, _| ControlFlow::Continue(())) {
        let file = found.write(&finding::folder(target)).unwrap();
        panic!("{}", found.report(&file));
    }
}

/// Makes one test per target.
macro_rules! tests {
    ($($name:ident: $target:path,)*) => {
        mod attack_on {
            $(
                #[test]
                fn $name() {
                    assert_eq!(stringify!($name), $target.name);
                    super::attack(&$target);
                }
            )*
        }
    };
}

for_each_target!(tests);

#[test]
fn every_target_has_a_name_of_its_own_and_seeds_that_are_accepted() {
    for (number, target) in TARGETS.iter().enumerate() {
        assert!(TARGETS[..number].iter().all(|other| other.name != target.name), "{} twice", target.name);
        let seeds = (target.seeds)();
        assert!(!seeds.is_empty(), "{} has no seed", target.name);
        for (number, seed) in seeds.iter().enumerate() {
            let outcome = execute(target, seed).unwrap_or_else(|what| panic!("{}, seed {number}: {what}", target.name));
            assert!(outcome.accepted, "{}, seed {number} is refused", target.name);
            let mut repaired = seed.clone();
            (target.repair)(&mut repaired);
            assert_eq!(repaired, *seed, "{}: the repair changes seed {number}, which is sound", target.name);
        }
    }
}

#[test]
fn every_input_of_the_corpus_and_every_former_finding_passes() {
    let mut bytes = 0;
    for target in TARGETS {
        let archive = corpus::archive(target);
        let kept = corpus::read(&archive).unwrap();
        bytes += kept.values().map(Vec::len).sum::<usize>();
        let kept = kept.into_iter().map(|(name, input)| (archive.join(name), input));
        for (file, input) in kept.chain(finding::inputs(&finding::folder(target)).unwrap()) {
            if let Err(what) = execute(target, &input) {
                panic!("{}: {what}", file.display());
            }
        }
    }
    // fuzz/run.sh keeps 8 kB per target, in addition to findings.
    let most = 9_000 * TARGETS.len();
    assert!(bytes <= most, "the corpus has {bytes} bytes, needed at most {most}: a repository carries it");
}

#[test]
fn every_archive_of_the_corpus_and_every_dictionary_belongs_to_a_target() {
    for kind in ["corpus", "dictionaries"] {
        for entry in std::fs::read_dir(corpus::home().join(kind)).into_iter().flatten() {
            let path = entry.unwrap().path();
            // Readers of the same kind share their words.
            let words = std::fs::read_to_string(&path).unwrap_or_default();
            let belongs = |target: &&Target| {
                if kind == "corpus" { corpus::archive(target) == path } else { target.dictionary == words }
            };
            assert!(TARGETS.iter().any(belongs), "{} belongs to no target", path.display());
        }
    }
}

/// Panics behind a word of the dictionary, a number and a check sum.
const PLANTED: Target = Target {
    name: "planted",
    about: "a defect that is there",
    run: |input| {
        let Some((sum, rest)) = input.split_first() else { return };
        assert!(
            *sum != rest.iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte))
                || !rest.windows(9).any(|part| part == b"feed -0.0" || part.starts_with(b"feed NaN")),
            "planted"
        );
    },
    seeds: || vec![b"\x3cfeed 1\n".to_vec()],
    repair: |input| {
        if let Some((sum, rest)) = input.split_first_mut() {
            *sum = rest.iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte));
        }
    },
    dictionary: "\"feed \"\n\"NaN.\"\n",
    slowest: SLOWEST,
};

#[test]
fn a_planted_defect_is_found_written_down_and_found_again() {
    let search = || {
        let mut campaign = Campaign::new(&PLANTED, 1, (PLANTED.seeds)());
        campaign.run(Until::Executions(2_000_000), &mut |_, _| ControlFlow::Continue(())).unwrap_err()
    };
    let found = search();
    assert!(found.what.contains("planted") && found.what.contains("seeded.rs"), "{}", found.what);
    let folder = tempfile::tempdir().unwrap();
    let file = found.write(folder.path()).unwrap();
    let inputs = finding::inputs(folder.path()).unwrap();
    assert_eq!(inputs, [(file.clone(), found.input.clone())]);
    let report = std::fs::read_to_string(file.with_extension("txt")).unwrap();
    assert!(report.contains(&format!("--seed 1 --executions {}", found.execution + 1)), "{report}");
    assert!(execute(&PLANTED, &inputs[0].1).is_err());
    let again = search();
    assert_eq!((again.execution, &again.input), (found.execution, &found.input));
}

#[test]
fn an_execution_that_takes_long_is_a_finding() {
    const SLOW: Target = Target {
        name: "slow",
        about: "takes its time",
        run: |_| {
            let start = Instant::now();
            while start.elapsed() < Duration::from_millis(300) {
                std::hint::spin_loop();
            }
        },
        seeds: Vec::new,
        repair: no_repair,
        dictionary: "",
        // Other processes may use most of the processor; their time does not count.
        slowest: Duration::from_millis(10),
    };
    assert!(execute(&SLOW, b"").unwrap_err().starts_with("took "));
    assert!(execute(&Target { slowest: SLOWEST, ..SLOW }, b"").is_ok());
    assert!(finding::folder(&SLOW).ends_with(Path::new("findings/slow")));
}
