//! Positions that cannot be: far from all others of their track.

use crate::support::statistics::upper_median;
use crate::survey::Fix;

/// A fix this far from the track's median position is damage, degrees (some 200 km).
const STRAY_FIX_DEG: f64 = 2.0;

/// Leaves out the fixes that a damaged record threw far away, and says so in a sentence if there
/// are any.
pub(super) fn drop_stray(fixes: &mut Vec<Fix>) -> Option<String> {
    let median = |pick: fn(&Fix) -> f64| {
        let mut values: Vec<f64> = fixes.iter().map(pick).collect();
        upper_median(&mut values, f64::total_cmp)
    };
    let lon_deg = median(|fix| fix.position.lon_deg)?;
    let lat_deg = median(|fix| fix.position.lat_deg)?;
    let before = fixes.len();
    let mut first_s = f64::NAN;
    fixes.retain(|fix| {
        let east_deg = fix.position.lon_deg - lon_deg;
        // Across the antimeridian 179.9 and -179.9 are neighbours.
        let east_deg = east_deg - 360.0 * (east_deg / 360.0).round();
        let near = (fix.position.lat_deg - lat_deg).abs() < STRAY_FIX_DEG
            && east_deg.abs() * lat_deg.to_radians().cos() < STRAY_FIX_DEG;
        if !near {
            first_s = first_s.min(fix.time_s);
        }
        near
    });
    let dropped = before - fixes.len();
    (dropped > 0).then(|| match dropped {
        1 => format!(
            "the position at {first_s:.1} s lies hundreds of kilometres from all others and was dropped"
        ),
        _ => format!(
            "{dropped} positions, the first at {first_s:.1} s, lie hundreds of kilometres from all others and were dropped"
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::geo::LonLat;

    fn fixes(places: &[[f64; 2]]) -> Vec<Fix> {
        let fix = |(index, &[lon_deg, lat_deg]): (usize, &[f64; 2])| Fix {
            time_s: index as f64,
            position: LonLat { lon_deg, lat_deg },
            cog_rad: f32::NAN,
            compass_rad: f32::NAN,
            speed_mps: f32::NAN,
        };
        places.iter().enumerate().map(fix).collect()
    }

    #[test]
    fn far_positions_go_and_those_across_the_antimeridian_stay() {
        let mut some = fixes(&[[10.0, 50.0], [10.0, 50.1], [-120.0, -40.0], [10.1, 50.0]]);
        let warning = drop_stray(&mut some).unwrap();
        assert!(warning.starts_with("the position at 2.0 s"), "{warning}");
        assert_eq!(some.len(), 3);
        let mut pacific =
            fixes(&[[179.9, -18.0], [-179.9, -18.0], [179.95, -18.0], [-179.95, -18.0]]);
        assert_eq!(drop_stray(&mut pacific), None);
        assert_eq!(pacific.len(), 4);
        assert_eq!(drop_stray(&mut Vec::new()), None);
    }
}
