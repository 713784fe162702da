//! The structural code of a machine.

use crate::axis::{AXES, Axis};
use crate::error::{ConfigError, Field};
use heapless::Vec;

/// An axis in the kinematic chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// Which axis.
    pub axis: Axis,
    /// On the workpiece side of the bed (marked by a prime).
    pub carries_workpiece: bool,
}

/// The axes of a structural code from the workpiece to the tool, e.g. `w Y' X' b Z t`.
///
/// The code reads: `w`, the axes that carry the workpiece (each with a prime), `b` for the bed, the axes that carry the
/// tool (without), `t`; blanks are optional, every axis appears at most once. Source: ISO 10791-6.
///
/// # Errors
/// [`Field::Chain`] with the position in the code, counted from 0, of the first letter that cannot be parsed.
pub fn links(chain: &str) -> Result<Vec<Link, AXES>, ConfigError> {
    let wrong = |place: usize, needed| ConfigError::new(Field::Chain, place as f64, needed).at(place);
    let mut letters = chain.char_indices().filter(|(_, letter)| !letter.is_whitespace()).peekable();
    let mut links = Vec::new();
    if letters.next().is_none_or(|(_, letter)| letter != 'w') {
        return Err(wrong(0, "w, the workpiece, at the start of the chain"));
    }
    let mut behind_bed = false;
    while let Some((place, letter)) = letters.next() {
        if letter == 'b' && !behind_bed {
            behind_bed = true;
            continue;
        }
        if letter == 't' && behind_bed {
            return match letters.next() {
                None => Ok(links),
                Some((place, _)) => Err(wrong(place, "nothing after t in the chain")),
            };
        }
        let axis = Axis::from_letter(letter).ok_or(wrong(
            place,
            if behind_bed { "X Y Z A B C, or t, after the bed" } else { "X' Y' Z' A' B' C', or b, before the bed" },
        ))?;
        if links.iter().any(|link: &Link| link.axis == axis) {
            return Err(wrong(place, "each axis at most once in the chain"));
        }
        let primed = letters.next_if(|(_, letter)| *letter == '\'').is_some();
        match (primed, behind_bed) {
            (false, false) => return Err(wrong(place, "a prime at every axis between w and b")),
            (true, true) => return Err(wrong(place, "no prime at an axis between b and t")),
            _ => {}
        }
        links.push(Link { axis, carries_workpiece: primed }).map_err(|_| wrong(place, "at most six axes"))?;
    }
    Err(wrong(chain.len(), "t, the tool, at the end of the chain, and b, the bed, before it"))
}

/// Whether a rotary axis between the bed and `axis` turns its errors.
pub fn is_turned(links: &[Link], axis: Axis) -> bool {
    carriers(links, axis) > 0
}

/// Whether an axis is on the workpiece side of a structural code; `false` if the code cannot be parsed.
pub fn carries_workpiece(chain: &str, axis: Axis) -> bool {
    links(chain).is_ok_and(|links| links.iter().any(|link| link.axis == axis && link.carries_workpiece))
}

/// Number of rotary axes between the bed and `axis`.
fn carriers(links: &[Link], axis: Axis) -> usize {
    let Some(place) = links.iter().position(|link| link.axis == axis) else { return 0 };
    let side = links.get(place).is_some_and(|link| link.carries_workpiece);
    let nearer = |other: usize| if side { other > place } else { other < place };
    let carrier =
        |(other, link): &(usize, &Link)| nearer(*other) && link.carries_workpiece == side && link.axis.is_rotary();
    links.iter().enumerate().filter(carrier).count()
}

/// Refuses a chain in which more than two rotary axes turn the errors of an axis: the nine terms support two.
pub(crate) fn nine_terms(links: &[Link]) -> Result<(), ConfigError> {
    if links.iter().any(|link| carriers(links, link.axis) > 2) {
        return Err(ConfigError::new(Field::Chain, 3.0, MOST_CARRIERS));
    }
    Ok(())
}

/// Requirement of [`nine_terms`].
pub(crate) const MOST_CARRIERS: &str = "at most two rotary axes below another, or model = \"volumetric\"";
