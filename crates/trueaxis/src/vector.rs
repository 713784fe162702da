//! The kernels' vector over the step's scalar: generic arithmetic, which glam's single-scalar vectors do not offer.

use crate::real::Real;
use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// Three components along X, Y, Z. The public interface uses glam's vectors ([`Real::Vec3`]); the conversions are moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct V3<R> {
    /// Along X.
    pub(crate) x: R,
    /// Along Y.
    pub(crate) y: R,
    /// Along Z.
    pub(crate) z: R,
}

/// Machine direction of an axis of rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum About {
    /// X: an A axis.
    X,
    /// Y: a B axis.
    Y,
    /// Z: a C axis.
    Z,
}

impl<R: Real> V3<R> {
    /// The zero vector.
    pub(crate) const ZERO: Self = V3 { x: R::ZERO, y: R::ZERO, z: R::ZERO };

    /// Creates a vector from its components.
    #[inline(always)]
    pub(crate) const fn new(x: R, y: R, z: R) -> Self {
        V3 { x, y, z }
    }

    /// Rounds a vector from doubles.
    pub(crate) fn of([x, y, z]: [f64; 3]) -> Self {
        V3::new(R::of(x), R::of(y), R::of(z))
    }

    /// Converts from glam's vector.
    #[inline(always)]
    pub(crate) fn from_glam(v: R::Vec3) -> Self {
        V3::from(v.into())
    }

    /// Converts to glam's vector.
    #[inline(always)]
    pub(crate) fn glam(self) -> R::Vec3 {
        self.array().into()
    }

    /// The components.
    #[inline(always)]
    pub(crate) const fn array(self) -> [R; 3] {
        [self.x, self.y, self.z]
    }

    /// Scalar product.
    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Vector product.
    #[inline(always)]
    pub(crate) fn cross(self, other: Self) -> Self {
        V3::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    /// Length.
    #[inline(always)]
    pub(crate) fn norm(self) -> R {
        self.dot(self).sqrt()
    }

    /// Rotates about a machine direction by the angle with this cosine and sine, right-handed.
    #[inline(always)]
    pub(crate) fn turned(self, about: About, (c, s): (R, R)) -> Self {
        let V3 { x, y, z } = self;
        match about {
            About::X => V3::new(x, c * y - s * z, s * y + c * z),
            About::Y => V3::new(c * x + s * z, y, c * z - s * x),
            About::Z => V3::new(c * x - s * y, s * x + c * y, z),
        }
    }
}

impl<R> From<[R; 3]> for V3<R> {
    #[inline(always)]
    fn from([x, y, z]: [R; 3]) -> Self {
        V3 { x, y, z }
    }
}

impl<R: Real> Add for V3<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        V3::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<R: Real> Sub for V3<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        V3::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<R: Real> Mul<R> for V3<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        V3::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl<R: Real> Neg for V3<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        V3::new(-self.x, -self.y, -self.z)
    }
}

impl<R: Real> AddAssign for V3<R> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<R: Real> SubAssign for V3<R> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
