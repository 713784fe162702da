//! Values of a line: numbers, parameters, expressions in brackets, functions.
//!
//! `**` binds strongest, then `*` `/` MOD, then `+` `-`, then the comparisons, then AND OR XOR; equal ones from the left. A sign
//! belongs to its value: `-2**2` is 4. For EQ and NE, values that differ by less than 1e-4 are equal. Angles are in degrees.

use super::error::Refusal;

/// Values within this are equal for EQ and NE, as in LinuxCNC 2.9; its development version has 1e-6, also for GE and LE.
const EQUAL: f64 = 1.0e-4;

/// A number is whole if it is off by no more than this.
const WHOLE: f64 = 1.0e-4;

/// Last numbered parameter, as in LinuxCNC.
pub(super) const LAST: u32 = 5602;

/// Most values within one another, by brackets, signs or `#`.
const DEEPEST: u32 = 100;

const VALUE: &str = "a number, a parameter as #1 or #<name>, an expression in [ ], or ABS ACOS ASIN ATAN[]/[] COS EXISTS EXP \
     FIX FUP LN ROUND SIN SQRT TAN with one";

/// Where parameters have their values from.
pub(super) trait Values {
    /// Value of #1, #2 …; `None` if there is no parameter of that number.
    fn numbered(&self, number: u32) -> Option<f64>;

    /// Value of `#<name>`, in upper case without blanks; `None` if it has none.
    fn named(&self, name: &str) -> Option<f64>;
}

/// A parameter by number or name.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Parameter<'t> {
    Number(u32),
    Name(&'t str),
}

/// Reads values from a line cleaned by [`clean`](super::text::clean).
pub(super) struct Reader<'t, 'v, V> {
    line: u32,
    /// The part of the line that has not been read yet.
    pub(super) rest: &'t str,
    values: &'v V,
    depth: u32,
}

impl<'t, 'v, V: Values> Reader<'t, 'v, V> {
    pub(super) fn new(line: u32, rest: &'t str, values: &'v V) -> Self {
        Reader { line, rest, values, depth: 0 }
    }

    fn refuse<T>(&self, found: impl Into<String>, needed: impl Into<String>) -> Result<T, Refusal> {
        Err(Refusal::new(self.line, found, needed))
    }

    /// Goes past `text` if it comes next.
    pub(super) fn take(&mut self, text: &str) -> bool {
        let rest = self.rest.strip_prefix(text);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    /// A value where one may stand: after a letter, in brackets.
    pub(super) fn value(&mut self) -> Result<f64, Refusal> {
        if self.depth >= DEEPEST {
            return self.refuse(format!("`{}`", self.rest), format!("at most {DEEPEST} values within one another"));
        }
        self.depth += 1;
        let value = self.inner();
        self.depth -= 1;
        value
    }

    fn inner(&mut self) -> Result<f64, Refusal> {
        let mut bytes = self.rest.bytes();
        let (first, second) = (bytes.next().unwrap_or(b' '), bytes.next().unwrap_or(b' '));
        match first {
            b'[' => self.bracketed(),
            b'#' => self.parameter_value(),
            b'+' | b'-' if !(second.is_ascii_digit() || second == b'.') => {
                let text = self.rest;
                self.rest = text.get(1..).unwrap_or_default();
                if self.rest.is_empty() {
                    return self.refuse(format!("`{text}`"), VALUE);
                }
                let value = self.value()?;
                Ok(if first == b'-' { -value } else { value })
            }
            b'A'..=b'Z' => self.function(),
            _ => self.number(),
        }
    }

    fn number(&mut self) -> Result<f64, Refusal> {
        let signs = usize::from(self.rest.starts_with(['+', '-']));
        let digits = self.rest.bytes().skip(signs).take_while(|b| b.is_ascii_digit() || *b == b'.').count();
        let (number, after) = self.rest.split_at(signs + digits);
        let Ok(value) = number.parse::<f64>() else {
            return self.refuse(format!("`{}`", if digits == 0 { self.rest } else { number }), VALUE);
        };
        self.rest = after;
        Ok(value)
    }

    /// A whole number, as labels and numbers of parameters are.
    pub(super) fn whole(&mut self) -> Result<f64, Refusal> {
        let text = self.rest;
        let value = self.value()?;
        let whole = value.round();
        if (value - whole).abs() > WHOLE {
            return self.refuse(format!("{value} in `{text}`"), "a whole number");
        }
        Ok(whole)
    }

    /// `[` … `]`.
    pub(super) fn bracketed(&mut self) -> Result<f64, Refusal> {
        let text = self.rest;
        if !self.take("[") {
            return self.refuse(format!("`{text}`"), "an expression in [ ]");
        }
        let value = self.operation(1)?;
        if !self.take("]") {
            let needed = "] or an operator: ** * / MOD + - EQ NE GT GE LT LE AND OR XOR";
            return self.refuse(format!("`{}` in `{text}`", self.rest), needed);
        }
        Ok(value)
    }

    /// Operations that bind at least as strongly as `least`.
    fn operation(&mut self, least: u8) -> Result<f64, Refusal> {
        let mut left = self.value()?;
        while let Some((operator, strength)) = Operator::at(self.rest).filter(|(_, strength)| *strength >= least) {
            self.rest = self.rest.get(operator.0.len()..).unwrap_or_default();
            let right = self.operation(strength + 1)?;
            let value = operator.of(left, right);
            if !value.is_finite() {
                return self.refuse(format!("{left} {} {right}", operator.0), "operands with a finite result");
            }
            left = value;
        }
        Ok(left)
    }

    fn function(&mut self) -> Result<f64, Refusal> {
        let text = self.rest;
        let letters = text.bytes().take_while(u8::is_ascii_uppercase).count();
        let (name, after) = text.split_at(letters);
        if !FUNCTIONS.contains(&name) || !after.starts_with('[') {
            return self.refuse(format!("`{text}`"), VALUE);
        }
        self.rest = after;
        if name == "EXISTS" {
            self.take("[");
            let parameter = self.parameter()?;
            if !self.take("]") {
                return self.refuse(format!("`{text}`"), "EXISTS[#<name>]");
            }
            return Ok(f64::from(u8::from(self.read(&parameter).is_some())));
        }
        let argument = self.bracketed()?;
        let value = match name {
            "ABS" => argument.abs(),
            "ACOS" => libm::acos(argument).to_degrees(),
            "ASIN" => libm::asin(argument).to_degrees(),
            "ATAN" if !self.take("/") => return self.refuse(format!("`{text}`"), "ATAN[y]/[x]"),
            "ATAN" => libm::atan2(argument, self.bracketed()?).to_degrees(),
            "COS" => libm::cos(argument.to_radians()),
            "EXP" => libm::exp(argument),
            "FIX" => argument.floor(),
            "FUP" => argument.ceil(),
            "LN" => libm::log(argument),
            "ROUND" => argument.round(),
            "SIN" => libm::sin(argument.to_radians()),
            "SQRT" => argument.sqrt(),
            _ => libm::tan(argument.to_radians()),
        };
        if value.is_finite() {
            return Ok(value);
        }
        self.refuse(format!("{name} of {argument}"), "an argument with a finite result")
    }

    /// `#` with a number or a name.
    pub(super) fn parameter(&mut self) -> Result<Parameter<'t>, Refusal> {
        let text = self.rest;
        if !self.take("#") {
            return self.refuse(format!("`{text}`"), "a parameter as #1 or #<name>");
        }
        if self.rest.starts_with('<') {
            return Ok(Parameter::Name(self.name()?));
        }
        let number = self.whole()?;
        if !(1.0..=f64::from(LAST)).contains(&number) {
            return self.refuse(format!("`#{number}`"), format!("a parameter from #1 to #{}", LAST));
        }
        Ok(Parameter::Number(number as u32))
    }

    /// `<name>`, without the brackets.
    pub(super) fn name(&mut self) -> Result<&'t str, Refusal> {
        let text = self.rest;
        let Some((name, after)) = text.strip_prefix('<').and_then(|text| text.split_once('>')) else {
            return self.refuse(format!("`{text}`"), "a name in < >");
        };
        self.rest = after;
        Ok(name)
    }

    fn read(&self, parameter: &Parameter<'_>) -> Option<f64> {
        match parameter {
            Parameter::Number(number) => self.values.numbered(*number),
            Parameter::Name(name) => self.values.named(name),
        }
    }

    fn parameter_value(&mut self) -> Result<f64, Refusal> {
        let text = self.rest;
        let parameter = self.parameter()?;
        match self.read(&parameter) {
            Some(value) => Ok(value),
            None => {
                let found = text.get(..text.len() - self.rest.len()).unwrap_or_default();
                let needed =
                    "a parameter with a value: assigned before, in this subprogram if its name does not begin with _";
                self.refuse(format!("`{found}`"), needed)
            }
        }
    }
}

const FUNCTIONS: [&str; 14] =
    ["ABS", "ACOS", "ASIN", "ATAN", "COS", "EXISTS", "EXP", "FIX", "FUP", "LN", "ROUND", "SIN", "SQRT", "TAN"];

/// A binary operator by its text.
#[derive(Clone, Copy)]
struct Operator(&'static str);

/// The longer one first where one begins with another.
const OPERATORS: [(&str, u8); 15] = [
    ("**", 5),
    ("*", 4),
    ("/", 4),
    ("MOD", 4),
    ("+", 3),
    ("-", 3),
    ("EQ", 2),
    ("NE", 2),
    ("GT", 2),
    ("GE", 2),
    ("LT", 2),
    ("LE", 2),
    ("AND", 1),
    ("OR", 1),
    ("XOR", 1),
];

impl Operator {
    /// The operator at the beginning of a text, and how strongly it binds.
    fn at(text: &str) -> Option<(Operator, u8)> {
        OPERATORS
            .into_iter()
            .find(|(name, _)| text.starts_with(name))
            .map(|(name, strength)| (Operator(name), strength))
    }

    fn of(self, a: f64, b: f64) -> f64 {
        let truth = |yes: bool| f64::from(u8::from(yes));
        let equal = (a - b).abs() < EQUAL;
        match self.0 {
            "**" => libm::pow(a, b),
            "*" => a * b,
            "/" => a / b,
            // The result is never negative.
            "MOD" => {
                let rest = libm::fmod(a, b);
                if rest < 0.0 { rest + b.abs() } else { rest }
            }
            "+" => a + b,
            "-" => a - b,
            "EQ" => truth(equal),
            "NE" => truth(!equal),
            "GT" => truth(a > b),
            "GE" => truth(a >= b),
            "LT" => truth(a < b),
            "LE" => truth(a <= b),
            "AND" => truth(a != 0.0 && b != 0.0),
            "OR" => truth(a != 0.0 || b != 0.0),
            _ => truth((a != 0.0) != (b != 0.0)),
        }
    }
}
