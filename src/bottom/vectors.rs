//! Loops compiled for the widest vectors that a processor has.

/// A loop over numbers that is compiled for each kind of processor.
pub trait VectorLoop {
    /// Result of the loop.
    type Output;

    /// Runs it. Every implementation, and every function that it calls in its loops, is marked
    /// `#[inline(always)]`: what is not inlined, a closure too, stays as compiled for what all
    /// processors have.
    fn run(self) -> Self::Output;
}

/// Runs a loop as compiled for the widest vectors of this processor. Numbers come out the same to
/// the bit.
pub fn vectorised<L: VectorLoop>(work: L) -> L::Output {
    pulp::Arch::new().dispatch(Work(work))
}

struct Work<L>(L);

impl<L: VectorLoop> pulp::WithSimd for Work<L> {
    type Output = L::Output;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> L::Output {
        self.0.run()
    }
}

/// The natural logarithm of a positive number that is neither subnormal nor infinite, to its last
/// bit or the one before: for loops of [`VectorLoop`], in which a call of the C library computes
/// one number at a time. The way and the coefficients are those of Sun Microsystems' fdlibm
/// (`e_logf.c`).
#[inline(always)]
pub fn ln(number: f32) -> f32 {
    // Bits of the square root of a half: the mantissa lies between that and the square root of two.
    const ROOT_OF_HALF: u32 = 0x3f35_04f3;
    let bits = number.to_bits();
    let exponent = (bits.wrapping_sub(ROOT_OF_HALF) as i32) >> 23;
    let more = f32::from_bits(bits.wrapping_sub((exponent << 23) as u32)) - 1.0;
    let half_square = 0.5 * more * more;
    let share = more / (2.0 + more);
    let square = share * share;
    let fourth = square * square;
    let odd = square * (0.666_666_6 + fourth * 0.284_987_87);
    let even = fourth * (0.400_009_72 + fourth * 0.242_790_79);
    let of_mantissa = more - (half_square - share * (half_square + (odd + even)));
    exponent as f32 * std::f32::consts::LN_2 + of_mantissa
}

#[cfg(test)]
mod tests {
    use super::ln;

    #[test]
    fn the_logarithm_is_that_of_double_precision() {
        let exponents = -126..=126_i32;
        let numbers = exponents.flat_map(|exponent| {
            (0..1000_u16).map(move |step| f32::from(1000 + step) / 1000.0 * 2f32.powi(exponent))
        });
        for number in numbers {
            let truth = f64::from(number).ln();
            let off = (f64::from(ln(number)) - truth).abs();
            assert!(off <= 1.5e-7 * truth.abs().max(1e-3), "{number}: {off}");
        }
        assert_eq!(ln(1.0), 0.0);
    }
}
