//! Seeded random numbers, identical on every host.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub struct Draws(ChaCha8Rng);

impl Draws {
    /// Creates a stream of a seed: streams of different numbers are independent.
    pub fn new(seed: u64, stream: u64) -> Draws {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        Draws(random)
    }

    /// Draws from a normal distribution of mean 0 and variance 1.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Draws from Student's distribution; normal if the degrees of freedom are infinite.
    ///
    /// It describes the knowledge of a quantity whose standard uncertainty was estimated from ν + 1 readings: JCGM 101:2008,
    /// 6.4.9.
    pub fn student(&mut self, degrees_of_freedom: f64) -> f64 {
        self.normal() * self.spread(degrees_of_freedom)
    }

    /// √(ν/χ²_ν): draws the ratio of a true standard deviation to its estimate; 1 if ν is infinite.
    pub fn spread(&mut self, degrees_of_freedom: f64) -> f64 {
        match ChiSquared::new(degrees_of_freedom) {
            Ok(squares) if degrees_of_freedom.is_finite() => {
                (degrees_of_freedom / squares.sample(&mut self.0).max(f64::MIN_POSITIVE)).sqrt()
            }
            _ => 1.0,
        }
    }
}
