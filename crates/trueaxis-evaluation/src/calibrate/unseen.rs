//! Words for what the placements of a plate of unknown places leave free.

use super::artefact::Artefact;
use super::grid::Grid;
use super::observed::Observed;
use super::place::Place;
use super::terms::Term;
use trueaxis::machine::Axis;
use trueaxis_tables::text::counted;

/// Unknowns that no touch sees, with their shares.
type Combinations = [Vec<(usize, f64)>];

/// Found and needed: the rank, the terms in the combinations that no placement shows, and what would show them.
pub(super) fn words(plate: &Artefact, grid: &Grid, observed: &Observed, free: &Combinations) -> (String, String) {
    let count = observed.names.len();
    let rank = count - free.len().min(count);
    let seen = |index: usize| free.iter().flatten().any(|(part, _)| *part == index);
    let mut names: Vec<String> = Vec::new();
    for (index, term) in observed.terms.terms.iter().enumerate().filter(|(index, _)| seen(*index)) {
        let name = short(*term, &observed.names[index]);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let is_free =
        |is: fn(&Term) -> bool| observed.terms.terms.iter().enumerate().any(|(index, term)| seen(index) && is(term));
    let mut lacking: Vec<[&str; 2]> = Vec::new();
    if !plate.places.iter().all(|place| turned(place, &plate.places)) {
        lacking.push([
            "without the turned placement squareness and the ratio of the scales cannot be told from the plate's own skew and \
             proportions",
            "a [[plate.placement]] with turn_deg = 90",
        ]);
    }
    let shaped = is_free(|term| matches!(term, Term::Curve { degree: 2.., .. }));
    if shaped && !plate.places.iter().all(|place| moved(grid, place, &plate.places)) {
        lacking.push([
            "without a moved placement a shape that repeats itself turned cannot be told from the places of the plate's own \
             balls or holes",
            "a [[plate.placement]] with moved = [1, 0], or [0, 1]",
        ]);
    }
    if grid.length_mm.is_none() {
        lacking
            .push(["without a known length one scale stays free", "[plate.length] between two of its balls or holes"]);
    }
    if lacking.is_empty() {
        lacking.push(["the placements are too few", "more of them, turned or moved"]);
    }
    let places = counted(plate.places.len(), "placement");
    let terms = if names.is_empty() { "the plate's own places".into() } else { names.join(", ") };
    let [reasons, needed] = [("; ", 0), (", ", 1)]
        .map(|(with, which)| lacking.iter().map(|lack| lack[which]).collect::<Vec<_>>().join(with));
    (format!("a plate in {places}: rank {rank} of {count} unknowns, free are {terms}: {reasons}"), needed)
}

/// A curve by its error's name, whatever its degree.
fn short(term: Term, name: &str) -> String {
    match term {
        Term::Curve { axis, component, degree: 2.. } => {
            format!("E{}{}", [Axis::X, Axis::Y, Axis::Z][usize::from(component) % 3].letter(), axis.letter())
        }
        _ => name.to_owned(),
    }
}

/// Whether one of the placements in the same plane is turned by a quarter from a placement.
fn turned(place: &Place, all: &[Place]) -> bool {
    all.iter().any(|other| other.normal == place.normal && (other.turn + place.turn) % 2 == 1)
}

/// Whether placements in the same plane, turned alike, lie apart.
fn moved(grid: &Grid, place: &Place, all: &[Place]) -> bool {
    let plane = || all.iter().filter(|other| other.normal == place.normal);
    plane().any(|one| plane().any(|other| one.turn == other.turn && grid.apart(one, other)))
}
