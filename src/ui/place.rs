//! Where a mark lies on the ground.

use crate::app::{App, Mark};
use crate::cloud::slant_range_m;
use crate::geo::{LonLat, UtmZone};
use crate::survey::Side;

/// Slant range of a mark by the calibration in force, metres; by the recorder's scale while there is no result.
pub fn range_m(app: &App, mark: Mark) -> Option<f64> {
    let survey = app.survey.as_ref()?;
    let (side, sample) = (mark.side?, mark.sample?);
    let range = match &app.products {
        Some(products) => slant_range_m(survey, &products.calibration, mark.ping, side, sample),
        None => survey
            .side_scan
            .get(mark.ping)?
            .side(side)?
            .range_m(f64::from(sample)),
    };
    range.is_finite().then_some(range)
}

/// A position as the analyst wants to read it; UTM in the zone of the survey's first fix, as in the products.
pub fn written(app: &App, at: LonLat) -> String {
    let start = app
        .survey
        .as_ref()
        .map(|survey| survey.track.frame.origin());
    let zone = UtmZone::of(start.unwrap_or(at));
    app.options.coordinates.write(at, zone)
}

/// WGS84 position of a mark.
pub fn lon_lat(app: &App, mark: Mark) -> Option<LonLat> {
    let track = &app.survey.as_ref()?.track;
    let navigation = &app.products.as_ref()?.navigation;
    let [east_m, north_m] = east_north(app, mark)?;
    Some(navigation.to_lon_lat(track, east_m, north_m))
}

/// Metres east and north of a mark: of the point, of the place beside the track on a flat bottom, or of the boat.
pub fn east_north(app: &App, mark: Mark) -> Option<[f64; 2]> {
    let products = app.products.as_ref()?;
    let points = &products.cloud.points;
    if let Some(point) = mark.point.and_then(|point| points.get(point)) {
        return Some([point.east_m, point.north_m]);
    }
    let boat = products.navigation.pings.get(mark.ping)?;
    let ground_m = ground_range_m(app, mark).unwrap_or(0.0);
    // Starboard is a quarter turn clockwise from the heading.
    let across = match mark.side {
        Some(Side::Starboard) => ground_m,
        Some(Side::Port) => -ground_m,
        None => 0.0,
    };
    let (sin, cos) = if boat.heading_rad.is_finite() {
        boat.heading_rad.sin_cos()
    } else {
        (0.0, 0.0)
    };
    let (east_m, north_m) = (boat.east_m + across * cos, boat.north_m - across * sin);
    (east_m.is_finite() && north_m.is_finite()).then_some([east_m, north_m])
}

/// Distance from the track on a flat bottom at the recorded depth, metres.
fn ground_range_m(app: &App, mark: Mark) -> Option<f64> {
    let slant_m = range_m(app, mark)?;
    let depth_m = f64::from(app.survey.as_ref()?.side_scan.get(mark.ping)?.depth_m);
    let depth_m = if depth_m.is_finite() { depth_m } else { 0.0 };
    Some((slant_m * slant_m - depth_m * depth_m).max(0.0).sqrt())
}
