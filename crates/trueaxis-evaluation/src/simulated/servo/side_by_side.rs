//! Plants of a family on one program, side by side.

use rayon::prelude::*;
use std::sync::Arc;
use trueaxis::machine::AXES;
use trueaxis_sim::Scenario;
use trueaxis_sim::error::Result;
use trueaxis_sim::plant::drive::DriveSettings;
use trueaxis_sim::run::{Kind, Moment, Run, Sample};

/// Plants in one run: enough that their common commands cost little, few enough to occupy every core.
const GROUP: usize = 8;
/// Cycles that every group is simulated at a time.
const BLOCK: u64 = 2048;

/// A cycle of all plants.
pub(super) struct Cycle<'c> {
    /// Line of the program.
    pub(super) line: u32,
    /// Cycle of the program.
    pub(super) cycle: u64,
    /// Contour error of every plant, µm; `None` once it has stopped.
    pub(super) errors: &'c mut dyn Iterator<Item = Option<[f32; 3]>>,
}

struct Group {
    run: Run,
    plants: usize,
    moments: Vec<Moment>,
    /// Plant by plant within a cycle.
    errors: Vec<Option<[f32; 3]>>,
}

/// Runs the plants and passes every cycle in which the tool cuts to `each`.
pub(super) fn simulate(
    scenario: &Arc<Scenario>,
    plants: &[[DriveSettings; AXES]],
    mut each: impl FnMut(Cycle<'_>),
) -> Result<()> {
    let start = |drives: &[[DriveSettings; AXES]]| {
        let run = Run::with_drives(Arc::clone(scenario), Kind::Configured, drives)?;
        Ok(Group { run, plants: drives.len(), moments: Vec::new(), errors: Vec::new() })
    };
    let mut groups: Vec<Group> = plants.par_chunks(GROUP).map(start).collect::<Result<_>>()?;
    let mut running = true;
    while running {
        let on: Vec<bool> = groups.par_iter_mut().map(Group::advance).collect();
        running = on.contains(&true);
        let longest = groups.iter().max_by_key(|group| group.moments.len());
        let moments: Vec<Moment> = longest.map(|group| group.moments.clone()).unwrap_or_default();
        for (k, moment) in moments.iter().enumerate().filter(|(_, moment)| moment.cutting) {
            let mut errors = groups.iter().flat_map(|group| {
                (0..group.plants).map(move |plant| group.errors.get(k * group.plants + plant).copied().flatten())
            });
            let Moment { line, cycle, .. } = *moment;
            each(Cycle { line, cycle, errors: &mut errors });
        }
    }
    Ok(())
}

impl Group {
    fn advance(&mut self) -> bool {
        let Group { run, moments, errors, .. } = self;
        moments.clear();
        errors.clear();
        run.advance(BLOCK, &mut |moment: &Moment, samples: &[Option<&Sample>]| {
            moments.push(*moment);
            errors.extend(samples.iter().map(|sample| Some(sample.as_ref()?.deviation_um)));
        })
    }
}
