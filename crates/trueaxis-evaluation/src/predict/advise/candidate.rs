//! Measurements that the instruments allow on a machine, about a part.

use super::instrument::{Instrument, InstrumentKind, Touching};
use super::sights::Sights;
use crate::calibrate::Task;
use std::fmt::Write as _;
use trueaxis::machine::Axis;
use trueaxis_tables::Machine;

/// Room beside an artefact for the tip, its approach and its way around, mm.
const ROOM: f64 = 15.0;
/// Height above an artefact at which the probe travels, mm.
const ABOVE: f64 = 60.0;
/// The two other sides of a gauge block, mm.
const SECTION: [f64; 2] = [35.0, 9.0];

/// A measurement.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) name: String,
    /// Time, without that of a probing program.
    pub(super) minutes: f64,
    pub(super) way: Way,
}

/// How it is done.
#[derive(Clone, Debug)]
pub(super) enum Way {
    /// A place of an artefact of a task: an artefact at several places is one standard, with one size.
    Artefact(Placed),
    /// Readings of an instrument.
    Read(Sights),
    /// A task of the owner's.
    Task(Box<Task>),
}

/// Sections of a task.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    /// `[[artefact]]`.
    pub(super) artefact: String,
    /// `[[artefact.place]]`.
    pub(super) place: String,
}

/// The sections of places: of each artefact once, with its places.
pub(super) fn grouped<'a>(chosen: impl Iterator<Item = &'a Candidate>) -> Vec<String> {
    let mut artefacts: Vec<(&str, String)> = Vec::new();
    for of in chosen {
        let Way::Artefact(Placed { artefact, place }) = &of.way else { continue };
        match artefacts.iter_mut().find(|(own, _)| own == artefact) {
            Some((_, places)) => places.push_str(place),
            None => artefacts.push((artefact, place.clone())),
        }
    }
    artefacts.into_iter().map(|(artefact, places)| format!("{artefact}{places}")).collect()
}

/// Where the part is: middle of its points, and of the machine's axes.
pub(super) struct Shop<'m> {
    pub(super) machine: &'m Machine,
    /// X, Y, Z of the machine in the middle of the part.
    pub(super) middle_mm: [f64; 3],
    pub(super) probe: &'m Touching,
    /// Largest scatter of an axis' approach, mm.
    pub(super) scatter_mm: f64,
}

impl Shop<'_> {
    /// A place about the part's middle that leaves this room below and above along each axis.
    fn place(&self, of: &Instrument, room: [[f64; 2]; 3]) -> [f64; 3] {
        of.at_mm.unwrap_or_else(|| {
            std::array::from_fn(|k| {
                let [low, high] =
                    self.machine.settings.axis([Axis::X, Axis::Y, Axis::Z][k]).map_or([0.0; 2], |own| own.travel);
                let [low, high] = [low + room[k][0], high - room[k][1]];
                let q = if low <= high { self.middle_mm[k].clamp(low, high) } else { 0.5 * (low + high) };
                (q * 1e3).round() / 1e3
            })
        })
    }

    /// The measurements of an instrument; a task needs its own file.
    pub(super) fn candidates(&self, of: &Instrument) -> Vec<Candidate> {
        let put = |name: String, way| Candidate { name, minutes: of.minutes, way };
        let each = |way: &dyn Fn(Axis) -> (String, Way)| -> Vec<Candidate> {
            of.axes.iter().map(|axis| way(*axis)).map(|(name, way)| put(name, way)).collect()
        };
        match of.kind {
            InstrumentKind::Task => Vec::new(),
            InstrumentKind::Ball | InstrumentKind::Ring => {
                let kind = if of.kind == InstrumentKind::Ball { "ball" } else { "ring" };
                vec![put(of.name.clone(), Way::Artefact(self.round(of, kind)))]
            }
            InstrumentKind::GaugeBlock => each(&|axis| {
                let name = format!("{} along {}", of.name, axis.letter());
                (name, Way::Artefact(self.block(of, axis)))
            }),
            InstrumentKind::Square => each(&|axis| {
                let name = format!("{} {}", of.name, plane(axis));
                (name, Way::Artefact(self.square(of, axis)))
            }),
            InstrumentKind::Ballbar => each(&|axis| {
                let (low, r) = (Sights::below(axis) * of.size_mm, of.size_mm);
                let mut room: [[f64; 2]; 3] =
                    std::array::from_fn(|k| if k == axis.index() { [0.0; 2] } else { [r; 2] });
                room[2][0] = if axis == Axis::Z { 0.0 } else { low };
                let sights = Sights::circle(self.machine, of, axis, self.place(of, room), self.scatter_mm);
                (format!("{} {}", of.name, plane(axis)), Way::Read(sights))
            }),
            InstrumentKind::Laser => each(&|axis| {
                let at = self.place(of, [[0.0; 2]; 3]);
                let sights = Sights::line(self.machine, of, axis, at, self.scatter_mm);
                (format!("{} along {}", of.name, axis.letter()), Way::Read(sights))
            }),
        }
    }

    fn round(&self, of: &Instrument, kind: &str) -> Placed {
        let r = 0.5 * of.size_mm + ROOM;
        let at = self.place(of, [[r; 2], [r; 2], [r, ABOVE]]);
        let (diameter, um) = (of.size_mm, 1e3 * of.uncertainty);
        let mut artefact = head(&of.name, kind);
        let _ = write!(artefact, "diameter_mm = {diameter}\nuncertainty_um = {um}\n");
        Placed { artefact, place: place(at) }
    }

    fn block(&self, of: &Instrument, axis: Axis) -> Placed {
        let [wide, high] = SECTION;
        let half = |k: usize| 0.5 * if k == axis.index() { of.size_mm } else { wide } + ROOM;
        let at = self.place(of, [[half(0); 2], [half(1); 2], [high + ROOM, ABOVE]]);
        let (length, um) = (of.size_mm, 1e3 * of.uncertainty);
        let mut artefact = head(&of.name, "gauge block");
        let _ = write!(artefact, "length_mm = {length}\nsection_mm = [{wide}, {high}]\nuncertainty_um = {um}\n");
        Placed { artefact, place: format!("{}along = \"{}\"\n", place(at), axis.letter()) }
    }

    /// Lying, or upright with its first arm along the plane's horizontal axis and the second down from the corner.
    fn square(&self, of: &Instrument, normal: Axis) -> Placed {
        let arm = of.size_mm + ROOM;
        let along = if normal == Axis::X { Axis::Y } else { Axis::X };
        // The arms go up in X and Y, down in Z.
        let room = |k: usize| match (k == normal.index(), k == Axis::Z.index()) {
            (true, _) => [ROOM, ABOVE],
            (_, true) => [arm, ABOVE],
            _ => [ROOM, arm],
        };
        let at = self.place(of, [room(0), room(1), room(2)]);
        let (arm, urad) = (of.size_mm, 1e6 * of.uncertainty);
        let mut artefact = head(&of.name, "square");
        let _ = write!(artefact, "arms_mm = [{arm}, {arm}]\nuncertainty_urad = {urad}\n");
        let place = format!("{}normal = \"{}\"\nalong = \"{}\"\n", place(at), normal.letter(), along.letter());
        Placed { artefact, place }
    }
}

/// The plane across an axis.
fn plane(normal: Axis) -> &'static str {
    match normal {
        Axis::X => "YZ",
        Axis::Y => "ZX",
        _ => "XY",
    }
}

fn head(name: &str, kind: &str) -> String {
    format!("\n[[artefact]]\nname = {}\nkind = \"{kind}\"\n", toml::Value::from(name))
}

fn place([x, y, z]: [f64; 3]) -> String {
    format!("[[artefact.place]]\nat_mm = [{x:?}, {y:?}, {z:?}]\n")
}
