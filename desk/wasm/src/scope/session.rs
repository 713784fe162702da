//! An open scope: a run with its curves, and the acts on it.

use super::request::{Request, exchange_name};
use super::traces::Traces;
use crate::files::Texts;
use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use trueaxis_report::thin;
use trueaxis_sim::event::{Act, EventKind};
use trueaxis_sim::path::drawn;
use trueaxis_sim::run::{Figures, Kind, Run, notes};
use trueaxis_sim::{Scenario, Settings};

/// Number of sections of a curved move, and of the whole path if that has more points.
const PARTS_OF_A_MOVE: u32 = 64;
const PARTS_OF_THE_PATH: usize = 700;

/// A run in progress.
pub(super) struct Session {
    pub(super) request: Request,
    pub(super) scenario: Arc<Scenario>,
    /// Settings including all acts so far.
    pub(super) settings: Settings,
    pub(super) kinds: Vec<Kind>,
    pub(super) notes: Vec<String>,
    run: Run,
    pub(super) traces: Traces,
    done: bool,
    /// The machine of the latest exchange.
    pub(super) exchanged: Option<String>,
}

/// Progress of a run.
#[derive(Serialize)]
pub(super) struct Progress {
    cycle: u64,
    cycles: u64,
    time_s: f64,
    done: bool,
}

/// A requested act on a run.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    act: String,
    /// Files of the machine to exchange, if it is not known yet.
    files: Option<Texts>,
}

/// Figures so far, and remarks: parts that the watch withdrew, among others.
#[derive(Serialize)]
pub(super) struct Noted {
    #[serde(flatten)]
    figures: Figures,
    notes: Vec<String>,
}

/// An act as recorded.
#[derive(Serialize)]
pub(super) struct Recorded {
    /// `faults` or `events` of the scenario.
    list: &'static str,
    act: String,
    time_s: f64,
}

impl Session {
    pub(super) fn open(request: &str) -> Result<Session> {
        let request = Request::parse(request)?;
        let mut notes = Vec::new();
        let scenario = Arc::new(request.scenario(&mut notes)?);
        let kinds = request.kinds(&scenario.machine)?;
        Ok(Session {
            run: Run::of(Arc::clone(&scenario), &kinds)?,
            traces: Traces::new(&scenario, &kinds),
            settings: scenario.settings.clone(),
            done: false,
            exchanged: None,
            request,
            scenario,
            kinds,
            notes,
        })
    }

    /// Runs at most `cycles` further cycles.
    pub(super) fn advance(&mut self, cycles: u32) -> Progress {
        self.done = !self.run.advance(cycles.into(), &mut self.traces);
        self.progress()
    }

    pub(super) fn progress(&self) -> Progress {
        let (cycle, cycles) = (self.run.cycle(), self.run.cycles());
        Progress { cycle, cycles, time_s: self.scenario.time_s(cycle), done: self.done }
    }

    pub(super) fn cycles(&self) -> u64 {
        self.run.cycles()
    }

    pub(super) fn figures(&self) -> Noted {
        let machines: Vec<_> = self.kinds.iter().copied().zip(self.run.tallies()).collect();
        let notes = notes(&self.scenario, self.run.cycle(), &machines);
        Noted { figures: Figures::of(&self.scenario, &machines), notes }
    }

    /// The programmed path: x, y, z, line, cutting.
    pub(super) fn path(&self) -> Vec<f32> {
        let points = drawn(&self.scenario, PARTS_OF_A_MOVE);
        let kept = thin(&points, PARTS_OF_THE_PATH, |point| point.position_mm);
        let row = |point: &trueaxis_sim::path::DrawnPoint| {
            let [x, y, z] = point.position_mm.map(|q| q as f32);
            [x, y, z, point.line as f32, f32::from(u8::from(point.cutting))]
        };
        kept.iter().flat_map(row).collect()
    }

    /// Applies an act to the run: text as in a scenario, whose time may be `now`, or JSON with the act and a machine's files.
    pub(super) fn act(&mut self, asked: &str) -> Result<Recorded> {
        let asked = match asked.trim_start().starts_with('{') {
            true => serde_json::from_str(asked).context("what is to be done to the run")?,
            false => Asked { act: asked.to_owned(), files: None },
        };
        let now = self.scenario.time_s(self.run.cycle());
        let act: Act = at_now(&asked.act, now).parse()?;
        if let (Act::Event(event), Some(files)) = (&act, asked.files) {
            let EventKind::Exchange(name) = &event.kind else { bail!("{act}: found files, needed none") };
            self.know(name, files)?;
        }
        self.run.act(&act, &self.scenario.exchanges)?;
        let act_text = act.to_string();
        Ok(match act {
            Act::Fault(fault) => {
                self.settings.faults.items.push(fault);
                Recorded { list: "faults", act: act_text, time_s: fault.at_s }
            }
            Act::Event(event) => {
                let time_s = event.at_s;
                if let EventKind::Exchange(name) = &event.kind {
                    self.exchanged = Some(name.clone());
                }
                self.settings.events.items.push(event);
                Recorded { list: "events", act: act_text, time_s }
            }
        })
    }

    /// Stores the files of another machine; a name must always refer to the same files.
    fn know(&mut self, name: &str, files: Texts) -> Result<()> {
        exchange_name(name)?;
        match self.request.exchanges.get(name) {
            Some(known) if *known == files => return Ok(()),
            Some(_) => bail!("exchange: found \"{name}\" with other files than before, needed another name"),
            None => {}
        }
        let machine = self.request.machine(&files, &mut self.notes).with_context(|| format!("exchange:{name}"))?;
        Arc::make_mut(&mut self.scenario).exchanges.insert(name.to_owned(), machine);
        self.request.exchanges.insert(name.to_owned(), files);
        Ok(())
    }
}

/// The act with the time of the next cycle in place of `@now`.
fn at_now(act: &str, now_s: f64) -> String {
    match act.rsplit_once("@now") {
        Some((what, rest)) if rest.trim().is_empty() || rest.trim_start().starts_with('+') => {
            format!("{what}@{now_s}s{rest}")
        }
        _ => act.to_owned(),
    }
}
