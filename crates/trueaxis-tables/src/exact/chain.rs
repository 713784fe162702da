//! Parses a structural code, independently of the controller's check.

use super::GeometryError;
use trueaxis::machine::Axis;

/// Axes in the order of the code, and whether they carry the workpiece.
pub(super) fn structural_code(chain: &str) -> Result<Vec<(Axis, bool)>, GeometryError> {
    let wrong = |found: Option<char>, needed| GeometryError::Chain {
        chain: chain.to_owned(),
        found: found.map_or("the end".to_owned(), |c| format!("'{c}'")),
        needed,
    };
    let mut code = chain.chars().filter(|c| !c.is_whitespace()).peekable();
    match code.next() {
        Some('w') => {}
        other => return Err(wrong(other, "'w' first")),
    }
    let mut links = Vec::new();
    let mut on_workpiece = true;
    loop {
        let next = code.next();
        match next {
            Some('b') if on_workpiece => on_workpiece = false,
            Some('t') if !on_workpiece => break,
            Some(letter) => {
                let axis = Axis::from_letter(letter).ok_or_else(|| wrong(next, "an axis letter, 'b' or 't'"))?;
                let primed = code.next_if_eq(&'\'').is_some();
                if primed != on_workpiece {
                    return Err(wrong(next, "a prime on every axis between w and b, none between b and t"));
                }
                links.push((axis, on_workpiece));
            }
            None => return Err(wrong(None, "'b' and 't'")),
        }
    }
    match code.next() {
        None => Ok(links),
        other => Err(wrong(other, "nothing after 't'")),
    }
}
