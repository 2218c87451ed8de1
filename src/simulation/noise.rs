//! Smooth random fields over the ground: the same place has the same value from whichever line it
//! is surveyed.

use super::random::{RandomPurpose, mix};

/// Value noise: random numbers on a square lattice, smoothly interpolated between its points.
pub(super) struct NoiseField {
    key: u64,
    per_metre: f64,
}

/// Standard deviation of the interpolated field for lattice values between -1 and 1: sqrt(1/3) at
/// the lattice points, less between them (mean over a cell of the squared weights is 0.5515).
const SPREAD: f64 = 0.4288;

impl NoiseField {
    /// A field with lattice points `spacing_m` apart.
    pub(super) fn new(seed: u64, purpose: RandomPurpose, spacing_m: f64) -> Self {
        Self { key: mix(seed ^ mix(purpose as u64)), per_metre: 1.0 / spacing_m }
    }

    /// Value at a place: mean 0, standard deviation 1, never beyond 2.4.
    pub(super) fn at(&self, east_m: f64, north_m: f64) -> f64 {
        let (x, y) = (east_m * self.per_metre, north_m * self.per_metre);
        let (column, row) = (x.floor(), y.floor());
        let (u, v) = (smooth(x - column), smooth(y - row));
        let (column, row) = (column as i64, row as i64);
        let low = self.between(column, row, u);
        let high = self.between(column, row + 1, u);
        (low + (high - low) * v) / SPREAD
    }

    fn between(&self, column: i64, row: i64, u: f64) -> f64 {
        let left = self.lattice(column, row);
        left + (self.lattice(column + 1, row) - left) * u
    }

    fn lattice(&self, column: i64, row: i64) -> f64 {
        let place = (column as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (row as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        (mix(self.key ^ place) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Smooth step: 0 at 0, 1 at 1, flat at both ends; held beyond them.
pub(super) fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn field_has_unit_spread_and_is_continuous() {
        let field = NoiseField::new(3, RandomPurpose::Texture, 0.7);
        let places = 200;
        let (mut sum, mut squares, mut step) = (0.0, 0.0, 0.0_f64);
        for i in 0..places {
            for j in 0..places {
                let (east, north) = (f64::from(i) * 0.33 - 20.0, f64::from(j) * 0.37 - 30.0);
                let value = field.at(east, north);
                sum += value;
                squares += value * value;
                step = step.max((field.at(east + 1e-4, north) - value).abs());
            }
        }
        let count = f64::from(places * places);
        let spread = (squares / count - (sum / count).powi(2)).sqrt();
        assert!((sum / count).abs() < 0.05, "{}", sum / count);
        assert!((spread - 1.0).abs() < 0.05, "{spread}");
        assert!(step < 2e-3, "{step}");
    }
}
