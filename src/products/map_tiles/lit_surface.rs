//! Depths with their hill-shade, as tiles sample them.

use super::Pixel;
use bathyscope_bottom::bathymetry::{Light, Surface};

/// A surface, and how bright its cells are.
#[derive(Clone, Copy)]
pub(crate) struct LitSurface<'a> {
    surface: &'a Surface,
    /// Hill-shade of each cell from [`bathyscope_bottom::bathymetry::hill_shade`]: 0 where it is
    /// unknown.
    shade: &'a [u8],
    level_ground: f32,
}

impl<'a> LitSurface<'a> {
    /// Lit as `light` says, which the shade was made under.
    pub(crate) fn new(surface: &'a Surface, shade: &'a [u8], light: &Light) -> Self {
        Self { surface, shade, level_ground: f32::from(light.level_ground()) }
    }

    /// Returns the depth and the light at a place, metres east and north: the depth is interpolated
    /// between the centres of cells, or the depth of the cell where a neighbour has none. Ground
    /// whose slope is unknown is as bright as level ground. `None` where the cell has no depth.
    pub(crate) fn at(&self, place: [f64; 2]) -> Option<Pixel> {
        let cell = self.surface.grid.index_at(place[0], place[1])?;
        let of_cell = self.surface.depth_m.get(cell).copied();
        let known = of_cell.filter(|depth_m| !depth_m.is_nan())?;
        let depth_m = self.surface.depth_at(place).unwrap_or(known);
        let light = match self.shade.get(cell) {
            Some(&shade) if shade > 0 => f32::from(shade) / self.level_ground,
            _ => 1.0,
        };
        Some(Pixel { depth_m, light })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_bottom::bathymetry::{Grid, hill_shade};
    use bathyscope_log::support::progress::Progress;

    #[test]
    fn a_place_has_the_depth_and_the_light_of_the_map() {
        let grid = Grid { west_m: 0.0, north_m: 5.0, cell_m: 1.0, columns: 5, rows: 5 };
        let mut depth_m: Vec<f32> = (0..25).map(|cell| 2.0 + 0.1 * (cell % 5) as f32).collect();
        depth_m[24] = f32::NAN;
        let surface = Surface::of_depths(grid, depth_m);
        let light = Light::suited(&surface);
        let shade = hill_shade(&surface, &light, &Progress::new()).unwrap();
        let lit = LitSurface::new(&surface, &shade, &light);
        let between = lit.at([2.0, 2.5]).unwrap();
        assert!((between.depth_m - 2.15).abs() < 1e-6);
        // Deeper to the east: turned away from the light in the north-west.
        assert!(between.light < 0.999, "{between:?}");
        // Between a known cell and one without, on the known one's side.
        assert_eq!(lit.at([3.9, 0.5]).map(|pixel| pixel.depth_m), Some(2.3));
        assert_eq!(lit.at([3.9, 0.5]).map(|pixel| pixel.light), Some(1.0));
        assert_eq!(lit.at([4.5, 0.5]), None);
        assert_eq!(lit.at([5.5, 2.5]), None);
    }
}
