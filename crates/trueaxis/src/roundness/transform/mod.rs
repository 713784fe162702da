//! A real transform of N points that can pause after every few operations.
//!
//! N real values are M = N/2 complex ones, z_i = x_2i + j x_2i+1. The forward transform is decimation in frequency, radix 4:
//! natural order in, bit-reversed out. Multiplying the real signal's spectrum by C(k) takes one pass over the pairs (k, M − k)
//! of z's spectrum Z, without separating and joining:
//!
//! ```text
//! Z'_k = P Z_k + Q (j c Z*_{M−k} − s Z_k)     P = (C(k) + C*(M−k))/2     c − js = e^{−j2πk/N}
//! Z'*_{M−k} = P Z*_{M−k} + Q (s Z*_{M−k} − j c Z_k)     Q = (C(k) − C*(M−k))/2
//! ```
//!
//! The inverse is decimation in time, radix 4: bit-reversed in, natural out. No pass permutes values: in bit-reversed
//! order the partner of index i in [b, 2b), b a power of two, is 3b − 1 − i. If M is not a power of four, one radix-2
//! stage is added next to the pair pass.
//!
//! A slice is one radix-4 butterfly, two butterflies of the last stage, whose twiddle factors are eighths of a turn, four
//! radix-2 butterflies, or one pair: at most 24 multiplications and 44 additions. The whole transform takes
//! `2·(M/4·(⌊log4 M⌋ − ½) [+ M/8]) + M/2` slices.
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

/// P and Q of the multipliers C(k), `[P.re, P.im, Q.re, Q.im]` pair by pair, the first of [`Pairs`] last; they include the
/// scale of the inverse.
///
/// `of` returns the multiplier of a harmonic, `[re, im]`; mean and Nyquist frequency are always removed.
pub(crate) fn multipliers<R: Real, const N: usize>(of: impl Fn(usize) -> [f64; 2]) -> [R; N] {
    let mut table = [R::ZERO; N];
    let mut pairs = Pairs::START;
    for value in table.as_chunks_mut::<4>().0.iter_mut().rev() {
        let k = harmonic::<N>(pairs.at);
        let ([a, b], [c, d]) = (of(k), of(N / 2 - k));
        *value = [a + c, b - d, a - c, b + d].map(|part| R::of(part / N as f64));
        pairs.next();
    }
    table
}

/// Distance between the values of a butterfly in a radix-4 stage, a quarter of its block; 0 after the last stage. Stages are
/// numbered in the order of the forward transform.
pub(crate) const fn quarter<const N: usize>(stage: usize) -> usize {
    (N / 8) >> (2 * stage)
}

/// Number of slices of a radix-4 stage, 0 if it does not exist.
pub(crate) const fn slices<const N: usize>(stage: usize) -> usize {
    match quarter::<N>(stage) {
        0 => 0,
        // The last stage: two butterflies a slice.
        1 | 2 => N / 16,
        _ => N / 8,
    }
}

/// Number of slices of the radix-2 stage, 0 if the transform needs none.
pub(crate) const fn slices_of_twos<const N: usize>() -> usize {
    if (N / 2).trailing_zeros() % 2 == 1 { N / 16 } else { 0 }
}

/// Harmonic at an index in bit-reversed order; also the index of a harmonic.
#[inline(always)]
fn harmonic<const N: usize>(index: usize) -> usize {
    let half = N / 2;
    (index.reverse_bits() >> (half.leading_zeros() + 1)) & (half - 1)
}

/// Progress of a pair pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Pairs {
    /// First index of the block, a power of two.
    block: usize,
    at: usize,
    partner: usize,
}

impl Pairs {
    /// State before a pass has begun.
    pub(crate) const NONE: Pairs = Pairs { block: 0, at: 0, partner: 0 };
    /// State before the first pair: index 1, which is its own partner.
    pub(crate) const START: Pairs = Pairs { block: 1, at: 1, partner: 1 };

    /// Moves to the next pair.
    #[inline(always)]
    fn next(&mut self) {
        self.at += 1;
        self.partner = self.partner.wrapping_sub(1);
        // Half of [b, 2b) has been paired with the other half; or index 1 is done.
        if self.at > self.partner {
            self.block *= 2;
            (self.at, self.partner) = (self.block, 2 * self.block - 1);
        }
    }
}

/// Computes one slice of a forward stage: a butterfly, or two of the last stage.
#[inline(always)]
pub(crate) fn forward_slice<R: Real, const N: usize>(
    z: &mut [R; N],
    circle: &[Complex<R>; N],
    at: usize,
    quarter: usize,
) {
    let z = z.as_chunks_mut::<2>().0;
    if quarter <= 2 {
        let Some(z) = z.as_chunks_mut::<8>().0.get_mut(at & (N / 16 - 1)) else { return };
        return last_forward(z, quarter);
    }
    let (i, [w1, w2, w3]) = operands(circle, at, quarter);
    let [a, b, c, d] = [z[i], z[i | quarter], z[i | (2 * quarter)], z[i | (3 * quarter)]];
    let (e, f, g, h) = (add(a, c), sub(a, c), add(b, d), turned(sub(b, d)));
    z[i] = add(e, g);
    z[i | quarter] = mul(sub(e, g), w2);
    z[i | (2 * quarter)] = mul(add(f, h), w1);
    z[i | (3 * quarter)] = mul(sub(f, h), w3);
}

/// Computes one slice of an inverse stage: a butterfly, or two of the last stage; unscaled.
#[inline(always)]
pub(crate) fn inverse_slice<R: Real, const N: usize>(
    z: &mut [R; N],
    circle: &[Complex<R>; N],
    at: usize,
    quarter: usize,
) {
    let z = z.as_chunks_mut::<2>().0;
    if quarter <= 2 {
        let Some(z) = z.as_chunks_mut::<8>().0.get_mut(at & (N / 16 - 1)) else { return };
        return first_inverse(z, quarter);
    }
    let (i, [w1, w2, w3]) = operands(circle, at, quarter);
    let (a, b) = (z[i], mul_conj(z[i | quarter], w2));
    let (c, d) = (mul_conj(z[i | (2 * quarter)], w1), mul_conj(z[i | (3 * quarter)], w3));
    let (e, f, g, h) = (add(a, b), sub(a, b), add(c, d), turned(sub(c, d)));
    z[i] = add(e, g);
    z[i | (2 * quarter)] = sub(e, g);
    z[i | quarter] = sub(f, h);
    z[i | (3 * quarter)] = add(f, h);
}

/// Two butterflies of the last stage, on eight adjacent values: the twiddle factors are 1 or, for the second of two
/// overlapping butterflies, eighths of a turn.
#[inline(always)]
fn last_forward<R: Real>(z: &mut [Complex<R>; 8], quarter: usize) {
    let overlap = quarter == 2;
    for (within, [i, j, k, l]) in pairs_of_butterflies(quarter) {
        let [a, b, c, d] = [z[i], z[j], z[k], z[l]];
        let (e, f, g, h) = (add(a, c), sub(a, c), add(b, d), turned(sub(b, d)));
        let (third, fourth) = (add(f, h), sub(f, h));
        z[i] = add(e, g);
        [z[j], z[k], z[l]] = if within && overlap {
            // −j (e − g).
            [[e[1] - g[1], g[0] - e[0]], eighth(third), turned(eighth(fourth))]
        } else {
            [sub(e, g), third, fourth]
        };
    }
}

/// Inverse of [`last_forward`] except for the scale.
#[inline(always)]
fn first_inverse<R: Real>(z: &mut [Complex<R>; 8], quarter: usize) {
    let overlap = quarter == 2;
    for (within, [i, j, k, l]) in pairs_of_butterflies(quarter) {
        let [a, mut b, mut c, mut d] = [z[i], z[j], z[k], z[l]];
        if within && overlap {
            (b, c, d) = (turned_back(b), eighth_back(c), eighth_back(turned_back(d)));
        }
        let (e, f, g, h) = (add(a, b), sub(a, b), add(c, d), turned(sub(c, d)));
        z[i] = add(e, g);
        z[k] = sub(e, g);
        z[j] = sub(f, h);
        z[l] = add(f, h);
    }
}

/// Indices of the values of two butterflies among eight; marks the second.
const fn pairs_of_butterflies(quarter: usize) -> [(bool, [usize; 4]); 2] {
    if quarter == 2 {
        [(false, [0, 2, 4, 6]), (true, [1, 3, 5, 7])]
    } else {
        [(false, [0, 1, 2, 3]), (true, [4, 5, 6, 7])]
    }
}

/// j·a.
#[inline(always)]
fn turned_back<R: Real>(a: Complex<R>) -> Complex<R> {
    [-a[1], a[0]]
}

/// a·e^{−jπ/4}.
#[inline(always)]
fn eighth<R: Real>([re, im]: Complex<R>) -> Complex<R> {
    let half_root = R::of(core::f64::consts::FRAC_1_SQRT_2);
    [(re + im) * half_root, (im - re) * half_root]
}

/// a·e^{jπ/4}.
#[inline(always)]
fn eighth_back<R: Real>([re, im]: Complex<R>) -> Complex<R> {
    let half_root = R::of(core::f64::consts::FRAC_1_SQRT_2);
    [(re - im) * half_root, (re + im) * half_root]
}

/// Index of the first of a butterfly's four values, with zeros in the bits that count the quarters, and its three twiddle
/// factors.
#[inline(always)]
fn operands<R: Real, const N: usize>(circle: &[Complex<R>; N], at: usize, quarter: usize) -> (usize, [Complex<R>; 3]) {
    let within = at & (quarter - 1);
    let index = (((at << 2) & (N / 2 - 1) & !(4 * quarter - 1)) | within) & (N / 2 - 1);
    let turn = (within * (N / 4 / quarter)) & (N / 4 - 1);
    (index, [circle[turn], circle[2 * turn], circle[3 * turn]])
}

/// Computes one slice of the radix-2 stage, four butterflies, in either direction.
#[inline(always)]
pub(crate) fn twos_slice<R: Real, const N: usize>(z: &mut [R; N], at: usize) {
    let z = z.as_chunks_mut::<2>().0;
    let first = (at << 3) & (N / 2 - 8);
    for i in [first, first | 2, first | 4, first | 6] {
        let (a, b) = (z[i], z[i | 1]);
        z[i] = add(a, b);
        z[i | 1] = sub(a, b);
    }
}

/// Computes one pair: the spectrum in `from` times the multipliers, into `to`. Pairs are numbered downwards. [`without_mean`]
/// must follow the last one.
#[inline(always)]
pub(crate) fn pair_slice<R: Real, const N: usize>(
    from: &[R; N],
    to: &mut [R; N],
    circle: &[Complex<R>; N],
    multipliers: &[R; N],
    pairs: &mut Pairs,
    at: usize,
) {
    let (from, to) = (from.as_chunks::<2>().0, to.as_chunks_mut::<2>().0);
    let mask = N / 2 - 1;
    let (i, partner) = (pairs.at & mask, pairs.partner & mask);
    let [p_re, p_im, q_re, q_im] = multipliers.as_chunks::<4>().0[at & (N / 4 - 1)];
    // c and −s.
    let [c, s] = circle[harmonic::<N>(i)];
    let (a, b) = (from[i], conj(from[partner]));
    let x = [s * a[0] - c * b[1], s * a[1] + c * b[0]];
    let y = [c * a[1] - s * b[0], c * a[0] + s * b[1]];
    // Sums from left to right become one multiply-add each. The second value is conjugate.
    to[i] =
        [p_re * a[0] - p_im * a[1] + q_re * x[0] - q_im * x[1], p_re * a[1] + p_im * a[0] + q_re * x[1] + q_im * x[0]];
    to[partner] =
        [p_re * b[0] - p_im * b[1] + q_re * y[0] + q_im * y[1], q_re * y[1] - p_re * b[1] - p_im * b[0] - q_im * y[0]];
    pairs.next();
}

/// Removes the mean after the pairs, which do not include it.
pub(crate) fn without_mean<R: Real, const N: usize>(z: &mut [R; N]) {
    (z[0], z[1]) = (R::ZERO, R::ZERO);
}

/// The real signal's spectrum at harmonic k, 0 < k < M, from the result of the pair pass, in the scale of the inverse (times
/// [`AMPLITUDE_SCALE`]: cosine and negative sine amplitude).
#[inline(always)]
pub(crate) fn spectrum<R: Real, const N: usize>(z: &[R; N], circle: &[Complex<R>; N], k: usize) -> Complex<R> {
    let z = z.as_chunks::<2>().0;
    let mask = N / 2 - 1;
    let (a, b) = (z[harmonic::<N>(k & mask)], conj(z[harmonic::<N>((N / 2 - k) & mask)]));
    add(add(a, b), mul(turned(sub(a, b)), circle[k & mask]))
}

/// Factor from spectrum to amplitude: x contains a cos kθ − b sin kθ if this times X is `[a, b]`.
pub(crate) const AMPLITUDE_SCALE: f64 = 0.5;

#[cfg(test)]
mod index_maps;

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Most radix-4 stages: 4096 points.
    const STAGES: usize = 5;

    /// Multiplies a signal's spectrum slice by slice; returns the result, the spectrum from the pairs, and the number of
    /// slices.
    fn run<R: Real, const N: usize>(x: &[f64], of: impl Fn(usize) -> [f64; 2]) -> (Vec<f64>, Vec<[f64; 2]>, usize) {
        let circle = circle::<R, N>();
        let multipliers = multipliers::<R, N>(of);
        let mut z = [R::ZERO; N];
        for (to, from) in z.iter_mut().zip(x) {
            *to = R::of(*from);
        }
        let mut count = 0;
        for stage in 0..STAGES {
            for at in (0..slices::<N>(stage)).rev() {
                forward_slice(&mut z, &circle, at, quarter::<N>(stage));
                count += 1;
            }
        }
        for at in 0..slices_of_twos::<N>() {
            twos_slice(&mut z, at);
            count += 1;
        }
        let (mut out, mut amplitudes) = ([R::ZERO; N], std::vec![[0.0; 2]; N / 2]);
        let mut pairs = Pairs::START;
        for at in (0..N / 4).rev() {
            pair_slice(&z, &mut out, &circle, &multipliers, &mut pairs, at);
            count += 1;
        }
        without_mean(&mut out);
        for (k, amplitude) in amplitudes.iter_mut().enumerate().skip(1) {
            *amplitude = spectrum(&out, &circle, k).map(|part| part.to_f64() * AMPLITUDE_SCALE);
        }
        for at in 0..slices_of_twos::<N>() {
            twos_slice(&mut out, at);
            count += 1;
        }
        for stage in (0..STAGES).rev() {
            for at in 0..slices::<N>(stage) {
                inverse_slice(&mut out, &circle, at, quarter::<N>(stage));
                count += 1;
            }
        }
        (out.iter().map(|x| x.to_f64()).collect(), amplitudes, count)
    }

    fn signal(n: usize) -> Vec<f64> {
        (0..n).map(|i| ((i * i * 7 + 13 * i) % 101) as f64 / 50.0 - 1.0).collect()
    }

    /// The definition of the product, term by term.
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
        assert_eq!(slices, 2 * (half / 4 * (stages - 1) + (1 + left) * half / 8) + half / 2);
    }

    /// Compares the whole transform with rustfft: largest difference over largest value.
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

    /// Every index but 0 occurs once, with the partner that has the mirrored harmonic; no two butterflies of a stage share a
    /// value.
    fn maps<const N: usize>() {
        let half = N / 2;
        let (mut met, mut pairs) = (std::vec![0; half], Pairs::START);
        for _ in 0..N / 4 {
            let (k, mirrored) = (harmonic::<N>(pairs.at), harmonic::<N>(pairs.partner));
            assert_eq!((k + mirrored, k.reverse_bits() >> (half.leading_zeros() + 1)), (half, pairs.at), "{N}");
            met[pairs.at] += 1;
            met[pairs.partner] += usize::from(pairs.partner != pairs.at);
            pairs.next();
        }
        assert_eq!(pairs.at, half, "{N}");
        assert!(met[0] == 0 && met[1..].iter().all(|count| *count == 1), "{N}");
        let circle = circle::<f64, N>();
        let mut bits = half.trailing_zeros();
        for stage in (0..STAGES).filter(|stage| slices::<N>(*stage) > 0) {
            let (quarter, mut met) = (quarter::<N>(stage), std::vec![0; half]);
            for (at, (_, indices)) in (0..slices::<N>(stage))
                .flat_map(|at| pairs_of_butterflies(quarter).map(|butterfly| (at, butterfly)))
                .filter(|_| quarter <= 2)
            {
                indices.iter().for_each(|index| met[8 * at + index] += 1);
            }
            for at in (0..slices::<N>(stage)).filter(|_| quarter > 2) {
                let (i, [w1, w2, w3]) = operands(&circle, at, quarter);
                (0..4).for_each(|part| met[i | (part * quarter)] += 1);
                let angle = -TAU * (i % quarter) as f64 / (4 * quarter) as f64;
                for (power, w) in [(1.0, w1), (2.0, w2), (3.0, w3)] {
                    assert!(worst(&w, &[(power * angle).cos(), (power * angle).sin()]) < 1e-14, "{N} {stage} {at}");
                }
            }
            assert!(met.iter().all(|count| *count == 1), "{N} {stage}");
            bits -= 2;
        }
        assert_eq!(bits == 1, slices_of_twos::<N>() > 0, "{N}");
    }

    #[test]
    fn all_indices_are_met_once() {
        maps::<64>();
        maps::<128>();
        maps::<256>();
        maps::<512>();
        maps::<1024>();
        maps::<2048>();
        maps::<4096>();
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
