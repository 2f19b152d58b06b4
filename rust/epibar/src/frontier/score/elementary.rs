//! Elementary functions that the compiler can vectorise, and that give the same bits on every machine.
//!
//! Polynomials with an error below 10⁻⁹; the C library's are exact to the last place, differ between libraries, and were a
//! quarter of the time of a score.

use std::f64::consts::{FRAC_PI_2, LN_2, LOG2_E, PI, SQRT_2};

/// `atan(t) / t` in powers of `t²` on [0, 1].
const ARC_TANGENT: [f64; 11] = [
    0.999_999_999_615_5,
    -0.333_333_236_722_7,
    0.199_995_959_865_2,
    -0.142_790_496_18,
    0.110_537_906_945_5,
    -0.087_961_350_448_07,
    0.067_101_458_473_39,
    -0.044_274_028_941_81,
    0.022_203_700_064_61,
    -0.007_166_255_512_693,
    0.001_084_506_518_04,
];

/// Adding it leaves a whole number in the lowest bits.
const WHOLE: f64 = 6_755_399_441_055_744.0;
/// Bits of 2⁵².
const TWO_52: u64 = 0x4330_0000_0000_0000;

#[inline(always)]
fn polynomial<const N: usize>(coefficients: &[f64; N], x: f64) -> f64 {
    let mut value = coefficients[N - 1];
    for k in (0..N - 1).rev() {
        value = value * x + coefficients[k];
    }
    value
}

/// The angle of `(x, y)` in (−π, π]; 0 for the origin.
#[inline(always)]
pub(super) fn angle(y: f64, x: f64) -> f64 {
    let (across, along) = (y.abs(), x.abs());
    let (short, long) = if across < along { (across, along) } else { (along, across) };
    let t = short / if long > 1e-300 { long } else { 1e-300 };
    let first = t * polynomial(&ARC_TANGENT, t * t);
    let quarter = if across < along { first } else { FRAC_PI_2 - first };
    let half = if x < 0.0 { PI - quarter } else { quarter };
    let whole = if y < 0.0 { -half } else { half };
    if long > 1e-300 { whole } else { 0.0 }
}

/// `exp(−x)` for `x ≥ 0`.
#[inline(always)]
pub(super) fn decay(x: f64) -> f64 {
    /// `1/k!`
    const TERMS: [f64; 11] = [
        1.0,
        1.0,
        0.5,
        1.0 / 6.0,
        1.0 / 24.0,
        1.0 / 120.0,
        1.0 / 720.0,
        1.0 / 5040.0,
        1.0 / 40_320.0,
        1.0 / 362_880.0,
        1.0 / 3_628_800.0,
    ];
    let x = if x < 700.0 { x } else { 700.0 };
    let shifted = -x * LOG2_E + WHOLE;
    let halvings = shifted - WHOLE;
    let rest = -x - halvings * LN_2;
    let power = f64::from_bits((shifted.to_bits().wrapping_add(1023)) << 52);
    power * polynomial(&TERMS, rest)
}

/// `ln x` for a normal `x > 0`.
#[inline(always)]
pub(crate) fn logarithm(x: f64) -> f64 {
    /// `artanh(s) = s (1 + s²/3 + …)`, twice.
    const TERMS: [f64; 7] = [2.0, 2.0 / 3.0, 2.0 / 5.0, 2.0 / 7.0, 2.0 / 9.0, 2.0 / 11.0, 2.0 / 13.0];
    let bits = x.to_bits();
    let mantissa = f64::from_bits(bits & 0x000f_ffff_ffff_ffff | 0x3ff0_0000_0000_0000);
    let exponent = f64::from_bits(bits >> 52 | TWO_52) - (f64::from_bits(TWO_52) + 1023.0);
    let above = mantissa > SQRT_2;
    let mantissa = if above { 0.5 * mantissa } else { mantissa };
    let exponent = if above { exponent + 1.0 } else { exponent };
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    exponent * LN_2 + s * polynomial(&TERMS, s * s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_the_exact_functions() {
        for i in 0..100_000 {
            let turn = (f64::from(i) - 50_000.0) * (PI / 50_000.0);
            let length = 10f64.powi(i % 13 - 6);
            let (y, x) = (length * turn.sin(), length * turn.cos());
            assert!((angle(y, x) - y.atan2(x)).abs() < 1e-9, "{turn}");
            let x = 1e-6 * 1.000_2f64.powi(i);
            assert!((decay(x) - (-x).exp()).abs() < 1e-11, "{x}");
            assert!((logarithm(x) - x.ln()).abs() < 1e-9, "{x}");
        }
        assert_eq!((angle(0.0, 0.0), angle(0.0, 2.0), decay(0.0)), (0.0, 0.0, 1.0));
        assert!((angle(0.0, -2.0) - PI).abs() < 1e-9 && (angle(-3.0, 0.0) + FRAC_PI_2).abs() < 1e-9);
        assert!(decay(1e9) > 0.0 && decay(1e9) < 1e-300);
    }
}
