//! Checks common to all records: values that the instrument can give, channels that are alive, no missing rows.

use crate::rows::Rows;
use anyhow::Result;

/// Consecutive identical readings that no working sensor gives while others differ.
const LEAST: usize = 8;

/// Travel of a displacement probe, of a ballbar's scale or a nest, µm either way: a value beyond it is not a reading.
pub const PROBE_UM: f64 = 2000.0;
/// A displacement over a whole record below the resolution of any shop instrument, µm: the column has another unit.
pub const FINEST_UM: f64 = 0.05;

/// Refuses a displacement that no probe can read: more than [`PROBE_UM`] from its first value, µm.
///
/// # Errors
/// The value with its line.
pub fn displacement<const C: usize>(
    rows: &Rows<'_, C>,
    line: u32,
    column: &str,
    [value_um, began_um]: [f64; 2],
) -> Result<()> {
    let moved = value_um - began_um;
    if moved.abs() <= PROBE_UM {
        return Ok(());
    }
    let from = if began_um == 0.0 { String::new() } else { format!(", {moved} from its first reading") };
    let needed = format!("at most {PROBE_UM} um either way, the travel of a probe");
    Err(rows.error(line, column, format!("{value_um}{from}"), needed))
}

/// Requirement named in a refusal if the angles are in [`radians`].
pub const DEGREES: &str = "angles in degrees: these go over one turn in radians";

/// The index of the largest of angles that cover one turn in radians: from the least to the largest, or with one more step, 2π
/// to a thousandth. No test in degrees stops there.
pub fn radians(angles: &[f64]) -> Option<usize> {
    let mut sorted = angles.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup_by(|next, kept| *next - *kept < 1e-6);
    let (Some(least), Some(most)) = (sorted.first(), sorted.last()) else { return None };
    let span = most - least;
    let step = span / (sorted.len().max(2) - 1) as f64;
    let turn = |span: f64| (span - std::f64::consts::TAU).abs() < 1e-3;
    if sorted.len() < LEAST || !(turn(span) || turn(span + step)) {
        return None;
    }
    angles.iter().position(|angle| angle == most)
}

/// A stretch of one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stuck {
    /// Index of the first reading.
    pub from: usize,
    /// Number of readings.
    pub count: usize,
    /// The value.
    pub value: f64,
}

/// The longest stretch of one value, if it is long enough to be a dead sensor: eight readings and a fifth of all. A record of
/// one value alone is accepted: nothing in it moved.
pub fn longest(values: &[f64]) -> Option<Stuck> {
    let mut from = 0;
    let mut best: Option<Stuck> = None;
    for stretch in values.chunk_by(|one, other| one == other) {
        let (count, value) = (stretch.len(), stretch[0]);
        if best.is_none_or(|best| count > best.count) {
            best = Some(Stuck { from, count, value });
        }
        from += count;
    }
    best.filter(|best| best.count >= LEAST && 5 * best.count >= values.len() && best.count < values.len())
}

/// A channel of a record.
#[derive(Clone, Copy, Debug)]
pub struct Channel<'v> {
    /// Column of the channel.
    pub name: &'static str,
    /// Values of the channel.
    pub values: &'v [f64],
    /// Factor from a value to the column's unit.
    pub scale: f64,
}

/// The first channel that stops changing: [`longest`], while another channel takes many values or the rest of the channel
/// itself does. Neither applies to a coarse sensor or a machine at rest.
pub fn dead<'c, 'v>(channels: &'c [Channel<'v>]) -> Option<(&'c Channel<'v>, Stuck)> {
    channels.iter().enumerate().find_map(|(own, channel)| {
        let stuck = longest(channel.values)?;
        let (before, behind) = (&channel.values[..stuck.from], &channel.values[stuck.from + stuck.count..]);
        let others = channels.iter().enumerate().filter(|(other, _)| *other != own);
        let varies_while_stuck = |values: &[f64]| values.get(stuck.from..stuck.from + stuck.count).is_some_and(many);
        let died = others.map(|(_, other)| other.values).any(varies_while_stuck) || many(&[before, behind].concat());
        died.then_some((channel, stuck))
    })
}

/// Refuses a channel that is [`dead`].
///
/// # Errors
/// The first such channel, at the line of its first stuck reading.
pub fn alive<const C: usize>(rows: &Rows<'_, C>, lines: &[u32], channels: &[Channel<'_>]) -> Result<()> {
    dead(channels).map_or(Ok(()), |(channel, stuck)| Err(stuck.error(rows, lines, channel.name, channel.scale)))
}

/// The first reading from which a position does not change although its command does: the [`longest`] stretch of one value, if
/// the command takes many values over it. An axis at rest has a command at rest.
pub fn left_behind(command: &[f64], reading: &[f64]) -> Option<Stuck> {
    longest(reading).filter(|stuck| command.get(stuck.from..stuck.from + stuck.count).is_some_and(many))
}

/// Minimum travel of a command over which a position that follows it must change, mm: friction and play hold an axis for less.
const HELD_MM: f64 = 0.02;
/// [`HELD_MM`] in steps of the position's own resolution: its least change from one row to the next.
const HELD_STEPS: f64 = 4.0;
/// A smaller change of the command from one row to the next is rounding, mm.
const ROUNDED_MM: f64 = 1e-9;

/// A position and its command, row after row, in constant memory: [`left_behind`] for a command that may rest for most of the
/// record, as for an axis that waits while others move.
#[derive(Clone, Debug)]
pub struct Followed {
    last: Option<[f64; 2]>,
    /// Number of rows in which the command moves.
    moving: usize,
    /// Least change of the reading; infinite before the first change.
    resolution: f64,
    stretch: Stretch,
    widest: Stretch,
}

/// A stretch of readings of one value while the command moves.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    stuck: Stuck,
    /// Smallest and largest command.
    command: [f64; 2],
}

impl Default for Stretch {
    fn default() -> Self {
        Self { stuck: Stuck { from: 0, count: 0, value: f64::NAN }, command: [f64::INFINITY, f64::NEG_INFINITY] }
    }
}

impl Stretch {
    fn way(&self) -> f64 {
        self.command[1] - self.command[0]
    }
}

impl Default for Followed {
    fn default() -> Self {
        let [stretch, widest] = [Stretch::default(); 2];
        Self { last: None, moving: 0, resolution: f64::INFINITY, stretch, widest }
    }
}

impl Followed {
    /// Adds a row: its number or line, the command and the reading, mm.
    pub fn put(&mut self, row: usize, command: f64, reading: f64) {
        let before = self.last.replace([command, reading]);
        let step = before.map_or(f64::INFINITY, |[_, read]| (reading - read).abs());
        if step != 0.0 {
            self.resolution = self.resolution.min(step);
            self.stretch = Stretch { stuck: Stuck { from: row, count: 0, value: reading }, ..Stretch::default() };
        }
        if before.is_none_or(|[before, _]| (command - before).abs() <= ROUNDED_MM) {
            return;
        }
        self.moving += 1;
        self.stretch.stuck.count += 1;
        let [low, high] = self.stretch.command;
        self.stretch.command = [low.min(command), high.max(command)];
        if self.stretch.stuck.count >= LEAST && self.stretch.way() >= self.widest.way() {
            self.widest = self.stretch;
        }
    }

    /// Where the position did not change, and the travel of its command there, mm: eight readings and a fifth of those over
    /// which the command moved, over at least 0.02 mm and four steps of its resolution.
    pub fn stuck(&self) -> Option<(Stuck, f64)> {
        let (stuck, way) = (self.widest.stuck, self.widest.way());
        let is_long = stuck.count >= LEAST && 5 * stuck.count >= self.moving;
        let steps = if self.resolution.is_finite() { HELD_STEPS * self.resolution } else { 0.0 };
        (is_long && way > HELD_MM.max(steps)).then_some((stuck, way))
    }
}

/// Whether more than half of these values are distinct.
fn many(values: &[f64]) -> bool {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    2 * sorted.len() > values.len()
}

/// A row that is missing from one part of a record and present in a similar part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Missing {
    /// Index of the part.
    pub part: usize,
    /// Index of a part that has the row, and of the row in it.
    pub like: [usize; 2],
    /// Rows that the part has, and rows of its plan.
    pub rows: [usize; 2],
}

/// The first part of a record with fewer rows than its plan. The plan has as many rows as the longest part, if at least half
/// of the parts have that many. `same` compares two rows as points of the plan. Parts that differ but have equally many rows
/// have separate plans.
pub fn missing<T>(parts: &[Vec<T>], same: impl Fn(&T, &T) -> bool) -> Option<Missing> {
    let plan = parts
        .iter()
        .map(Vec::len)
        .max()
        .filter(|most| 2 * parts.iter().filter(|part| part.len() == *most).count() >= parts.len())?;
    let has = |part: &[T], row: &T| part.iter().any(|own| same(own, row));
    parts.iter().enumerate().filter(|(_, own)| own.len() < plan).find_map(|(part, own)| {
        let whole = parts.iter().enumerate().filter(|(_, like)| like.len() == plan);
        whole
            .filter_map(|(like, rows)| Some([like, rows.iter().position(|row| !has(own, row))?]))
            .next()
            .map(|like| Missing { part, like, rows: [own.len(), plan] })
    })
}

impl Stuck {
    /// The refusal, at the line of the first reading; `scale` from the value to the column's unit.
    pub fn error<const C: usize>(&self, rows: &Rows<'_, C>, lines: &[u32], column: &str, scale: f64) -> anyhow::Error {
        let line = lines.get(self.from).copied().unwrap_or(1);
        // The value as written in the file: nine decimals undo the change of unit.
        let value = (1e9 * scale * self.value).round() / 1e9;
        let found = format!("{value} for {} readings in a row", self.count);
        rows.error(line, column, found, "a sensor whose readings change")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_in_a_record_that_moves_is_found_and_a_record_of_one_value_is_not() {
        let mut values: Vec<f64> = (0..20).map(f64::from).collect();
        assert_eq!(longest(&values), None);
        values[5..17].fill(3.5);
        assert_eq!(longest(&values), Some(Stuck { from: 5, count: 12, value: 3.5 }));
        assert_eq!(longest(&[0.0; 30]), None);
        assert_eq!(longest(&[]), None);
    }

    #[test]
    fn a_row_that_its_like_have_is_missed_and_another_plan_is_none() {
        let same = |one: &i32, other: &i32| one == other;
        let parts = |third: &[i32]| vec![vec![1, 2, 3], vec![1, 2, 3], third.to_vec(), vec![1, 2, 3]];
        assert_eq!(missing(&parts(&[1, 2, 3]), same), None);
        assert_eq!(missing(&parts(&[1, 3]), same), Some(Missing { part: 2, like: [0, 1], rows: [2, 3] }));
        assert_eq!(missing(&parts(&[2, 3]), same), Some(Missing { part: 2, like: [0, 0], rows: [2, 3] }));
        assert_eq!(missing(&parts(&[7, 8, 9]), same), None);
        assert_eq!(missing(&[vec![1, 2, 3], vec![1], vec![1, 2]], same), None, "no two are alike");
        assert_eq!(missing(&[vec![1, 2], vec![1]], same), Some(Missing { part: 1, like: [0, 1], rows: [1, 2] }));
    }

    #[test]
    fn a_turn_in_radians_is_none_in_degrees() {
        let turn = |count: u32, whole: f64| (0..count).map(|k| whole / 72.0 * f64::from(k)).collect::<Vec<_>>();
        assert_eq!(radians(&turn(72, std::f64::consts::TAU)), Some(71), "a step before the end");
        assert_eq!(radians(&turn(73, std::f64::consts::TAU)), Some(72));
        assert_eq!(radians(&turn(73, 360.0)), None);
        assert_eq!(radians(&turn(73, 6.3)), None);
        assert_eq!(radians(&[0.0, std::f64::consts::TAU]), None);
    }

    #[test]
    fn a_reading_that_its_command_leaves_behind_is_stuck_and_one_at_rest_is_not() {
        let command: Vec<f64> = (0..40).map(|k| if k < 12 { 0.0 } else { f64::from(k) }).collect();
        assert_eq!(left_behind(&command, &command), None);
        let mut reading = command.clone();
        reading[25..].fill(25.0);
        assert_eq!(left_behind(&command, &reading), Some(Stuck { from: 25, count: 15, value: 25.0 }));
    }

    #[test]
    fn a_position_that_its_command_leaves_behind_is_stuck_and_one_that_rests_or_is_coarse_is_not() {
        let stuck = |rows: &[[f64; 2]]| {
            let mut followed = Followed::default();
            rows.iter().enumerate().for_each(|(row, [command, reading])| followed.put(row, *command, *reading));
            followed.stuck()
        };
        let along = |of: &dyn Fn(f64) -> [f64; 2]| stuck(&(0..400).map(|k| of(f64::from(k))).collect::<Vec<_>>());
        // A square: each axis rests on two of its sides.
        let square = |k: f64| (0.1 * k).min(10.0) - (0.1 * (k - 200.0)).clamp(0.0, 10.0);
        assert_eq!(along(&|k| [square(k), square(k) + 0.003]), None);
        let died = along(&|k| [square(k), square(k.min(50.0))]).unwrap();
        assert_eq!(died.0, Stuck { from: 50, count: 151, value: 5.0 });
        assert!((died.1 - 10.0).abs() < 1e-9, "{died:?}");
        // A dwell of both, an inclined line read in whole micrometres, a stepper's steps of 5 µm, play of 0.015 mm.
        assert_eq!(along(&|k| [0.1 * k.clamp(100.0, 150.0), 0.1 * k.clamp(100.0, 150.0)]), None);
        assert_eq!(along(&|k| [1e-5 * k, (1e-2 * k).round() * 1e-3]), None);
        assert_eq!(along(&|k| [1e-4 * k, (2e-2 * k).round() * 5e-3]), None);
        assert_eq!(along(&|k| [4e-5 * k, (4e-5 * k - 0.015).max(0.0)]), None);
        // Circles with an axis that dies on the second one; one reading occurs twice during the rapid before them.
        let circles = |k: f64| 20.0 * (0.1 * k).sin() - if k < 3.0 { 900.0 } else { 0.0 };
        let died = along(&|k| [circles(k), circles(if k < 4.0 { k.min(2.0) } else { k.min(70.0) })]);
        assert_eq!(died.map(|found| (found.0.from, found.0.count)), Some((70, 330)));
        // An axis whose reading never changes, and one of a coarse record that comes free at its end.
        assert_eq!(along(&|k| [0.1 * k, 3.0]).map(|found| found.0.count), Some(399));
        assert_eq!(along(&|k| [k, if k < 390.0 { 0.0 } else { k }]).map(|found| found.0.count), Some(389));
    }
}
