//! A real transform of N points that can pause after every few operations.
//!
//! N real values are M = N/2 complex ones, z_i = x_2i + j x_2i+1. Forward by decimation in frequency, radix 4: natural
//! order in, bit-reversed out. One pass over the pairs (k, M − k) separates the spectrum of the real signal, multiplies
//! it, and joins it again:
//!
//! ```text
//! S(k) = E + w^k O     S(M − k) = conj(E − w^k O)     E = (Z_k + conj Z_{M−k})/2   O = (Z_k − conj Z_{M−k})/2j   w = e^{−j2π/N}
//! X(k) = C(k) S(k)     Z'_k = E' + j O'               E' = (X_k + conj X_{M−k})/2  O' = conj(w^k) (X_k − conj X_{M−k})/2
//! ```
//!
//! Inverse by decimation in time, radix 4: bit-reversed in, natural out. Nothing is ever permuted: in bit-reversed order
//! the partner of place i in [b, 2b), b a power of two, is 3b − 1 − i. Where M is not a power of four, one stage of
//! radix 2 stands next to the pair pass.
//!
//! A unit of work is one radix-4 butterfly, four radix-2 ones, or one pair: 16 to 24 multiplications and as many
//! additions. The whole takes `2·(M/4·⌊log4 M⌋ [+ M/8]) + M/2` units.
//!
//! Source: radix-4 forms after C. S. Burrus and T. W. Parks, DFT/FFT and Convolution Algorithms, 1985; the real signal as
//! a half-length complex one after W. H. Press et al., Numerical Recipes, 3rd ed., 12.3.

use crate::real::Real;
use core::f64::consts::TAU;

/// A complex number, `[re, im]`.
pub(crate) type Complex<R> = [R; 2];

#[inline(always)]
fn add<R: Real>(a: Complex<R>, b: Complex<R>) -> Complex<R> {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
fn sub<R: Real>(a: Complex<R>, b: Complex<R>) -> Complex<R> {
    [a[0] - b[0], a[1] - b[1]]
}

/// a·b.
#[inline(always)]
fn mul<R: Real>(a: Complex<R>, b: Complex<R>) -> Complex<R> {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// a·conj(b).
#[inline(always)]
fn mul_conj<R: Real>(a: Complex<R>, b: Complex<R>) -> Complex<R> {
    [a[0] * b[0] + a[1] * b[1], a[1] * b[0] - a[0] * b[1]]
}

/// −j·a.
#[inline(always)]
fn turned<R: Real>(a: Complex<R>) -> Complex<R> {
    [a[1], -a[0]]
}

/// conj(a).
#[inline(always)]
fn conj<R: Real>(a: Complex<R>) -> Complex<R> {
    [a[0], -a[1]]
}

/// e^{−j2πi/N} for i = 0..N.
pub(crate) fn circle<R: Real, const N: usize>() -> [Complex<R>; N] {
    let mut circle = [[R::ZERO; 2]; N];
    for (i, place) in circle.iter_mut().enumerate() {
        let angle = TAU * i as f64 / N as f64;
        *place = [R::of(libm::cos(angle)), R::of(-libm::sin(angle))];
    }
    circle
}

/// Multipliers C(k), k = 1..M in natural order, with the scale of both passes and of the inverse in them.
///
/// `of` gives the multiplier of a harmonic, `[re, im]`; mean and Nyquist frequency are always removed.
pub(crate) fn multipliers<R: Real, const N: usize>(of: impl Fn(usize) -> [f64; 2]) -> [R; N] {
    let mut table = [R::ZERO; N];
    let half = N / 2;
    let scale = 1.0 / (4.0 * half as f64);
    for (k, place) in table.as_chunks_mut::<2>().0.iter_mut().enumerate().skip(1) {
        *place = of(k).map(|part| R::of(part * scale));
    }
    table
}

/// Where a pass through the stages stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Progress {
    /// Distance of the values of a butterfly, a quarter of a block; 0 in the radix-2 stage.
    quarter: usize,
    /// Place of the first value.
    at: usize,
    /// Place of the first twiddle factor on the circle, and its step from one butterfly to the next: N/4 of them in a
    /// block, whatever its length.
    turn: usize,
    step: usize,
}

impl Progress {
    /// A stage of blocks of a length.
    const fn stage<const N: usize>(length: usize) -> Self {
        Progress { quarter: length >> 2, at: 0, turn: 0, step: N >> length.trailing_zeros() }
    }

    /// Before the first unit of a forward transform.
    pub(crate) const fn forward<const N: usize>() -> Self {
        Self::stage::<N>(N / 2)
    }

    /// Before the first unit of an inverse transform.
    pub(crate) const fn inverse<const N: usize>() -> Self {
        Self::stage::<N>(if (N / 2).trailing_zeros() % 2 == 1 { 2 } else { 4 })
    }

    /// Before the first pair: the place 1, its own partner. Here `quarter` is the first place of the block, `turn` the
    /// partner.
    pub(crate) const fn pairs() -> Self {
        Progress { quarter: 1, at: 1, turn: 1, step: 0 }
    }

    /// To the next pair; true after the last.
    #[inline(always)]
    fn next_pair<const N: usize>(&mut self) -> bool {
        self.at += 1;
        self.turn = self.turn.wrapping_sub(1);
        // Half of [b, 2b) has met the other half; the place 1 has gone past itself.
        if self.at <= self.turn {
            return false;
        }
        self.quarter *= 2;
        (self.at, self.turn) = (self.quarter, 2 * self.quarter - 1);
        self.at >= N / 2
    }

    /// To the next butterfly; true at the end of a block.
    #[inline(always)]
    fn advance<const N: usize>(&mut self) -> bool {
        self.at += 1;
        self.turn += self.step;
        self.turn >= N / 4
    }

    /// To the next block of a stage; true at the end of the stage.
    #[inline(always)]
    fn next_block<const N: usize>(&mut self) -> bool {
        self.turn = 0;
        self.at += 3 * self.quarter;
        self.at >= N / 2
    }
}

/// One unit of the forward transform; true when it was the last.
#[inline(always)]
pub(crate) fn forward_unit<R: Real, const N: usize>(
    z: &mut [R; N],
    circle: &[Complex<R>; N],
    progress: &mut Progress,
) -> bool {
    let z = z.as_chunks_mut::<2>().0;
    if progress.quarter == 0 {
        return sums_and_differences::<R, N>(z, progress);
    }
    let (i, [w1, w2, w3]) = operands(circle, progress);
    let [a, b, c, d] = [z[i[0]], z[i[1]], z[i[2]], z[i[3]]];
    let (e, f, g, h) = (add(a, c), sub(a, c), add(b, d), turned(sub(b, d)));
    z[i[0]] = add(e, g);
    z[i[1]] = mul(sub(e, g), w2);
    z[i[2]] = mul(add(f, h), w1);
    z[i[3]] = mul(sub(f, h), w3);
    if !(progress.advance::<N>() && progress.next_block::<N>()) {
        return false;
    }
    let length = progress.quarter;
    *progress = Progress { quarter: length >> 2, at: 0, turn: 0, step: 4 * progress.step };
    length < 2
}

/// One unit of the inverse transform, unscaled; true when it was the last.
#[inline(always)]
pub(crate) fn inverse_unit<R: Real, const N: usize>(
    z: &mut [R; N],
    circle: &[Complex<R>; N],
    progress: &mut Progress,
) -> bool {
    let z = z.as_chunks_mut::<2>().0;
    if progress.quarter == 0 {
        if sums_and_differences::<R, N>(z, progress) {
            *progress = Progress::stage::<N>(8);
        }
        return false;
    }
    let (i, [w1, w2, w3]) = operands(circle, progress);
    let (a, b) = (z[i[0]], mul_conj(z[i[1]], w2));
    let (c, d) = (mul_conj(z[i[2]], w1), mul_conj(z[i[3]], w3));
    let (e, f, g, h) = (add(a, b), sub(a, b), add(c, d), turned(sub(c, d)));
    z[i[0]] = add(e, g);
    z[i[2]] = sub(e, g);
    z[i[1]] = sub(f, h);
    z[i[3]] = add(f, h);
    if !(progress.advance::<N>() && progress.next_block::<N>()) {
        return false;
    }
    let quarter = 4 * progress.quarter;
    *progress = Progress { quarter, at: 0, turn: 0, step: progress.step >> 2 };
    quarter > N / 8
}

/// Places of the four values of a butterfly, and its three twiddle factors.
#[inline(always)]
fn operands<R: Real, const N: usize>(circle: &[Complex<R>; N], progress: &Progress) -> ([usize; 4], [Complex<R>; 3]) {
    let Progress { quarter, at, turn, .. } = *progress;
    let (mask, turn) = (N / 2 - 1, turn & (N / 4 - 1));
    let places = [at & mask, (at + quarter) & mask, (at + 2 * quarter) & mask, (at + 3 * quarter) & mask];
    (places, [circle[turn], circle[2 * turn], circle[3 * turn]])
}

/// Four butterflies of the radix-2 stage; true after the last.
#[inline(always)]
fn sums_and_differences<R: Real, const N: usize>(z: &mut [Complex<R>], progress: &mut Progress) -> bool {
    let first = progress.at & (N / 2 - 8);
    for i in [first, first | 2, first | 4, first | 6] {
        let (a, b) = (z[i], z[i | 1]);
        z[i] = add(a, b);
        z[i | 1] = sub(a, b);
    }
    progress.at += 8;
    progress.at >= N / 2
}

/// The spectrum of the product at two harmonics, in the scale of the multipliers (times [`amplitude_scale`]: cosine and
/// negative sine amplitude).
pub(crate) struct Pair<R> {
    /// k, below or at M/2.
    pub(crate) low: usize,
    /// X(k).
    pub(crate) at_low: Complex<R>,
    /// M − k.
    pub(crate) high: usize,
    /// X(M − k).
    pub(crate) at_high: Complex<R>,
}

/// One pair: spectrum of the real signal in `from`, times the multipliers, joined again into `to`.
///
/// Returns the product at both harmonics, and whether it was the last pair.
#[inline(always)]
pub(crate) fn pair_unit<R: Real, const N: usize>(
    from: &[R; N],
    to: &mut [R; N],
    circle: &[Complex<R>; N],
    multipliers: &[R; N],
    progress: &mut Progress,
) -> (Pair<R>, bool) {
    let (from, to, multipliers) = (from.as_chunks::<2>().0, to.as_chunks_mut::<2>().0, multipliers.as_chunks::<2>().0);
    let half = N / 2;
    let mask = half - 1;
    let (i, partner) = (progress.at & mask, progress.turn & mask);
    let k = (i.reverse_bits() >> (half.leading_zeros() + 1)) & mask;
    let w = circle[k];
    let (a, b) = (from[i], conj(from[partner]));
    let (even, odd) = (add(a, b), mul(turned(sub(a, b)), w));
    let other = (half - k) & mask;
    let low = mul(add(even, odd), multipliers[k]);
    let high = mul(conj(sub(even, odd)), multipliers[other]);
    let mirrored = conj(high);
    let (even, odd) = (add(low, mirrored), mul_conj(sub(low, mirrored), w));
    to[i] = [even[0] - odd[1], even[1] + odd[0]];
    to[partner] = [even[0] + odd[1], odd[0] - even[1]];
    let last = progress.next_pair::<N>();
    if last {
        // The mean is not in the product.
        to[0] = [R::ZERO; 2];
    }
    (Pair { low: k, at_low: low, high: other, at_high: high }, last)
}

/// From the product in the scale of the multipliers to an amplitude: x contains a cos kθ − b sin kθ where this times X
/// is `[a, b]`.
pub(crate) const AMPLITUDE_SCALE: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Multiplies a signal's spectrum unit by unit; returns the result, the spectrum seen in the pairs, and the units.
    fn run<R: Real, const N: usize>(x: &[f64], of: impl Fn(usize) -> [f64; 2]) -> (Vec<f64>, Vec<[f64; 2]>, usize) {
        let circle = circle::<R, N>();
        let multipliers = multipliers::<R, N>(of);
        let mut z = [R::ZERO; N];
        for (to, from) in z.iter_mut().zip(x) {
            *to = R::of(*from);
        }
        let (mut units, mut progress) = (1, Progress::forward::<N>());
        while !forward_unit(&mut z, &circle, &mut progress) {
            units += 1;
        }
        let (mut out, mut spectrum) = ([R::ZERO; N], std::vec![[0.0; 2]; N / 2]);
        let mut progress = Progress::pairs();
        loop {
            units += 1;
            let (pair, last) = pair_unit(&z, &mut out, &circle, &multipliers, &mut progress);
            for (k, x) in [(pair.low, pair.at_low), (pair.high, pair.at_high)] {
                spectrum[k] = x.map(|part| part.to_f64() * AMPLITUDE_SCALE);
            }
            if last {
                break;
            }
        }
        let mut progress = Progress::inverse::<N>();
        units += 1;
        while !inverse_unit(&mut out, &circle, &mut progress) {
            units += 1;
        }
        (out.iter().map(|x| x.to_f64()).collect(), spectrum, units)
    }

    fn signal(n: usize) -> Vec<f64> {
        (0..n).map(|i| ((i * i * 7 + 13 * i) % 101) as f64 / 50.0 - 1.0).collect()
    }

    /// The definition, term by term.
    fn direct(x: &[f64], of: impl Fn(usize) -> [f64; 2]) -> (Vec<f64>, Vec<[f64; 2]>) {
        let n = x.len();
        let (mut out, mut spectrum) = (std::vec![0.0; n], std::vec![[0.0; 2]; n / 2]);
        for k in 1..n / 2 {
            let phase = |i: usize| (TAU * ((i * k) % n) as f64 / n as f64).sin_cos();
            let (mut re, mut im) = (0.0, 0.0);
            for (i, x) in x.iter().enumerate() {
                let (s, c) = phase(i);
                (re, im) = (re + x * c, im - x * s);
            }
            let [a, b] = mul([re, im], of(k)).map(|part| 2.0 * part / n as f64);
            spectrum[k] = [a, b];
            for (i, out) in out.iter_mut().enumerate() {
                let (s, c) = phase(i);
                *out += a * c - b * s;
            }
        }
        (out, spectrum)
    }

    fn worst(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    fn check<const N: usize>() {
        let x = signal(N);
        let of = |k: usize| [1.0 / (1.0 + k as f64 / 40.0), 0.3 * (k as f64 * 0.7).sin()];
        let (truth, spectrum) = direct(&x, of);
        let (double, found, units) = run::<f64, N>(&x, of);
        assert!(worst(&double, &truth) < 1e-12, "{N} {:e}", worst(&double, &truth));
        for (a, b) in spectrum.iter().zip(&found) {
            assert!(worst(a, b) < 1e-13, "{N}");
        }
        let (single, _, _) = run::<f32, N>(&x, of);
        assert!(worst(&single, &truth) < 2e-6, "{N} {:e}", worst(&single, &truth));
        let half = N / 2;
        let (stages, left) = (half.ilog2() as usize / 2, half.ilog2() as usize % 2);
        assert_eq!(units, 2 * (half / 4 * stages + left * half / 8) + half / 2);
    }

    #[test]
    fn all_lengths_agree_with_the_definition() {
        check::<64>();
        check::<128>();
        check::<256>();
        check::<512>();
        check::<1024>();
        check::<2048>();
        check::<4096>();
    }
}
