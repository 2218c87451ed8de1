//! Computes elementary functions with IEEE 754 operations alone, so that a scene gives the same
//! bytes on every machine.
//!
//! The standard library's `ln`, `exp`, `sin` and `atan` call the system's math library, whose last
//! digit differs between systems. The functions here agree with them to about 1e-9, far below the
//! resolution of a recorder's byte.

use std::f64::consts::{FRAC_PI_2, LN_2, LN_10, PI, SQRT_2};

/// Returns the natural logarithm of a positive normal number.
pub(super) fn ln(x: f64) -> f64 {
    let bits = x.to_bits();
    let mut exponent = ((bits >> 52) & 0x7ff) as f64 - 1023.0;
    let mut mantissa = f64::from_bits((bits & 0x000f_ffff_ffff_ffff) | 0x3ff0_0000_0000_0000);
    if mantissa > SQRT_2 {
        mantissa *= 0.5;
        exponent += 1.0;
    }
    // ln m = 2 atanh((m - 1) / (m + 1)), with the argument below 0.172.
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let q = s * s;
    let series = 1.0 + q * (1.0 / 3.0 + q * (0.2 + q * (1.0 / 7.0 + q * (1.0 / 9.0 + q / 11.0))));
    exponent * LN_2 + 2.0 * s * series
}

/// Returns e to the power of `x`; 0 for `x` below -700, e to the power of 700 for `x` above 700.
pub(super) fn exp(x: f64) -> f64 {
    if x < -700.0 {
        return 0.0;
    }
    let whole = (x.min(700.0) / LN_2).round();
    let rest = x.min(700.0) - whole * LN_2;
    // Taylor series; |rest| <= 0.347.
    let mut series = 1.0;
    for order in [9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0] {
        series = 1.0 + series * rest / order;
    }
    series * f64::from_bits(((whole as i64 + 1023) as u64) << 52)
}

/// Returns 10 to the power of `decibel / 10`.
pub(super) fn from_db(decibel: f64) -> f64 {
    exp(decibel * (LN_10 / 10.0))
}

/// Returns ten times the decimal logarithm of a positive number.
pub(super) fn to_db(power: f64) -> f64 {
    ln(power) * (10.0 / LN_10)
}

/// Returns the sine of an angle in radians.
pub(super) fn sin(x: f64) -> f64 {
    let half_turns = (x / PI).round();
    let r = x - half_turns * PI;
    let q = r * r;
    // Taylor series; |r| <= pi / 2.
    let mut series = 1.0;
    for order in [12.0, 10.0, 8.0, 6.0, 4.0, 2.0] {
        series = 1.0 - series * q / (order * (order + 1.0));
    }
    let odd = half_turns.rem_euclid(2.0) == 1.0;
    if odd { -r * series } else { r * series }
}

/// Returns the cosine of an angle in radians.
pub(super) fn cos(x: f64) -> f64 {
    sin(x + FRAC_PI_2)
}

/// Returns the arc tangent, radians.
pub(super) fn atan(x: f64) -> f64 {
    // Three halvings of the angle bring the argument below 0.2.
    let halved = |x: f64| x / (1.0 + (1.0 + x * x).sqrt());
    let s = halved(halved(halved(x)));
    let q = s * s;
    let series = 1.0 - q * (1.0 / 3.0 - q * (0.2 - q * (1.0 / 7.0 - q * (1.0 / 9.0 - q / 11.0))));
    8.0 * s * series
}

/// Returns the direction of the vector (`east`, `north`), radians clockwise from north, 0 to 2 pi;
/// 0 for the zero vector.
pub(super) fn bearing(east: f64, north: f64) -> f64 {
    let length = (east * east + north * north).sqrt();
    if length == 0.0 {
        return 0.0;
    }
    // The half-angle formula needs no cases for quadrants; it fails only at due south.
    let angle = if north <= -length { PI } else { 2.0 * atan(east / (length + north)) };
    angle.rem_euclid(2.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_close(ours: f64, theirs: f64, x: f64) {
        let scale = theirs.abs().max(1.0);
        assert!((ours - theirs).abs() < 2e-9 * scale, "{x}: {ours} {theirs}");
    }

    #[test]
    fn functions_agree_with_the_system_library() {
        for step in -4000..4000 {
            let x = f64::from(step) * 0.0173 + 0.0031;
            assert_close(sin(x), x.sin(), x);
            assert_close(cos(x), x.cos(), x);
            assert_close(atan(x), x.atan(), x);
            assert_close(exp(x), x.exp(), x);
            assert_close(ln(x.abs()), x.abs().ln(), x);
            assert_close(from_db(x), 10f64.powf(x / 10.0), x);
        }
    }

    #[test]
    fn bearing_is_clockwise_from_north() {
        for (east, north, degrees) in [
            (0.0, 1.0, 0.0_f64),
            (1.0, 0.0, 90.0),
            (0.0, -1.0, 180.0),
            (-1.0, 0.0, 270.0),
            (-1.0, 1.0, 315.0),
        ] {
            assert_close(bearing(east, north), degrees.to_radians(), degrees);
        }
    }
}
