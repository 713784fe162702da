use crate::colour::Colour;

/// Style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    pub(crate) colour: Colour,
    pub(crate) width: f64,
    pub(crate) opacity: f64,
    pub(crate) dashed: bool,
}

impl Stroke {
    /// An opaque line; width in px.
    #[must_use]
    pub const fn new(colour: Colour, width: f64) -> Stroke {
        Stroke { colour, width, opacity: 1.0, dashed: false }
    }

    /// Sets the opacity; 1 is opaque.
    #[must_use]
    pub const fn opacity(self, opacity: f64) -> Stroke {
        Stroke { opacity, ..self }
    }

    /// Makes the line dashed.
    #[must_use]
    pub const fn dashed(self) -> Stroke {
        Stroke { dashed: true, ..self }
    }
}
