//! Area and volume below a level, as in a reservoir's table.

use super::ClipArea;
use crate::bathymetry::Surface;
use serde::Serialize;

/// The part of a surface below a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Storage {
    /// The level: its depth, metres.
    pub depth_m: f64,
    /// Area of the bottom that is deeper, seen from above, square metres.
    pub area_m2: f64,
    /// Water between the level and that bottom, cubic metres.
    pub volume_m3: f64,
}

/// Area and volume below each level. Every cell counts as a column of its own depth; what was not
/// measured does not count, nor do cells whose middle lies outside the area, where there is one.
pub fn storage(surface: &Surface, levels_m: &[f64], within: Option<&ClipArea>) -> Vec<Storage> {
    let is_within = |cell: usize| {
        let middle = surface.grid.centre_of(cell);
        within.is_none_or(|area| area.holds(middle))
    };
    let known = surface.depth_m.iter().enumerate();
    let known = known.filter(|(cell, depth)| !depth.is_nan() && is_within(*cell));
    let mut depths: Vec<f64> = known.map(|(_, depth)| f64::from(*depth)).collect();
    depths.sort_unstable_by(f64::total_cmp);
    // Sums from the deepest up to each place in the order.
    let mut deepest_first = Vec::with_capacity(depths.len() + 1);
    let mut sum_m = 0.0;
    deepest_first.push(sum_m);
    for depth in depths.iter().rev() {
        sum_m += depth;
        deepest_first.push(sum_m);
    }
    let cell_m2 = surface.grid.cell_m.powi(2);
    let below = |&level_m: &f64| {
        let deeper = depths.len() - depths.partition_point(|depth| *depth < level_m);
        Storage {
            depth_m: level_m,
            area_m2: cell_m2 * deeper as f64,
            volume_m3: cell_m2 * (deepest_first[deeper] - level_m * deeper as f64),
        }
    };
    levels_m.iter().map(below).collect()
}
