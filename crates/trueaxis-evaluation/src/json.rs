//! JSON documents of results, in which zero has no sign.

use serde::Serialize;
use serde_json::ser::{CompactFormatter, Formatter, PrettyFormatter, Serializer};
use std::io::{Result, Write};

/// A formatter that writes −0 as 0: the sign of zero carries no information.
struct Unsigned<F>(F);

/// Forwards the methods that produce lines and indents.
macro_rules! as_within {
    ($($name:ident($($argument:ident: $kind:ty),*);)*) => {
        $(fn $name<W: ?Sized + Write>(&mut self, writer: &mut W, $($argument: $kind),*) -> Result<()> {
            self.0.$name(writer, $($argument),*)
        })*
    };
}

impl<F: Formatter> Formatter for Unsigned<F> {
    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> Result<()> {
        self.0.write_f64(writer, value + 0.0)
    }
    fn write_f32<W: ?Sized + Write>(&mut self, writer: &mut W, value: f32) -> Result<()> {
        self.0.write_f32(writer, value + 0.0)
    }
    as_within! {
        begin_array();
        end_array();
        begin_array_value(first: bool);
        end_array_value();
        begin_object();
        end_object();
        begin_object_key(first: bool);
        end_object_key();
        begin_object_value();
        end_object_value();
    }
}

fn text(document: &impl Serialize, formatter: impl Formatter) -> serde_json::Result<String> {
    let mut bytes = Vec::new();
    document.serialize(&mut Serializer::with_formatter(&mut bytes, Unsigned(formatter)))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// A document on one line.
///
/// # Errors
/// Data that cannot be JSON, such as a map with keys that are not strings.
pub fn compact(document: &impl Serialize) -> serde_json::Result<String> {
    text(document, CompactFormatter)
}

/// A document over indented lines, ending with a newline.
///
/// # Errors
/// As [`compact`].
pub fn pretty(document: &impl Serialize) -> serde_json::Result<String> {
    text(document, PrettyFormatter::new()).map(|text| text + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_has_no_sign() {
        let document = serde_json::json!({ "a": [-0.0, 1.5, { "b": -0.0 }], "c": " -0.0", "d": [] });
        assert_eq!(compact(&document).unwrap(), r#"{"a":[0.0,1.5,{"b":0.0}],"c":" -0.0","d":[]}"#);
        let plain = serde_json::json!({ "a": [0.0, 1.5, { "b": 0.0 }], "c": " -0.0", "d": [] });
        assert_eq!(pretty(&document).unwrap(), serde_json::to_string_pretty(&plain).unwrap() + "\n");
    }
}
