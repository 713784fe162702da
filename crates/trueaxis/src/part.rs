//! Parts that a build may leave out to save flash; the default build has all of them.
//!
//! A type that only a part needs contains the part's [`Token`]. In a build without the part that token type has no
//! value, so neither has the containing type: all code behind it is unreachable, and the linker drops it. Nor can such
//! a value be built unnoticed: its constructor has to get the token, and without one refuses with the part's name.

use core::fmt;

/// A part that a build may leave out: the crate's feature of that name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[repr(u8)]
pub enum Part {
    /// Errors over a grid of several axes.
    Grids = 1,
    /// The volumetric model.
    Volumetric = 2,
    /// Rotary axes and the transformation of tool coordinates.
    Rotary = 3,
    /// Friction, following error, contour feedback, cross-talk and learned corrections.
    Dynamic = 4,
    /// The three-probe gauge.
    Gauge = 5,
    /// Arcs, helices and splines in paths.
    Curves = 6,
}

impl Part {
    /// Name of the feature.
    pub const fn name(self) -> &'static str {
        match self {
            Part::Grids => "grids",
            Part::Volumetric => "volumetric",
            Part::Rotary => "rotary",
            Part::Dynamic => "dynamic",
            Part::Gauge => "gauge",
            Part::Curves => "curves",
        }
    }

    /// Whether this build has the part.
    pub const fn is_built(self) -> bool {
        match self {
            Part::Grids => cfg!(feature = "grids"),
            Part::Volumetric => cfg!(feature = "volumetric"),
            Part::Rotary => cfg!(feature = "rotary"),
            Part::Dynamic => cfg!(feature = "dynamic"),
            Part::Gauge => cfg!(feature = "gauge"),
            Part::Curves => cfg!(feature = "curves"),
        }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Whether the build has the texts of refusals. Without them, errors have codes and numbers only.
pub(crate) const TEXT: bool = cfg!(feature = "text");

/// Whether cycles that pass every check have a separate copy of the step.
pub(crate) const FAST: bool = cfg!(feature = "fast");

/// Returns a text of a refusal; empty in a build without texts.
pub(crate) const fn text(text: &'static str) -> &'static str {
    if TEXT { text } else { "" }
}

/// Proof that a part is in the build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Token;

/// Called on the token of a value: the calling code is unreachable in a build without the part.
pub(crate) trait Presence {
    fn exists(&self);
}

impl Presence for Token {
    #[inline(always)]
    fn exists(&self) {}
}

impl Presence for core::convert::Infallible {
    #[inline(always)]
    fn exists(&self) {
        match *self {}
    }
}

macro_rules! tokens {
    ($($feature:literal $token:ident $constant:ident;)*) => {$(
        #[cfg(feature = $feature)]
        pub(crate) type $token = Token;
        #[cfg(feature = $feature)]
        pub(crate) const $constant: Option<$token> = Some(Token);
        #[cfg(not(feature = $feature))]
        pub(crate) type $token = core::convert::Infallible;
        #[cfg(not(feature = $feature))]
        pub(crate) const $constant: Option<$token> = None;
    )*};
}

tokens! {
    "grids" Grids GRIDS;
    "volumetric" Volumetric VOLUMETRIC;
    "dynamic" Dynamic DYNAMIC;
    "gauge" Gauge GAUGE;
}
