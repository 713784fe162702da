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
//! the partner of index i in [b, 2b), b a power of two, is 3b − 1 − i. Where M is not a power of four, one stage of
//! radix 2 stands next to the pair pass.
//!
//! A slice is one radix-4 butterfly, four radix-2 ones, or one pair: 16 to 24 multiplications and as many
//! additions. The whole takes `2·(M/4·⌊log4 M⌋ [+ M/8]) + M/2` slices.
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
    for (i, value) in circle.iter_mut().enumerate() {
        let angle = TAU * i as f64 / N as f64;
        *value = [R::of(libm::cos(angle)), R::of(-libm::sin(angle))];
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
    for (k, value) in table.as_chunks_mut::<2>().0.iter_mut().enumerate().skip(1) {
        *value = of(k).map(|part| R::of(part * scale));
    }
    table
}

/// Progress of a pass through the stages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Progress {
    /// Stages of radix 4 are numbered as the forward transform goes through them; behind the last of them stands the one
    /// of radix 2, where there is one. In the pair pass the first index of the block.
    stage: usize,
    /// Slices done in this stage; in the pair pass the index.
    at: usize,
    /// In the pair pass the partner.
    partner: usize,
}

/// Distance of the values of a butterfly in a stage, a quarter of its block; 0 from the stage of radix 2 on.
const fn quarter<const N: usize>(stage: usize) -> usize {
    (N / 8) >> (2 * stage)
}

impl Progress {
    /// Before anything has begun.
    pub(crate) const NONE: Progress = Progress { stage: 0, at: 0, partner: 0 };

    /// Before the first slice of a forward transform.
    pub(crate) const fn forward() -> Self {
        Progress { stage: 0, at: 0, partner: 0 }
    }

    /// Before the first slice of an inverse transform.
    pub(crate) const fn inverse<const N: usize>() -> Self {
        // N/2 = 2^m: the last of m/2 stages of radix 4, or the one of radix 2 behind it.
        Progress { stage: ((N / 2).trailing_zeros() as usize).div_ceil(2) - 1, at: 0, partner: 0 }
    }

    /// Before the first pair: index 1, its own partner.
    pub(crate) const fn pairs() -> Self {
        Progress { stage: 1, at: 1, partner: 1 }
    }

    /// To the next pair; true after the last.
    #[inline(always)]
    fn next_pair<const N: usize>(&mut self) -> bool {
        self.at += 1;
        self.partner = self.partner.wrapping_sub(1);
        // Half of [b, 2b) has met the other half; index 1 has gone past itself.
        if self.at <= self.partner {
            return false;
        }
        self.stage *= 2;
        (self.at, self.partner) = (self.stage, 2 * self.stage - 1);
        self.at >= N / 2
    }
}

/// One slice of the forward transform; true when it was the last.
#[inline(always)]
pub(crate) fn forward_slice<R: Real, const N: usize>(
    z: &mut [R; N],
    circle: &[Complex<R>; N],
    progress: &mut Progress,
) -> bool {
    let at = progress.at;
    // One arm a stage, so that its distances are constants.
    let stage_done = match progress.stage {
        0 => forward_stage::<R, N>(z, circle, at, const { quarter::<N>(0) }),
        1 => forward_stage::<R, N>(z, circle, at, const { quarter::<N>(1) }),
        2 => forward_stage::<R, N>(z, circle, at, const { quarter::<N>(2) }),
        3 => forward_stage::<R, N>(z, circle, at, const { quarter::<N>(3) }),
        4 => forward_stage::<R, N>(z, circle, at, const { quarter::<N>(4) }),
        _ => forward_stage::<R, N>(z, circle, at, const { quarter::<N>(5) }),
    };
    progress.at = at + 1;
    if !stage_done {
        return false;
    }
    (progress.stage, progress.at) = (progress.stage + 1, 0);
    progress.stage > const { Progress::inverse::<N>().stage }
}

/// One slice of the inverse transform, unscaled; true when it was the last.
#[inline(always)]
pub(crate) fn inverse_slice<R: Real, const N: usize>(
    z: &mut [R; N],
    circle: &[Complex<R>; N],
    progress: &mut Progress,
) -> bool {
    let at = progress.at;
    let stage_done = match progress.stage {
        0 => inverse_stage::<R, N>(z, circle, at, const { quarter::<N>(0) }),
        1 => inverse_stage::<R, N>(z, circle, at, const { quarter::<N>(1) }),
        2 => inverse_stage::<R, N>(z, circle, at, const { quarter::<N>(2) }),
        3 => inverse_stage::<R, N>(z, circle, at, const { quarter::<N>(3) }),
        4 => inverse_stage::<R, N>(z, circle, at, const { quarter::<N>(4) }),
        _ => inverse_stage::<R, N>(z, circle, at, const { quarter::<N>(5) }),
    };
    progress.at = at + 1;
    if !stage_done {
        return false;
    }
    progress.at = 0;
    if progress.stage == 0 {
        return true;
    }
    progress.stage -= 1;
    false
}

/// A slice of a forward stage; true when it was the stage's last.
#[inline(always)]
fn forward_stage<R: Real, const N: usize>(z: &mut [R; N], circle: &[Complex<R>; N], at: usize, quarter: usize) -> bool {
    let z = z.as_chunks_mut::<2>().0;
    if quarter == 0 {
        return sums_and_differences::<R, N>(z, at);
    }
    let (i, [w1, w2, w3]) = operands(circle, at, quarter);
    let [a, b, c, d] = [z[i], z[i | quarter], z[i | (2 * quarter)], z[i | (3 * quarter)]];
    let (e, f, g, h) = (add(a, c), sub(a, c), add(b, d), turned(sub(b, d)));
    z[i] = add(e, g);
    z[i | quarter] = mul(sub(e, g), w2);
    z[i | (2 * quarter)] = mul(add(f, h), w1);
    z[i | (3 * quarter)] = mul(sub(f, h), w3);
    at + 1 >= N / 8
}

/// A slice of an inverse stage; true when it was the stage's last.
#[inline(always)]
fn inverse_stage<R: Real, const N: usize>(z: &mut [R; N], circle: &[Complex<R>; N], at: usize, quarter: usize) -> bool {
    let z = z.as_chunks_mut::<2>().0;
    if quarter == 0 {
        return sums_and_differences::<R, N>(z, at);
    }
    let (i, [w1, w2, w3]) = operands(circle, at, quarter);
    let (a, b) = (z[i], mul_conj(z[i | quarter], w2));
    let (c, d) = (mul_conj(z[i | (2 * quarter)], w1), mul_conj(z[i | (3 * quarter)], w3));
    let (e, f, g, h) = (add(a, b), sub(a, b), add(c, d), turned(sub(c, d)));
    z[i] = add(e, g);
    z[i | (2 * quarter)] = sub(e, g);
    z[i | quarter] = sub(f, h);
    z[i | (3 * quarter)] = add(f, h);
    at + 1 >= N / 8
}

/// Index of the first of the four values of a butterfly, with zeros where the quarters are counted, and its three
/// twiddle factors.
#[inline(always)]
fn operands<R: Real, const N: usize>(circle: &[Complex<R>; N], at: usize, quarter: usize) -> (usize, [Complex<R>; 3]) {
    let within = at & (quarter - 1);
    let index = (((at << 2) & (N / 2 - 1) & !(4 * quarter - 1)) | within) & (N / 2 - 1);
    let turn = (within * (N / 4 / quarter)) & (N / 4 - 1);
    (index, [circle[turn], circle[2 * turn], circle[3 * turn]])
}

/// Four butterflies of the radix-2 stage; true when they were the last.
#[inline(always)]
fn sums_and_differences<R: Real, const N: usize>(z: &mut [Complex<R>], at: usize) -> bool {
    let first = (at << 3) & (N / 2 - 8);
    for i in [first, first | 2, first | 4, first | 6] {
        let (a, b) = (z[i], z[i | 1]);
        z[i] = add(a, b);
        z[i | 1] = sub(a, b);
    }
    at + 1 >= N / 16
}

/// The spectrum of the product at two harmonics, in the scale of the multipliers (times [`AMPLITUDE_SCALE`]: cosine and
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
pub(crate) fn pair_slice<R: Real, const N: usize>(
    from: &[R; N],
    to: &mut [R; N],
    circle: &[Complex<R>; N],
    multipliers: &[R; N],
    progress: &mut Progress,
) -> (Pair<R>, bool) {
    let (from, to, multipliers) = (from.as_chunks::<2>().0, to.as_chunks_mut::<2>().0, multipliers.as_chunks::<2>().0);
    let half = N / 2;
    let mask = half - 1;
    let (i, partner) = (progress.at & mask, progress.partner & mask);
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

    /// Multiplies a signal's spectrum slice by slice; returns the result, the spectrum seen in the pairs, and the slices.
    fn run<R: Real, const N: usize>(x: &[f64], of: impl Fn(usize) -> [f64; 2]) -> (Vec<f64>, Vec<[f64; 2]>, usize) {
        let circle = circle::<R, N>();
        let multipliers = multipliers::<R, N>(of);
        let mut z = [R::ZERO; N];
        for (to, from) in z.iter_mut().zip(x) {
            *to = R::of(*from);
        }
        let (mut slices, mut progress) = (1, Progress::forward());
        while !forward_slice(&mut z, &circle, &mut progress) {
            slices += 1;
        }
        let (mut out, mut spectrum) = ([R::ZERO; N], std::vec![[0.0; 2]; N / 2]);
        let mut progress = Progress::pairs();
        loop {
            slices += 1;
            let (pair, last) = pair_slice(&z, &mut out, &circle, &multipliers, &mut progress);
            for (k, x) in [(pair.low, pair.at_low), (pair.high, pair.at_high)] {
                spectrum[k] = x.map(|part| part.to_f64() * AMPLITUDE_SCALE);
            }
            if last {
                break;
            }
        }
        let mut progress = Progress::inverse::<N>();
        slices += 1;
        while !inverse_slice(&mut out, &circle, &mut progress) {
            slices += 1;
        }
        (out.iter().map(|x| x.to_f64()).collect(), spectrum, slices)
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
        let (double, found, slices) = run::<f64, N>(&x, of);
        assert!(worst(&double, &truth) < 1e-12, "{N} {:e}", worst(&double, &truth));
        for (a, b) in spectrum.iter().zip(&found) {
            assert!(worst(a, b) < 1e-13, "{N}");
        }
        let (single, _, _) = run::<f32, N>(&x, of);
        assert!(worst(&single, &truth) < 2e-6, "{N} {:e}", worst(&single, &truth));
        let half = N / 2;
        let (stages, left) = (half.ilog2() as usize / 2, half.ilog2() as usize % 2);
        assert_eq!(slices, 2 * (half / 4 * stages + left * half / 8) + half / 2);
    }

    /// The whole of it against rustfft: largest difference over largest value.
    fn against_rustfft<const N: usize>() {
        let x = signal(N);
        let of = |k: usize| [1.0 / (1.0 + k as f64 / 40.0), 0.3 * (k as f64 * 0.7).sin()];
        let mut buffer: Vec<_> = x.iter().map(|x| rustfft::num_complex::Complex::new(*x, 0.0)).collect();
        let mut planner = rustfft::FftPlanner::new();
        planner.plan_fft_forward(N).process(&mut buffer);
        for k in 0..N {
            let [re, im] = if k == 0 || k == N / 2 { [0.0; 2] } else { of(k.min(N - k)) };
            buffer[k] *= rustfft::num_complex::Complex::new(re, if k < N / 2 { im } else { -im }) / N as f64;
        }
        planner.plan_fft_inverse(N).process(&mut buffer);
        let truth: Vec<f64> = buffer.iter().map(|x| x.re).collect();
        let largest = truth.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let (double, _, _) = run::<f64, N>(&x, of);
        let (single, _, _) = run::<f32, N>(&x, of);
        let (double, single) = (worst(&double, &truth) / largest, worst(&single, &truth) / largest);
        std::println!("{N:5} points: {double:.1e} in f64, {single:.1e} in f32 from rustfft");
        assert!(double < 1e-12 && single < 1e-5, "{N}: {double:e} {single:e}");
    }

    #[test]
    fn all_lengths_agree_with_rustfft() {
        against_rustfft::<64>();
        against_rustfft::<128>();
        against_rustfft::<256>();
        against_rustfft::<512>();
        against_rustfft::<1024>();
        against_rustfft::<2048>();
        against_rustfft::<4096>();
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
