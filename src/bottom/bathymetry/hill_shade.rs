//! Draws a surface lit from the side, which shows small relief that colours of depth do not.

use super::Surface;
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;

/// Factors on the relief to choose from.
const EXAGGERATIONS: [f64; 6] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0];
/// Greatest slope of the steeper tenth of a surface after exaggeration: beyond it the picture is
/// all black and white.
const STEEP: f64 = 0.8;
/// Number of slopes examined to choose the exaggeration.
const SLOPES: usize = 50_000;

/// Direction of the light, and factor on the relief.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Direction of the light, degrees clockwise from grid north. Maps are lit from the north-west:
    /// with light from below, hills would be taken for hollows.
    pub azimuth_deg: f64,
    /// Height of the light over the horizon, degrees.
    pub altitude_deg: f64,
    /// Factor on the relief.
    pub exaggeration: f64,
}

impl Light {
    /// Returns light from the north-west, half-way up, with the factor of 1, 2, 5, 10, 20, 50 that
    /// suits the slopes of a surface.
    pub fn suited(surface: &Surface) -> Self {
        let step = (surface.grid.len() / SLOPES).max(1);
        let mut slopes: Vec<f64> = (0..surface.grid.len())
            .step_by(step)
            .filter_map(|cell| gradient(surface, cell))
            .map(|[east, north]| east.hypot(north))
            .collect();
        let last = slopes.len().saturating_sub(1);
        let steep = if slopes.is_empty() {
            STEEP
        } else {
            *slopes.select_nth_unstable_by(last * 9 / 10, f64::total_cmp).1
        };
        let suits = |factor: &f64| factor * steep <= STEEP;
        Self {
            azimuth_deg: 315.0,
            altitude_deg: 45.0,
            exaggeration: EXAGGERATIONS.into_iter().rfind(suits).unwrap_or(EXAGGERATIONS[0]),
        }
    }

    /// Returns the brightness of a level bottom, 1 to 255.
    pub fn level_ground(&self) -> u8 {
        brightness(self.altitude_deg.to_radians().sin())
    }
}

/// Returns the brightness of every cell, row by row: 1 (turned away from the light) to 255 (square
/// to it), 0 where the depth of the cell or of one of the eight around it is unknown.
///
/// The slope is Horn's (1981, Proc. IEEE 69): with cells `a b c / d e f / g h i` from the
/// north-west, the elevation rises eastwards by `((c + 2f + i) - (a + 2d + g)) / 8` a cell and
/// northwards by `((a + 2b + c) - (g + 2h + i)) / 8`. The cosine of the angle to the light is
/// spread over 1 to 255, as `gdaldem hillshade` does.
///
/// # Errors
/// When the work was cancelled.
pub fn hill_shade(
    surface: &Surface,
    light: &Light,
    progress: &Progress,
) -> Result<Vec<u8>, Cancelled> {
    let (sin_azimuth, cos_azimuth) = light.azimuth_deg.to_radians().sin_cos();
    let (sin_altitude, cos_altitude) = light.altitude_deg.to_radians().sin_cos();
    let columns = surface.grid.columns;
    let mut shade = vec![0; surface.grid.len()];
    shade.par_chunks_mut(columns.max(1)).enumerate().try_for_each(|(row, cells)| {
        progress.check()?;
        for (column, cell) in cells.iter_mut().enumerate() {
            if let Some(slope) = gradient(surface, row * columns + column) {
                let [east, north] = slope.map(|slope| slope * light.exaggeration);
                let across = east * sin_azimuth + north * cos_azimuth;
                let cosine = (sin_altitude - cos_altitude * across)
                    / (1.0 + east * east + north * north).sqrt();
                *cell = brightness(cosine);
            }
        }
        Ok(())
    })?;
    Ok(shade)
}

fn brightness(cosine: f64) -> u8 {
    (1.0 + 254.0 * cosine.max(0.0)).round() as u8
}

/// Returns the rise of the bottom eastwards and northwards, metres a metre; `None` where a depth
/// that counts is unknown.
fn gradient(surface: &Surface, cell: usize) -> Option<[f64; 2]> {
    let columns = surface.grid.columns;
    let (row, column) = (cell / columns, cell % columns);
    let inside = |place: usize, count: usize| (1..count.saturating_sub(1)).contains(&place);
    if !(inside(row, surface.grid.rows) && inside(column, columns)) {
        return None;
    }
    let rise_m = |cell: usize| -f64::from(surface.depth_m[cell]);
    let [north, here, south] = [cell - columns, cell, cell + columns];
    let along = |cell: usize| rise_m(cell - 1) + 2.0 * rise_m(cell) + rise_m(cell + 1);
    let beside = |column: usize| {
        rise_m(north - 1 + column) + 2.0 * rise_m(here - 1 + column) + rise_m(south - 1 + column)
    };
    let over_m = 8.0 * surface.grid.cell_m;
    let slope = [(beside(2) - beside(0)) / over_m, (along(north) - along(south)) / over_m];
    let known = slope.iter().all(|slope| slope.is_finite()) && rise_m(here).is_finite();
    known.then_some(slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bathymetry::Grid;

    /// `depth = 3 + 0.4 sin(0.9 column) + 0.3 cos(1.3 row + 0.2 column)` to the millimetre, one
    /// cell unknown.
    fn waves() -> Surface {
        let (rows, columns) = (7, 6);
        let depth_m = |cell: usize| {
            let (row, column) = ((cell / columns) as f64, (cell % columns) as f64);
            let wave = 0.4 * (0.9 * column).sin() + 0.3 * (1.3 * row + 0.2 * column).cos();
            (((3.0 + wave) * 1000.0).round() / 1000.0) as f32
        };
        let mut depth_m: Vec<f32> = (0..rows * columns).map(depth_m).collect();
        depth_m[5 * columns + 4] = f32::NAN;
        let grid = Grid::at([100.0, 200.0], 0.5, [columns, rows]);
        Surface::of_depths(grid, depth_m)
    }

    #[test]
    fn the_shade_is_that_of_gdaldem() {
        // gdaldem hillshade -az 315 -alt 45 -z 1 and -z 5 (GDAL 3.6.2), on the elevations (minus
        // the depths).
        #[rustfmt::skip]
        let goldens = [
            (1.0, [0,0,0,0,0,0, 0,179,240,254,253,0, 0,147,207,216,201,0, 0,54,109,138,136,0, 0,57,138,0,0,0,
                   0,151,230,0,0,0, 0,0,0,0,0,0]),
            (5.0, [0,0,0,0,0,0, 0,101,213,217,218,0, 0,32,249,174,146,0, 0,1,1,37,33,0, 0,1,6,0,0,0,
                   0,43,238,0,0,0, 0,0,0,0,0,0]),
        ];
        for (exaggeration, golden) in goldens {
            let light = Light { azimuth_deg: 315.0, altitude_deg: 45.0, exaggeration };
            let shade = hill_shade(&waves(), &light, &Progress::new()).unwrap();
            for (cell, (ours, theirs)) in shade.iter().zip(golden).enumerate() {
                assert!(ours.abs_diff(theirs) <= 1, "{cell}: {ours}, {theirs}");
                assert_eq!(*ours == 0, theirs == 0, "{cell}");
            }
        }
    }

    #[test]
    fn flat_ground_takes_more_exaggeration_than_steep() {
        let mut surface = waves();
        assert_eq!(Light::suited(&surface).exaggeration, 1.0);
        for depth_m in &mut surface.depth_m {
            *depth_m *= 0.05;
        }
        let light = Light::suited(&surface);
        assert!(light.exaggeration >= 10.0, "{light:?}");
        assert_eq!(light.level_ground(), 181);
        surface.depth_m.fill(f32::NAN);
        assert_eq!(Light::suited(&surface).exaggeration, 1.0);
    }
}
