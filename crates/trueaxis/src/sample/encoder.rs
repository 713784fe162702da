//! Positions of encoders that count in integers, also past the end of their counters.

use crate::error::{ConfigError, Field};
use crate::position::{Nanometres, Position};

/// Positions of an encoder that counts in integers: `offset + counts · resolution`.
///
/// A count whose position is outside the range of the position type gives the end of that range, which is not usable: the
/// step treats it as a dropout ([`Fault::FeedbackNotFinite`](crate::Fault::FeedbackNotFinite)).
///
/// A [`WrappingCounter`] extends counters of 16 or 32 bits, and encoders that count one turn, past their end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderScale<P> {
    offset: P,
    /// Nanometres (1e-6 deg) per count, as 32.32 fixed point: exact to 1e-9 of a count step over the whole travel.
    fixed: i64,
    resolution: f64,
}

impl<P: Position> EncoderScale<P> {
    /// From the position at zero counts and the distance of one count, mm (deg); negative if counts fall as the axis
    /// moves forward.
    ///
    /// # Errors
    /// A resolution that is zero, not finite or above 1 mm; an offset that is not a usable position.
    pub fn new(offset: f64, resolution: f64) -> Result<Self, ConfigError> {
        if !(resolution != 0.0 && resolution.abs() <= 1.0) {
            return Err(ConfigError::new(Field::Encoder, resolution, "a resolution of at most 1 mm, not zero"));
        }
        if !P::of(offset).is_usable() {
            return Err(ConfigError::new(Field::Encoder, offset, "an offset within the range of positions"));
        }
        let fixed = libm::rint(resolution * 1e6 * 4_294_967_296.0) as i64;
        Ok(EncoderScale { offset: P::of(offset), fixed, resolution })
    }

    /// Position of a count, computed in doubles.
    #[inline(always)]
    pub fn position(&self, counts: i32) -> P {
        P::of(self.offset.to_f64() + f64::from(counts) * self.resolution)
    }

    /// Position of a wrapping counter, computed in doubles from [`WrappingCounter::follow`]. If that is `None`, the
    /// position is unusable: a dropout in this cycle.
    #[inline(always)]
    pub fn position_beyond(&self, counter: &mut WrappingCounter, counts: u32) -> P {
        let total = counter.follow(counts);
        // Exact up to 2^53 counts.
        P::of(total.map_or(f64::NAN, |total| self.offset.to_f64() + total as f64 * self.resolution))
    }
}

impl EncoderScale<Nanometres> {
    /// Position of a count without floating point: two multiplications and a shift.
    #[inline(always)]
    pub fn nanometres(&self, counts: i32) -> Nanometres {
        self.of_total(i64::from(counts))
    }

    /// [`EncoderScale::position_beyond`] without floating point.
    #[inline(always)]
    pub fn nanometres_beyond(&self, counter: &mut WrappingCounter, counts: u32) -> Nanometres {
        counter.follow(counts).map_or(Nanometres(i32::MIN), |total| self.of_total(total))
    }

    #[inline(always)]
    fn of_total(&self, total: i64) -> Nanometres {
        // Two's complement in 128 bits: the product stays below 2^116.
        let wide = i128::from(total) * i128::from(self.fixed) + (1 << 31);
        let sum = (wide >> 32) + i128::from(self.offset.0);
        Nanometres(sum.clamp(i128::from(i32::MIN), i128::from(i32::MAX)) as i32)
    }
}

/// A counter followed past its ends: one of 16 or 32 bits, or one that counts a single turn.
///
/// ```text
/// step  = counts − last, modulo span, as −span/2 ≤ step < span/2
/// total = total + step
/// ```
///
/// A step of more than a quarter of the span could equally be one in the opposite direction: the counter rejects it and
/// stays at the last total until counts come within a quarter of it again. So an axis may move at most span/4 counts
/// between two readings passed in, however many cycles lie between them: 16,384 for 16 bits. A missing reading is not
/// passed in.
///
/// The first reading becomes the total nearest to a stated one. With 0, the default, 16 and 32 bits read as signed
/// numbers. After a loss of counts [`WrappingCounter::near`] restarts the counter.
///
/// Costs a few integer comparisons and additions per reading.
///
/// ```
/// use trueaxis::{EncoderScale, WrappingCounter};
///
/// let scale = EncoderScale::<f64>::new(0.0, 1e-3).unwrap(); // counts of 1 µm
/// let mut counter = WrappingCounter::BITS_16;
/// assert_eq!(scale.position_beyond(&mut counter, 32_000), 32.0);
/// assert_eq!(scale.position_beyond(&mut counter, 33_000), 33.0); // -32,536 as a signed number
/// assert!(scale.position_beyond(&mut counter, 60_000).is_nan()); // a dropout
/// assert_eq!(scale.position_beyond(&mut counter, 33_001), 33.001);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WrappingCounter {
    span: i64,
    /// Mask of the significant bits of a reading.
    mask: u32,
    started: bool,
    /// `total` modulo `span`, once started.
    last: u32,
    total: i64,
}

impl WrappingCounter {
    /// A 16-bit counter; only the lower 16 bits of a reading count.
    pub const BITS_16: Self = Self::over(1 << 16);
    /// A 32-bit counter.
    pub const BITS_32: Self = Self::over(1 << 32);

    /// A counter that returns to 0 after `span` counts: 2^n for n bits, or the counts of one turn.
    ///
    /// # Errors
    /// A span below 4 or above 2^32.
    pub fn new(span: u64) -> Result<Self, ConfigError> {
        if (4..=1 << 32).contains(&span) {
            return Ok(Self::over(span as i64));
        }
        Err(ConfigError::new(Field::Encoder, span as f64, "a counter of 4 to 4294967296 counts"))
    }

    const fn over(span: i64) -> Self {
        let mask = if span & (span - 1) == 0 { (span - 1) as u32 } else { u32::MAX };
        WrappingCounter { span, mask, started: false, last: 0, total: 0 }
    }

    /// This counter before its start: the first reading becomes the total nearest to `total`. For an absolute encoder,
    /// `total` is the count at which the axis was switched off.
    #[must_use]
    pub const fn near(self, total: i64) -> Self {
        WrappingCounter { started: false, total, ..self }
    }

    /// Total count from zero, past the ends of the counter. `None`, and nothing has changed, if the step is ambiguous or
    /// the reading exceeds the span.
    #[inline(always)]
    pub fn follow(&mut self, counts: u32) -> Option<i64> {
        let counts = counts & self.mask;
        if i64::from(counts) >= self.span {
            return None;
        }
        if !self.started {
            self.last = self.total.rem_euclid(self.span) as u32;
        }
        let apart = i64::from(counts) - i64::from(self.last);
        let half = self.span / 2;
        let step = if apart >= self.span - half {
            apart - self.span
        } else if apart < -half {
            apart + self.span
        } else {
            apart
        };
        if self.started && step.abs() > self.span / 4 {
            return None;
        }
        self.started = true;
        self.last = counts;
        self.total = self.total.saturating_add(step);
        Some(self.total)
    }
}
