//! Transforms the area that clips the isobaths from degrees into the plane of a map.

use bathyscope_bottom::bathymetry::isobaths::{ClipArea, IsobathSettings, NoIsobaths};
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::support::outline::{between, bounds, edges};

/// Length of the pieces into which edges are cut, metres. Edges are straight in degrees, pieces are
/// straight in the plane; at this length they differ by less than a millimetre.
const PIECE_M: f64 = 50.0;
/// Most pieces of all edges; longer edges are cut into longer pieces.
const MOST_PIECES: f64 = 1e6;
/// Margin around the map within which edges count, degrees: a shoreline may be that of a continent,
/// which no plane can hold.
const MARGIN_DEG: f64 = 0.01;

/// Returns the area that `isobaths.clip` names, within a box about the map (west, south, east,
/// north, degrees) and in the plane to which `place` transforms; `None` if no area is named. The
/// area may be empty.
///
/// # Errors
/// When the file of the area has not been read.
pub fn clip_area(
    settings: &IsobathSettings,
    bounds_deg: [f64; 4],
    place: impl Fn(LonLat) -> [f64; 2],
) -> Result<Option<ClipArea>, NoIsobaths> {
    let Some(path) = &settings.clip else {
        return Ok(None);
    };
    let Some(area) = &settings.area else {
        return Err(NoIsobaths::AreaNotRead { path: path.clone() });
    };
    let [west, south, east, north] = bounds_deg;
    let around = [west - MARGIN_DEG, south - MARGIN_DEG, east + MARGIN_DEG, north + MARGIN_DEG];
    let middle_deg = 0.5 * (west + east);
    let rings = area.rings.iter().map(|ring| clip_ring(ring, middle_deg, around));
    let rings: Vec<Vec<[f64; 2]>> = rings.filter(|ring| !ring.is_empty()).collect();
    let place = |[lon_deg, lat_deg]: [f64; 2]| place(LonLat { lon_deg, lat_deg });
    let length_m = |[from, to]: [[f64; 2]; 2]| {
        let [from, to] = [from, to].map(place);
        (to[0] - from[0]).hypot(to[1] - from[1])
    };
    let all_m: f64 = rings.iter().flat_map(|ring| edges(ring)).map(length_m).sum();
    let piece_m = PIECE_M.max(all_m / MOST_PIECES);
    let in_pieces = |ring: &Vec<[f64; 2]>| {
        let corners = edges(ring).flat_map(|edge| {
            let count = (length_m(edge) / piece_m).ceil().max(1.0) as usize;
            let [from, to] = edge;
            (0..count).map(move |step| between(from, to, step as f64 / count as f64))
        });
        corners.map(place).collect()
    };
    Ok(Some(ClipArea::new(rings.iter().map(in_pieces).collect())))
}

/// Clips a ring to a box (Sutherland and Hodgman 1974): the parts outside follow the edges of the
/// box. A ring beyond the date line is moved by whole turns, so that its middle is nearest to
/// `middle_deg`.
fn clip_ring(ring: &[LonLat], middle_deg: f64, around: [f64; 4]) -> Vec<[f64; 2]> {
    let [west, _, east, _] = bounds(ring.iter().map(|at| [at.lon_deg, at.lat_deg]));
    let turns = ((middle_deg - 0.5 * (west + east)) / 360.0).round();
    let near = |at: &LonLat| [at.lon_deg + 360.0 * turns, at.lat_deg];
    let mut ring: Vec<[f64; 2]> = ring.iter().map(near).collect();
    let [west, south, east, north] = around;
    for (axis, edge, sign) in [(0, west, 1.0), (0, east, -1.0), (1, south, 1.0), (1, north, -1.0)] {
        let is_in = |at: [f64; 2]| sign * (at[axis] - edge) >= 0.0;
        let mut cut = Vec::with_capacity(ring.len());
        for [from, to] in edges(&ring) {
            if is_in(from) {
                cut.push(from);
            }
            if is_in(from) != is_in(to) {
                let share = (edge - from[axis]) / (to[axis] - from[axis]);
                let mut at = between(from, to, share);
                at[axis] = edge;
                cut.push(at);
            }
        }
        ring = cut;
    }
    ring
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::WaterArea;
    use std::sync::Arc;

    fn settings(corners: &[[f64; 2]]) -> IsobathSettings {
        let ring = corners.iter().map(|[lon_deg, lat_deg]| LonLat::new(*lon_deg, *lat_deg));
        IsobathSettings {
            clip: Some("shore.kml".into()),
            area: Some(Arc::new(WaterArea { rings: vec![ring.collect()], ..WaterArea::default() })),
            ..IsobathSettings::default()
        }
    }

    /// Converts degrees to metres: a hundred kilometres a degree.
    fn plane(at: LonLat) -> [f64; 2] {
        [1e5 * at.lon_deg, 1e5 * at.lat_deg]
    }

    #[test]
    fn a_shore_that_is_far_larger_than_the_map_is_what_lies_about_the_map() {
        // A hemisphere, whose southern edge runs through the map.
        let half = [[-180.0, 47.0], [180.0, 47.0], [180.0, 90.0], [-180.0, 90.0]];
        let map = [8.0, 46.99, 8.02, 47.01];
        let area = clip_area(&settings(&half), map, plane);
        let area = area.expect("it was read").expect("it is named");
        assert!(area.holds([8.01e5, 47.001e5]) && !area.holds([8.01e5, 46.999e5]));
        let elsewhere = clip_area(&settings(&half), [8.0, -40.0, 8.02, -39.9], plane);
        assert!(elsewhere.is_ok_and(|area| area.is_some_and(|area| area.is_empty())));
    }

    #[test]
    fn beyond_the_date_line_longitudes_are_those_of_the_map() {
        let bay = [[-179.999, 10.0], [-179.99, 10.0], [-179.99, 10.01]];
        let area = clip_area(&settings(&bay), [179.995, 10.0, 180.02, 10.01], plane);
        let area = area.expect("it was read").expect("it is named");
        assert!(area.holds([180.005e5, 10.001e5]));
    }

    #[test]
    fn what_was_not_read_is_said_and_what_is_not_named_cuts_nothing() {
        let mut named = settings(&[]);
        named.area = None;
        let error = clip_area(&named, [0.0; 4], plane).expect_err("it was not read");
        assert!(
            error.to_string().contains("has not been read")
                && error.to_string().ends_with("shore.kml")
        );
        named.clip = None;
        assert!(clip_area(&named, [0.0; 4], plane).is_ok_and(|area| area.is_none()));
    }
}
