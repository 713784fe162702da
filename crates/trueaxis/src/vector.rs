//! A vector of three components over the scalar of the step.

use crate::real::Real;
use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// Three components along X, Y, Z; converts to and from arrays, and through them to any vector library.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct V3<R> {
    /// Along X.
    pub x: R,
    /// Along Y.
    pub y: R,
    /// Along Z.
    pub z: R,
}

/// Which machine direction an axis of rotation has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum About {
    /// X: an A axis.
    X,
    /// Y: a B axis.
    Y,
    /// Z: a C axis.
    Z,
}

impl<R: Real> V3<R> {
    /// The zero vector.
    pub const ZERO: Self = V3 { x: R::ZERO, y: R::ZERO, z: R::ZERO };

    /// From its components.
    #[inline(always)]
    pub const fn new(x: R, y: R, z: R) -> Self {
        V3 { x, y, z }
    }

    /// Rounded from doubles.
    pub fn of([x, y, z]: [f64; 3]) -> Self {
        V3::new(R::of(x), R::of(y), R::of(z))
    }

    /// The components.
    #[inline(always)]
    pub const fn array(self) -> [R; 3] {
        [self.x, self.y, self.z]
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        V3::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    /// Length.
    #[inline(always)]
    pub fn norm(self) -> R {
        self.dot(self).sqrt()
    }

    /// Turned about a machine direction by the angle of that cosine and sine, right-handed.
    #[inline(always)]
    pub fn turned(self, about: About, (c, s): (R, R)) -> Self {
        let V3 { x, y, z } = self;
        match about {
            About::X => V3::new(x, c * y - s * z, s * y + c * z),
            About::Y => V3::new(c * x + s * z, y, c * z - s * x),
            About::Z => V3::new(c * x - s * y, s * x + c * y, z),
        }
    }
}

impl<R> From<[R; 3]> for V3<R> {
    fn from([x, y, z]: [R; 3]) -> Self {
        V3 { x, y, z }
    }
}

impl<R> From<V3<R>> for [R; 3] {
    fn from(v: V3<R>) -> Self {
        [v.x, v.y, v.z]
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
