//! Correctly rounded square roots on every target, using the processor's instruction if it has one.
//!
//! On stable Rust, `core` has no square root without std, and `libm` takes some 50 instructions (single precision) or
//! 90 (double) on a Cortex-M, where the floating-point unit takes one. Both round correctly (IEEE 754), so the result
//! is identical to the last bit. The instruction needs assembly, hence a separate crate: the plugin itself forbids
//! `unsafe`.
#![no_std]

/// √x in single precision; NaN for x < 0.
#[inline(always)]
#[must_use]
pub fn sqrt_f32(x: f32) -> f32 {
    // The hard-float ABI of bare-metal Arm implies at least a single-precision unit.
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    {
        let mut bits = x.to_bits();
        // SAFETY: instructions that the ABI guarantees, on registers; s0 is restored. The compiler provides floating-point
        // registers to assembly only if the unit is a full one, so s0 is saved by hand.
        unsafe {
            core::arch::asm!(
                "vmov {kept}, s0",
                "vmov s0, {bits}",
                "vsqrt.f32 s0, s0",
                "vmov {bits}, s0",
                "vmov s0, {kept}",
                bits = inout(reg) bits,
                kept = out(reg) _,
                options(pure, nomem, nostack)
            );
        }
        f32::from_bits(bits)
    }
    #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
    libm::sqrtf(x)
}

/// √ of both in single precision; NaN for negative values. Saves one move per root over two calls of [`sqrt_f32`].
#[inline(always)]
#[must_use]
pub fn sqrt_two_f32([x, y]: [f32; 2]) -> [f32; 2] {
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    {
        let (mut x, mut y) = (x.to_bits(), y.to_bits());
        // SAFETY: as above, with s0 and s1.
        unsafe {
            core::arch::asm!(
                "vmov {kept_x}, {kept_y}, s0, s1",
                "vmov s0, s1, {x}, {y}",
                "vsqrt.f32 s0, s0",
                "vsqrt.f32 s1, s1",
                "vmov {x}, {y}, s0, s1",
                "vmov s0, s1, {kept_x}, {kept_y}",
                x = inout(reg) x,
                y = inout(reg) y,
                kept_x = out(reg) _,
                kept_y = out(reg) _,
                options(pure, nomem, nostack)
            );
        }
        [f32::from_bits(x), f32::from_bits(y)]
    }
    #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
    [sqrt_f32(x), sqrt_f32(y)]
}

/// √x in double precision; NaN for x < 0.
#[inline(always)]
#[must_use]
pub fn sqrt_f64(x: f64) -> f64 {
    #[cfg(all(target_arch = "arm", target_abi = "eabihf", feature = "fp64"))]
    {
        let bits = x.to_bits();
        let (mut low, mut high) = (bits as u32, (bits >> 32) as u32);
        // SAFETY: as above, with d0; enabling the feature asserts that the core has a double-precision unit.
        unsafe {
            core::arch::asm!(
                "vmov {kept_low}, {kept_high}, d0",
                "vmov d0, {low}, {high}",
                "vsqrt.f64 d0, d0",
                "vmov {low}, {high}, d0",
                "vmov d0, {kept_low}, {kept_high}",
                low = inout(reg) low,
                high = inout(reg) high,
                kept_low = out(reg) _,
                kept_high = out(reg) _,
                options(pure, nomem, nostack)
            );
        }
        f64::from_bits(u64::from(high) << 32 | u64::from(low))
    }
    #[cfg(not(all(target_arch = "arm", target_abi = "eabihf", feature = "fp64")))]
    libm::sqrt(x)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    /// Compares with std's root in 4096 steps over exponents and odd mantissas, without 0, NaN and infinity.
    #[test]
    fn correctly_rounded() {
        for i in 1..4096u32 {
            let single = f32::from_bits(i * 522_111 % 0x7f80_0000);
            let double = f64::from_bits(u64::from(i) * 2_251_799_813_685_119 % 0x7ff0_0000_0000_0000);
            assert_eq!(sqrt_f32(single), std::primitive::f32::sqrt(single), "{single:e}");
            assert_eq!(sqrt_f64(double), std::primitive::f64::sqrt(double), "{double:e}");
            let (single, double) = (i as f32, f64::from(i));
            assert_eq!((sqrt_f32(single * single), sqrt_f64(double * double)), (single, double));
        }
        assert!(sqrt_f32(-1.0).is_nan() && sqrt_f64(-1.0).is_nan());
    }
}

/// Compiles and runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
