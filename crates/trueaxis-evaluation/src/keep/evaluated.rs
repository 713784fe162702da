//! Evaluates the log of a probing against the history: the entry and the files it would write.

use super::document::ReprobingDocument;
use super::entry::{Entry, EntryKind, LogFile};
use super::history::sum;
use super::reprobing::{Before, Reprobing, begin, evaluate, plan};
use super::state::{State, tables};
use super::update::changes;
use super::written::FileChanges;
use crate::calibrate::{Logged, Plan, read_log, trips};
use anyhow::Result;
use std::path::Path;

/// The log of a probing.
#[derive(Clone, Debug)]
pub struct Log<'l> {
    /// Name of the log, in errors and in the history.
    pub file: &'l Path,
    /// Text of the log.
    pub text: &'l str,
    /// Time of the probing, in the form that [`time`] accepts.
    pub time: Option<String>,
    /// Number of parts made until then.
    pub parts: Option<u64>,
}

/// Exceptions that a person has accepted.
#[derive(Clone, Copy, Debug, Default)]
pub struct Overrides<'l> {
    /// Names of terms that may be out of their bounds.
    pub accept: &'l [String],
    /// Whether tables may differ from those the history left.
    pub by_hand: bool,
}

/// An evaluated probing.
#[derive(Clone, Debug)]
pub struct EvaluatedLog {
    /// The fitted network, the positions of the balls, and a verdict on each term.
    pub reprobing: Reprobing,
    /// The probing as a document.
    pub document: ReprobingDocument,
    /// The history entry that applying it adds.
    pub entry: Entry,
    /// Files that would change, `machine.toml` last of the machine's own; empty if a term is refused.
    pub files: FileChanges,
    /// A sentence on each change.
    pub changes: Vec<String>,
}

impl EvaluatedLog {
    /// Why a person has to check before anything changes; `None` if all terms are within their bounds.
    pub fn refusal(&self, log: &Path) -> Option<String> {
        let reasons: Vec<String> = self.reprobing.refused().map(|(name, reason)| format!("{name} {reason}")).collect();
        (!reasons.is_empty()).then(|| {
            format!(
                "{}: {}: nothing is changed; the ball may have been moved or hit. To apply it anyway: --accept TERM",
                log.display(),
                reasons.join("; ")
            )
        })
    }
}

/// A time in UTC, in the one form whose text order is time order.
///
/// # Errors
/// Any other form.
pub fn time(text: &str) -> Result<String, String> {
    let shape = "0000-00-00T00:00:00Z";
    let fits = |(own, of): (u8, u8)| if of == b'0' { own.is_ascii_digit() } else { own == of };
    let sound = text.len() == shape.len() && text.bytes().zip(shape.bytes()).all(fits);
    if sound { Ok(text.into()) } else { Err("needed a time in UTC like 2026-05-04T06:00:00Z".into()) }
}

impl State {
    fn trips(&self, log: &Log<'_>, note: &mut dyn FnMut(String)) -> Result<(Plan, Vec<Logged>)> {
        let plan = plan(&self.task, &self.machine)?;
        let read = read_log(log.text, log.file, self.task.probing.dialect, |how| {
            note(format!("{}: {how}", log.file.display()));
        })?;
        let trips = trips(&self.task.probing, &plan, &read, log.file)?;
        Ok((plan, trips))
    }

    /// An entry without changes.
    fn entry(&self, log: &Log<'_>, plan: &Plan, reprobing: &Reprobing, kind: EntryKind) -> Entry {
        let tables = self.tables();
        let file = log.file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Entry {
            entry: self.history.next(),
            kind,
            time: log.time.clone(),
            parts: log.parts,
            plan: plan.number(),
            log: Some(LogFile { file, crc: sum(log.text.as_bytes()) }),
            undone: None,
            sigma_um: Some(1e3 * reprobing.calibration.solution.sigma_mm),
            measured: reprobing.measured(&self.task),
            balls: reprobing.balls.clone(),
            totals: Default::default(),
            files: Vec::new(),
            tables: [tables.clone(), tables],
        }
    }

    /// Evaluates the first probing. Writes nothing.
    ///
    /// # Errors
    /// As [`begin`], or a log that is not the task's.
    pub fn begin(&self, log: &Log<'_>, note: &mut dyn FnMut(String)) -> Result<EvaluatedLog> {
        let (plan, trips) = self.trips(log, note)?;
        let reprobing = begin(&self.task, &self.machine, &plan, &trips, log.file)?;
        let entry = self.entry(log, &plan, &reprobing, EntryKind::Begin);
        let mut document = reprobing.document(&self.task, &self.machine.settings.name, entry.entry);
        document.notes.push("the beginning: later re-probings are compared with the places of these balls".into());
        Ok(EvaluatedLog { reprobing, document, entry, files: FileChanges::new(), changes: Vec::new() })
    }

    /// Refuses names that are not terms of the task.
    ///
    /// # Errors
    /// The first such name, and the names needed.
    pub fn accepts(&self, names: &[String]) -> Result<(), String> {
        let own = || self.task.terms.iter().map(|kept| kept.name.as_str());
        match names.iter().find(|name| own().all(|term| term != **name)) {
            None => Ok(()),
            Some(unknown) => Err(format!("found {unknown:?}, needed one of {}", own().collect::<Vec<_>>().join(", "))),
        }
    }

    /// Evaluates a later probing against the history. Writes nothing, but computes the machine's new files, so that a refusal
    /// shows before anything is applied.
    ///
    /// # Errors
    /// As [`evaluate`] and [`changes`], a log that is not the task's or does not follow the history, or tables other than
    /// those the history left.
    pub fn check(&self, log: &Log<'_>, allowed: Overrides<'_>, note: &mut dyn FnMut(String)) -> Result<EvaluatedLog> {
        self.history.beginning()?;
        self.untouched(allowed.by_hand, note)?;
        let (plan, trips) = self.trips(log, note)?;
        self.history.follows(&plan.number(), &sum(log.text.as_bytes()), log.time.as_deref(), log.parts)?;
        let (known, totals) = (self.history.balls()?, self.history.totals());
        let before = Before { known, totals: &totals, accepted: allowed.accept };
        let reprobing = evaluate(&self.task, &self.machine, &plan, &trips, log.file, &before)?;
        let mut document = reprobing.document(&self.task, &self.machine.settings.name, self.history.next());
        let last = self.history.entries.iter().rev().find_map(|entry| entry.parts);
        if let Some(since) = log.parts.zip(last).map(|(now, before)| now - before) {
            let every = self.task.every_parts;
            if since > u64::from(every) {
                document.notes.push(format!("{since} parts since the last re-probing, every_parts is {every}"));
            }
        }
        let mut entry = self.entry(log, &plan, &reprobing, EntryKind::Unchanged);
        entry.totals = totals.clone();
        let changes = changes(&self.task, &reprobing, &self.machine, self.source.as_ref(), &self.name)?;
        if document.refused > 0 {
            return Ok(EvaluatedLog { reprobing, document, entry, files: FileChanges::new(), changes: changes.notes });
        }
        document.written = changes.decisions;
        let named = changes.files.into_iter();
        let files: FileChanges =
            named.map(|(name, text)| (name.to_string_lossy().into_owned(), Some(text.into()))).collect();
        entry.totals = reprobing.totals(&self.task);
        entry.files = self.changed(&files);
        entry.tables[1] = tables(&self.with(&files));
        if !files.is_empty() {
            entry.kind = EntryKind::Update;
        }
        Ok(EvaluatedLog { reprobing, document, entry, files, changes: changes.notes })
    }
}
