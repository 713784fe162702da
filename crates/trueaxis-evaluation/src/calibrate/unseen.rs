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
    let shaped = is_free(|term| matches!(term, Term::Curve { degree: 2.., .. }));
    let linear = is_free(|term| matches!(term, Term::Squareness(_) | Term::Curve { degree: 1, .. }));
    let mut lacking: Vec<[String; 2]> = Vec::new();
    let mut lacks = |reason: &str, needed: String| lacking.push([reason.to_owned(), needed]);
    let is_turned = is_turned(&plate.places);
    if linear && !is_turned {
        lacks(
            "without the turned placement squareness and the ratio of the scales cannot be told from the plate's own skew and \
             proportions",
            format!("a [[plate.placement]] with {}", turning(grid, &plate.places)),
        );
    }
    let is_moved = is_moved(grid, &plate.places);
    if shaped && !is_moved {
        lacks(
            "without a moved placement a shape that repeats itself turned cannot be told from the places of the plate's own \
             balls or holes",
            "a [[plate.placement]] with moved = [1, 0] or moved = [0, 1]".into(),
        );
    }
    // A shape that moves the two ends changes the length, too, but only the scale needs it known.
    let scaled = is_free(|term| matches!(term, Term::Curve { degree: 1, .. }));
    if scaled && grid.length_mm.is_none() && observed.lengths.iter().flatten().any(|length| seen(*length)) {
        let balls = if grid.holes { "holes" } else { "balls" };
        lacks("without a known length one scale stays free", format!("[plate.length] between two of its {balls}"));
    }
    if shaped && is_turned && is_moved || lacking.is_empty() {
        lacking.push(["the placements are too few".into(), "more of them, turned, or moved by one pitch".into()]);
    }
    let places = counted(plate.places.len(), "placement");
    let terms = if names.is_empty() { "the plate's own places".into() } else { names.join(", ") };
    let [reasons, needed] = [("; ", 0), ("; and ", 1)]
        .map(|(with, which)| lacking.iter().map(|lack| lack[which].as_str()).collect::<Vec<_>>().join(with));
    (format!("a plate in {places}: rank {rank} of {count} unknowns, these stay free: {terms}; {reasons}"), needed)
}

/// A curve by its error's name, whatever its degree.
fn short(term: Term, name: &str) -> String {
    match term {
        Term::Curve { axis, component, degree: 2.. } => {
            format!("E{}{}", Axis::ALL[usize::from(component) % 6].letter(), axis.letter())
        }
        _ => name.to_owned(),
    }
}

/// The keys that turn a plate by a quarter onto its lines: half a pitch aside if these are even along one direction only.
fn turning(grid: &Grid, places: &[Place]) -> String {
    let deg = if places.first().is_some_and(|place| place.turn % 2 == 1) { 0 } else { 90 };
    let aside = if (grid.columns + grid.rows) % 2 == 1 { " and moved = [0.5, 0.5]" } else { "" };
    format!("turn_deg = {deg}{aside}")
}

/// Whether two placements in one plane are a quarter turn apart.
fn is_turned(places: &[Place]) -> bool {
    is_any_pair(places, |one, other| (one.turn + other.turn) % 2 == 1)
}

/// Whether two placements in one plane are turned alike and lie apart.
fn is_moved(grid: &Grid, places: &[Place]) -> bool {
    is_any_pair(places, |one, other| one.turn == other.turn && grid.apart(one, other))
}

fn is_any_pair(places: &[Place], is: impl Fn(&Place, &Place) -> bool) -> bool {
    let mut pairs =
        places.iter().enumerate().flat_map(|(index, one)| places[..index].iter().map(move |other| (one, other)));
    pairs.any(|(one, other)| one.normal == other.normal && is(one, other))
}
