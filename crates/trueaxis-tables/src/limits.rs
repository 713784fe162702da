//! Limits of the corrections: what a machine's stated errors need, and the keys to set when files change.

use crate::Machine;
use crate::document::{as_before, section, set};
use crate::error::FileError;
use crate::files::{Edit, Memory, Source};
use crate::origin::Origin;
use crate::rates::drive_rate;
use crate::read::refused::least_hysteresis;
use crate::text::{counted, micro};
use std::path::{Path, PathBuf};
use toml_edit::{DocumentMut, Value};
use trueaxis::check;
use trueaxis::error::{ConfigError, Figure};
use trueaxis::machine::{AXES, Axis, AxisSettings, MachineSettings, carries_workpiece};
use trueaxis::range;

/// Factor by which a limit is set above the need, for future growth and lost motion.
const ROOM: f64 = 1.2;

/// A limit of an axis' correction and the value that the machine's errors require, in the unit of its key.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Need {
    axis: Axis,
    key: &'static str,
    needed: f64,
    limit: f64,
    most: f64,
}

impl Need {
    fn exceeds(&self) -> bool {
        self.needed > self.limit * (1.0 + 1e-9)
    }

    /// New value of the key: two digits, rounded up.
    fn set_to(&self) -> f64 {
        two_digits_up(ROOM * self.needed).min(self.most)
    }

    fn is_set(&self) -> String {
        let (name, value) = (self.name(), self.set_to());
        let most = if value < self.needed { ", the maximum" } else { "" };
        let (needed, limit) = (four_digits(self.needed), four_digits(self.limit));
        format!("{name} set to {value}{most}, as the corrections reach {needed}; the default is {limit}")
    }

    fn stays(&self) -> String {
        let (needed, limit, value) = (four_digits(self.needed), four_digits(self.limit), self.set_to());
        let name = self.name();
        format!("{name} stays at {limit}, as it is stated, though the corrections reach {needed}: raise it to {value}")
    }

    /// Name of the limit, like `limits.magnitude_um of axis Z`.
    fn name(&self) -> String {
        format!("limits.{} of axis {}", self.key, self.axis.letter())
    }
}

/// The smallest two-digit number that is not below `value`.
fn two_digits_up(value: f64) -> f64 {
    let power = 10f64.powi(value.log10().floor() as i32 - 1);
    // A two-digit decimal stays unchanged in spite of rounding.
    let digits = (value / power * (1.0 - 1e-9)).ceil();
    if power < 1.0 { digits / (1.0 / power).round() } else { digits * power.round() }
}

/// All limits of all drives: magnitude over the reach, slope and acceleration with every axis at top feed.
fn needs(machine: &Machine) -> Vec<Need> {
    let grids = check::GridBounds::of(&machine.grids());
    let mut needs = Vec::new();
    for drive in &machine.settings.axes {
        let axis = drive.axis;
        let own = check::reach(drive, machine.rows(axis));
        let (least, most) = check::error_range(&machine.settings, |axis| machine.rows(axis), &grids, drive, own);
        let [magnitude, slope, acceleration] = keys(axis);
        let need = |key, needed, limit, most| Need { axis, key, needed, limit, most };
        let largest = least.abs().max(most.abs());
        needs.push(need(
            magnitude,
            micro(axis, largest),
            micro(axis, drive.limits.magnitude),
            micro(axis, range::MAGNITUDE.of(axis).most),
        ));
        let Some(rate) = drive_rate(machine, drive) else { continue };
        needs.push(need(slope, rate.rate, rate.limit, range::SLOPE.of(axis).most));
        if let Some(bent) = rate.acceleration {
            needs.push(need(acceleration, bent, rate.acceleration_limit, range::ACCELERATION.of(axis).most));
        }
    }
    needs
}

/// Keys of the limits of an axis.
fn keys(axis: Axis) -> [&'static str; 3] {
    if axis.is_rotary() {
        ["magnitude_urad", "slope_deg_per_s", "acceleration_deg_per_s2"]
    } else {
        ["magnitude_um", "slope_mm_per_s", "acceleration_mm_per_s2"]
    }
}

/// Reduction of wanted corrections by the magnitude limits, axis by axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clipped([Option<Cut>; AXES]);

/// Reduction of one axis' corrections, mm (deg).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    limit: f64,
    /// Number of corrections beyond the limit.
    count: u64,
    /// Largest of them, and the position that wants it.
    largest: f64,
    at: [f64; AXES],
}

impl Clipped {
    /// Adds the correction wanted at a position; mm and degrees, lists in the order X, Y, Z, A, B, C.
    pub fn add(&mut self, settings: &MachineSettings, at: &[f64; AXES], wanted: &[f64; AXES]) {
        for own in &settings.axes {
            let (limit, wanted) = (own.limits.magnitude, wanted[own.axis.index()].abs());
            if wanted > limit * (1.0 + 1e-9) {
                let cut = self.0[own.axis.index()].get_or_insert(Cut { limit, count: 0, largest: 0.0, at: *at });
                cut.count += 1;
                if wanted > cut.largest {
                    (cut.largest, cut.at) = (wanted, *at);
                }
            }
        }
    }

    /// The axes whose corrections are reduced.
    pub fn axes(&self) -> impl Iterator<Item = Axis> + '_ {
        Axis::ALL.into_iter().zip(&self.0).filter(|(_, cut)| cut.is_some()).map(|(axis, _)| axis)
    }

    /// One sentence for each of these axes; `what` names an added position, for example "cycle".
    pub fn notes(&self, settings: &MachineSettings, what: &str) -> Vec<String> {
        let note = |(axis, cut): (Axis, &Option<Cut>)| {
            let cut = cut.as_ref()?;
            let (unit, micro) = (if axis.is_rotary() { "µrad" } else { "µm" }, micro(axis, 1.0));
            let [key, ..] = keys(axis);
            let letter = axis.letter();
            let at: Vec<String> = settings
                .axes
                .iter()
                .map(|own| format!("{}{}", own.axis.letter(), (cut.at[own.axis.index()] * 1e3).round() / 1e3))
                .collect();
            Some(format!(
                "axis {letter}: the magnitude limit removes up to {} {unit} of the correction in {}, most at {}; [axis.{letter}.limits] \
                 {key} is {}, {} would pass all of it",
                four_digits((cut.largest - cut.limit) * micro),
                counted(usize::try_from(cut.count).unwrap_or(usize::MAX), what),
                at.join(" "),
                four_digits(cut.limit * micro),
                two_digits_up(cut.largest * micro)
            ))
        };
        Axis::ALL.into_iter().zip(&self.0).filter_map(note).collect()
    }
}

/// Text of a changed `machine.toml` with the hysteresis and limits that the change needs, if the machine is then accepted;
/// appends remarks to `notes`. `changed` are the other files that change, `old_text` is the text before.
///
/// # Errors
/// A changed machine that the controller would refuse.
pub(crate) fn widened(
    document: &DocumentMut,
    old_text: &str,
    changed: &[(PathBuf, String)],
    (files, name): (&dyn Source, &Path),
    before: Option<&Machine>,
    notes: &mut Vec<String>,
) -> Result<String, FileError> {
    let with = |text: &str| {
        let all = changed.iter().map(|(name, text)| (name.as_path(), text.as_str())).chain([(name, text)]);
        Edit { changed: Memory::new(all), beneath: files }
    };
    let read = |text: &str| Machine::read_from(&with(text), name, &mut |_| {});
    let (mut document, origin) = (document.clone(), Origin::new(&files.path(name)));
    set_hysteresis(&mut document, |text| Machine::narrow_hysteresis(&with(text), name), &origin, notes)?;
    let text = as_before(document.to_string(), old_text);
    let after = read(&text)?;
    let (mut wide, mut said) = (document, Vec::new());
    widen(&mut wide, before, &after, &origin, &mut said)?;
    let wide = as_before(wide.to_string(), old_text);
    if wide == text {
        notes.append(&mut said);
        return Ok(text);
    }
    match read(&wide) {
        Ok(_) => {
            notes.append(&mut said);
            Ok(wide)
        }
        Err(error) => {
            notes.extend(check_limits(&after));
            notes.push(format!("limits are unchanged, as with higher ones {error}"));
            Ok(text)
        }
    }
}

/// Raises limits at their defaults in a machine that will be written whole, if the machine is then accepted; returns one
/// sentence on each.
pub fn raise(machine: &mut Machine) -> Vec<String> {
    let (mut raised, mut notes) = (machine.clone(), Vec::new());
    for need in needs(machine).into_iter().filter(Need::exceeds) {
        let carries = carries_workpiece(&machine.settings.chain, need.axis);
        let default = AxisSettings::with_defaults(need.axis, carries).limits;
        let Some(own) = raised.settings.axes.iter_mut().find(|own| own.axis == need.axis) else { continue };
        let [magnitude, slope, _] = keys(need.axis);
        let (limit, default) = match need.key {
            key if key == magnitude => (&mut own.limits.magnitude, default.magnitude),
            key if key == slope => (&mut own.limits.slope_per_s, default.slope_per_s),
            _ => (&mut own.limits.acceleration_per_s2, default.acceleration_per_s2),
        };
        if *limit != default {
            notes.push(need.stays());
            continue;
        }
        notes.push(need.is_set());
        let before = std::mem::replace(limit, need.set_to() * (default / need.limit));
        if need.key == magnitude && own.joint == [own.travel[0] - before, own.travel[1] + before] {
            own.joint = [own.travel[0] - own.limits.magnitude, own.travel[1] + own.limits.magnitude];
        }
    }
    match check::machine(&raised.settings, |axis| raised.rows(axis), &raised.grids()) {
        Ok(_) => {
            *machine = raised;
            notes
        }
        Err(_) => check_limits(machine),
    }
}

/// Reductions by limits, one sentence each.
fn check_limits(machine: &Machine) -> Vec<String> {
    let beyond = needs(machine).into_iter().filter(Need::exceeds);
    beyond
        .map(|need| {
            format!(
                "{} is {}, the corrections reach {}",
                need.name(),
                four_digits(need.limit),
                four_digits(need.needed)
            )
        })
        .collect()
}

/// Sets the hysteresis, if it is at its default, of axes whose reversals would undo themselves: both columns of a table cross,
/// for example because of an instrument's scatter.
fn set_hysteresis(
    document: &mut DocumentMut,
    narrow: impl Fn(&str) -> Option<ConfigError>,
    origin: &Origin,
    notes: &mut Vec<String>,
) -> Result<(), FileError> {
    for _ in 0..AXES {
        let Some(error) = narrow(&document.to_string()) else { break };
        let Some(((axis, key), least)) = error.axis.zip(error.key()).zip(least_hysteresis(&error)) else { break };
        let (full, most) = (key.to_string(), key.in_its_unit(range::HYSTERESIS.of(axis).most));
        let name = full.rsplit('.').next().unwrap_or_default();
        if is_stated(document, axis, &[name]) || least > most {
            break;
        }
        set(section(document, axis, origin)?, name, Value::from(least));
        let default = Figure(key.in_its_unit(error.found));
        notes.push(format!(
            "{name} of axis {} set to {least}, as it has to be {}; the default is {default}. A shorter reversal keeps the errors \
             of the previous direction",
            axis.letter(),
            error.needed
        ));
    }
    Ok(())
}

/// Sets the limits that a change of a machine's files needs, if they are at their defaults. A stated limit stays, and a note
/// says how much it takes away.
fn widen(
    document: &mut DocumentMut,
    before: Option<&Machine>,
    after: &Machine,
    origin: &Origin,
    notes: &mut Vec<String>,
) -> Result<(), FileError> {
    let old_needs = before.map(needs).unwrap_or_default();
    for need in needs(after).into_iter().filter(Need::exceeds) {
        let old = old_needs.iter().find(|old| (old.axis, old.key) == (need.axis, need.key));
        // A need that existed before this change is not reported again.
        if old.is_some_and(|old| need.needed <= old.needed * (1.0 + 1e-9)) {
            continue;
        }
        if is_stated(document, need.axis, &["limits", need.key]) {
            notes.push(need.stays());
            continue;
        }
        let section = section(document, need.axis, origin)?;
        let limits = section.entry("limits").or_insert_with(toml_edit::table).as_table_like_mut();
        let no_section = || origin.whole("limits that are not a section", "[axis.….limits]");
        set(limits.ok_or_else(no_section)?, need.key, Value::from(need.set_to()));
        notes.push(need.is_set());
    }
    Ok(())
}

/// Whether the file states this key of an axis.
fn is_stated(document: &DocumentMut, axis: Axis, key: &[&str]) -> bool {
    let letter = axis.letter().to_string();
    let mut path = ["axis", &letter].into_iter().chain(key.iter().copied());
    let found = path.try_fold(document.as_item(), |item, key| item.get(key));
    found.is_some_and(|item| !item.is_none())
}

/// Rounds a positive number to four digits.
fn four_digits(value: f64) -> f64 {
    let scale = 10f64.powf(3.0 - value.log10().floor());
    (value * scale).round() / scale
}
