//! Transforms of real series of N points, unscaled: `X_k = Σ x_n e^{−2πi kn/N}` for k from 0 to N/2, and back.
//!
//! realfft plans them, for any N. In a browser a complex radix-4 transform replaces it: N is always a power of two there, and
//! realfft's algorithms for all other lengths would enlarge the page.

#[cfg(any(test, not(target_family = "wasm")))]
mod planned;
#[cfg(any(test, target_family = "wasm"))]
mod radix4;

#[cfg(not(target_family = "wasm"))]
pub(super) use planned::Transforms;
#[cfg(target_family = "wasm")]
pub(super) use radix4::Transforms;

#[cfg(test)]
mod tests {
    use super::{planned, radix4};
    use realfft::num_complex::Complex;
    use std::vec::Vec;

    #[test]
    fn both_give_the_same() {
        for power in 6..=12 {
            let points = 1 << power;
            let (one, other) = (planned::Transforms::new(points).unwrap(), radix4::Transforms::new(points).unwrap());
            let scratch = || std::vec![Complex::default(); one.scratch().max(other.scratch())];
            let values: Vec<f64> =
                (0..points).map(|n| f64::from((n as u32).wrapping_mul(2_654_435_761) >> 8) / 1e7).collect();
            let spectra = [0, 1].map(|which| {
                let mut spectrum = std::vec![Complex::default(); points / 2 + 1];
                let (mut real, mut scratch) = (values.clone(), scratch());
                match which {
                    0 => one.forward(&mut real, &mut spectrum, &mut scratch),
                    _ => other.forward(&mut real, &mut spectrum, &mut scratch),
                }
                spectrum
            });
            let size = spectra[0].iter().map(|bin| bin.norm()).fold(0.0, f64::max);
            for (a, b) in spectra[0].iter().zip(&spectra[1]) {
                assert!((a - b).norm() < 1e-14 * size, "{points} points: {a} and {b}");
            }
            let mut series = std::vec![0.0; points];
            other.backward(&mut spectra[0].clone(), &mut series, &mut scratch());
            for (own, value) in series.iter().zip(&values) {
                assert!((own / points as f64 - value).abs() < 1e-13, "{points} points: {own} for {value}");
            }
        }
        assert!(radix4::Transforms::new(96).is_err());
    }
}
