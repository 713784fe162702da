//! The outcome of an input: the loop sees no coverage, so it keeps every input with a new outcome.

use std::cell::Cell;
use std::fmt::Display;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Outcome of an execution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Outcome {
    /// Class of everything it reported, in order; 0 if it reported nothing.
    pub class: u64,
    /// Whether it was accepted ([`accepted`]).
    pub accepted: bool,
}

/// Signs of a value printed in its debug form.
const DUMPS: [&str; 6] = ["Some(", "None)", "Ok(", "Err(", "Error {", " { kind:"];

thread_local! {
    static OUTCOME: Cell<Outcome> = const { Cell::new(Outcome { class: 0, accepted: false }) };
    /// Which of [`DUMPS`] the input contains, so that a refusal may repeat them.
    static GIVEN: Cell<[bool; DUMPS.len()]> = const { Cell::new([false; DUMPS.len()]) };
}

/// Begins an execution: a refusal may repeat parts of the input.
pub fn begin(input: &[u8]) {
    take();
    GIVEN.set(DUMPS.map(|dump| input.windows(dump.len()).any(|part| part == dump.as_bytes())));
}

/// Longest refusal, characters: a longer one is a dump.
const LONGEST_REFUSAL: usize = 2200;

/// Reports that the target reached this point. The campaign keeps an input with a new sequence of these points. Use few
/// values, not one for every number.
pub fn saw(what: impl Hash) {
    let mut hasher = DefaultHasher::new();
    let before = OUTCOME.get();
    (before.class, what).hash(&mut hasher);
    OUTCOME.set(Outcome { class: hasher.finish(), ..before });
}

/// Reports that the input was accepted.
pub fn accepted() {
    saw("accepted");
    OUTCOME.set(Outcome { accepted: true, ..OUTCOME.get() });
}

/// Reports that the input was refused, and checks the message: some text, on one line, for people.
///
/// # Panics
/// If the message is empty, has more than one line, or contains a debug form.
pub fn refused(error: impl Display) {
    let message = error.to_string();
    assert!(!message.trim().is_empty(), "an empty refusal");
    // Other control characters are escaped when a program prints the message.
    assert!(!message.contains('\n'), "a refusal of more than a line: {message:?}");
    let length = message.chars().count();
    assert!(length <= LONGEST_REFUSAL, "a refusal of {length} characters: {message:?}");
    for (dump, given) in DUMPS.iter().zip(GIVEN.get()) {
        assert!(
            given || !outside_quotes(&message).contains(dump),
            "a refusal with a value of the program: {message:?}"
        );
    }
    saw(shape(&message));
}

/// The message without its quotations of the input.
fn outside_quotes(message: &str) -> String {
    message.split(['"', '`']).step_by(2).collect()
}

/// The part of a message that states the requirement, without figures, or else the whole message. The part with the
/// value found would differ for every input.
fn shape(message: &str) -> String {
    let said = message.rsplit_once("needed").map_or(message, |(_, needed)| needed);
    outside_quotes(said)
        .chars()
        .filter(|c| !c.is_ascii_digit() && !matches!(c, '.' | '-' | '+' | 'e'))
        .take(80)
        .collect()
}

/// The reports since the last call.
pub(crate) fn take() -> Outcome {
    OUTCOME.take()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn class(report: impl FnOnce()) -> u64 {
        take();
        report();
        take().class
    }

    #[test]
    fn a_refusal_may_repeat_what_was_given_and_nothing_of_the_program() {
        let refuse = |input: &[u8]| {
            begin(input);
            std::panic::catch_unwind(|| refused("x.csv:1: column Some(1: found \"`Some(1\", needed a name")).is_ok()
        };
        assert!(refuse(b"a,`Some(1\n"));
        assert!(!refuse(b"a,1\n"));
        take();
    }

    #[test]
    fn a_class_has_no_figures_and_no_quotations() {
        let one = class(|| refused("x.csv:3: column EXX_um: found \"two\", needed a number"));
        assert_eq!(one, class(|| refused("x.csv:14: column EXX_um: found \"-7,5\", needed a number")));
        assert_ne!(one, class(|| refused("x.csv:3: column EXX_um: found \"two\", needed a finite number")));
        assert_ne!(one, 0);
    }

    #[test]
    fn empty_and_overlong_messages_are_no_refusals() {
        for message in ["", " ", "two\nlines", "found Some(3)", "ParseError { kind: Eof }", &"x".repeat(2201)] {
            assert!(std::panic::catch_unwind(|| refused(message)).is_err(), "{message}");
        }
        refused("found \"Some(3)\", needed a number");
    }
}
