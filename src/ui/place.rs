//! Where a mark lies on the ground.

use crate::app::{App, Mark};
use crate::cloud::Reduction;
use crate::detection;
use crate::geo::{LonLat, UtmZone};
use crate::pipeline::Products;
use crate::survey::{HeadingSource, Side, SidePing};
use crate::ui::text;

/// What samples and recorded depths are in metres by the last results; as recorded while there are none.
pub fn reduction(app: &App) -> Reduction<'_> {
    let products = app.log.products.as_ref();
    products.map_or_else(Reduction::default, Products::reduction)
}

/// Slant range of a mark, metres.
pub fn range_m(app: &App, mark: Mark) -> Option<f64> {
    let survey = app.log.survey.as_ref()?;
    let range_m = reduction(app).range_at_m(survey, mark.ping, mark.side?, mark.sample?);
    range_m.is_finite().then_some(range_m)
}

/// Slant ranges of the near and the far edge of a box, metres.
pub fn ranges_m(app: &App, mark: &detection::Mark) -> [f64; 2] {
    let middle = usize::midpoint(mark.pings.start, mark.pings.end);
    let survey = app.log.survey.as_ref();
    let span = survey.and_then(|survey| survey.span(middle, mark.side));
    let reduction = reduction(app);
    [mark.near_m, mark.far_m].map(|recorded_m| {
        span.map_or(recorded_m, |span| {
            reduction.range_m(span, span.sample_at(recorded_m))
        })
    })
}

/// The recorded depth at a ping as the map has it, metres; NaN where there is none.
pub fn depth_m(app: &App, ping: &SidePing) -> f64 {
    reduction(app).depth_m(ping.time_s, f64::from(ping.depth_m))
}

/// [`depth_m`] with what it counts from; a dash where there is none.
pub fn depth(app: &App, ping: &SidePing) -> String {
    let depth_m = depth_m(app, ping);
    match depth_m.is_finite() {
        true => format!(
            "{} {}",
            app.options.units.measure(depth_m, 2),
            reduction(app).reference().name()
        ),
        false => text::NONE.to_owned(),
    }
}

/// Height of the transducer over the bottom by the recorded depth, metres; NaN where there is none.
pub fn altitude_m(app: &App, ping: &SidePing) -> f64 {
    reduction(app).altitude_m(f64::from(ping.depth_m))
}

/// Heading of the boat at a ping in a few letters: a course over ground, or the compass.
pub fn labelled_heading(app: &App, ping: usize) -> String {
    let products = app.log.products.as_ref();
    let here = products.and_then(|products| Some((products, products.navigation.pings.get(ping)?)));
    let Some((products, here)) = here else {
        return format!("COG {}", text::NONE);
    };
    let label = match products.settings.heading.source {
        HeadingSource::Steps | HeadingSource::TrackFit | HeadingSource::Cog => "COG",
        HeadingSource::Compass => "compass",
    };
    match here.heading_rad.is_finite() {
        true => format!("{label} {}", whole_degrees(here.heading_rad)),
        false => format!("{label} {}", text::NONE),
    }
}

/// `212°`; never 360.
fn whole_degrees(heading_rad: f64) -> String {
    let degrees = heading_rad.to_degrees().round().rem_euclid(360.0);
    format!("{degrees:.0}°")
}

/// Heading of the boat at a ping, clockwise from north, and where it comes from.
pub fn heading(app: &App, ping: usize) -> String {
    let products = app.log.products.as_ref();
    let here = products.and_then(|products| Some((products, products.navigation.pings.get(ping)?)));
    let Some((products, here)) = here else {
        return text::NONE.to_owned();
    };
    let source = match products.settings.heading.source {
        HeadingSource::Steps => "fix to fix",
        HeadingSource::TrackFit => "track",
        HeadingSource::Cog => "recorded course",
        HeadingSource::Compass => "compass",
    };
    let offset_deg = products.settings.mounting.heading_offset_deg;
    let source = match products.settings.heading.source {
        HeadingSource::Compass if offset_deg != 0.0 => format!("{source} {offset_deg:+.1}°"),
        _ => source.to_owned(),
    };
    match here.heading_rad.is_finite() {
        true => format!("{} ({source})", whole_degrees(here.heading_rad)),
        false => format!("none ({source})"),
    }
}

/// A position as the analyst wants to read it; UTM in the zone of the survey's first fix, as in the products.
pub fn written(app: &App, at: LonLat) -> String {
    let start = app
        .log
        .survey
        .as_ref()
        .map(|survey| survey.track.frame.origin());
    let zone = UtmZone::of(start.unwrap_or(at));
    app.options.coordinates.write(at, zone)
}

/// WGS84 position of a mark.
pub fn lon_lat(app: &App, mark: Mark) -> Option<LonLat> {
    let track = &app.log.survey.as_ref()?.track;
    let navigation = &app.log.products.as_ref()?.navigation;
    let [east_m, north_m] = east_north(app, mark)?;
    Some(navigation.to_lon_lat(track, east_m, north_m))
}

/// Metres east and north of a mark: of the point, of the place across the track on the bottom, or of the boat.
pub fn east_north(app: &App, mark: Mark) -> Option<[f64; 2]> {
    let products = app.log.products.as_ref()?;
    let points = &products.cloud.points;
    if let Some(point) = mark.point.and_then(|point| points.get(point)) {
        return Some([point.east_m, point.north_m]);
    }
    let boat = products.navigation.pings.get(mark.ping)?;
    let ground_m = ground_m(app, mark)
        .or_else(|| range_m(app, mark))
        .unwrap_or(0.0);
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

/// Distance of a mark from the track on the bottom, metres; under the boat that lies at the recorded depth, or where the first return of the
/// side says. `None` where neither is known.
pub fn ground_m(app: &App, mark: Mark) -> Option<f64> {
    let (slant_m, side) = (range_m(app, mark)?, mark.side?);
    let survey = app.log.survey.as_ref()?;
    let across = app.log.products.as_ref()?.relief.across(side, mark.ping);
    let first_return_m = || {
        let pick = app.bottom_line()?.side(side).get(mark.ping)?;
        Some(reduction(app).range_at_m(survey, mark.ping, side, pick.sample))
    };
    let recorded_m = altitude_m(app, survey.side_scan.get(mark.ping)?);
    let altitude_m = match recorded_m > 0.0 {
        true => recorded_m,
        false => across.altitude_m(first_return_m()?),
    };
    (altitude_m > 0.0).then(|| across.ground_m(altitude_m, slant_m))
}
