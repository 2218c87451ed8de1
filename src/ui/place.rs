//! Computes slant range, depth, heading and position of a mark, and writes the texts about excluded
//! and flat stretches, the same in all views and panels.

use crate::app::{
    Action, App, Command, Enlarged, ExcludedExtent, ExclusionEdit, LogId, LogPlace, Reveal,
};
use crate::ui::{ViewContext, text};
use bathyscope_bottom::calibration::{FlatSpot, ScaleMode};
use bathyscope_bottom::cloud::Reduction;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::support::geo::{LonLat, UtmZone, compass_deg};
use bathyscope_log::survey::{HeadingSource, Side, SideSpan};
use bathyscope_products::pipeline::Products;
use egui::Ui;

/// Returns the corrections that turn samples and recorded depths into metres, from the last
/// results; without results, ranges and depths stay as recorded.
pub(super) fn reduction(app: &App) -> Reduction<'_> {
    let products = app.logs.shown.products.as_ref();
    products.map_or_else(Reduction::default, Products::reduction)
}

/// Returns true if the shown log has a usable side-scan.
pub(super) fn has_side_scan(app: &App) -> bool {
    let survey = app.logs.shown.survey.as_ref();
    survey.is_some_and(|survey| survey.has_side_scan())
}

/// Returns the number of side-scan pings of the shown log.
pub(super) fn ping_count(app: &App) -> usize {
    let survey = app.logs.shown.survey.as_ref();
    survey.map_or(0, |survey| survey.side_scan.len())
}

/// Returns a range with the sign of its side: negative for port.
pub(super) fn across_m(side: Side, range_m: f64) -> f64 {
    match side {
        Side::Port => -range_m,
        Side::Starboard => range_m,
    }
}

/// Returns a distance in samples as [`LogPlace::sample`] stores it; `None` beyond the recorded
/// samples.
pub(super) fn recorded_sample(span: &SideSpan, sample: f64) -> Option<f32> {
    (0.0..f64::from(span.count)).contains(&sample).then_some(sample as f32)
}

/// Returns the short name of a side.
pub(super) fn short_name(side: Side) -> &'static str {
    match side {
        Side::Port => "port",
        Side::Starboard => "stbd",
    }
}

/// Returns the side of a range with a sign: port if negative.
pub(super) fn side_at(across_m: f64) -> Side {
    if across_m < 0.0 { Side::Port } else { Side::Starboard }
}

/// Returns the slant range of a mark, metres; `None` if the mark has no sample or its range is
/// unknown.
pub(super) fn range_m(app: &App, mark: LogPlace) -> Option<f64> {
    let survey = app.logs.shown.survey.as_ref()?;
    let range_m = reduction(app).range_at_m(survey, mark.ping, mark.side?, mark.sample?);
    range_m.is_finite().then_some(range_m)
}

/// Returns the slant ranges of the near and the far edge of a box, metres.
pub(super) fn ranges_m(app: &App, mark: &bathyscope_objects::Mark) -> [f64; 2] {
    let middle = usize::midpoint(mark.pings.start, mark.pings.end);
    let survey = app.logs.shown.survey.as_ref();
    let span = survey.and_then(|survey| survey.span(middle, mark.side));
    let reduction = reduction(app);
    [mark.near_m, mark.far_m].map(|recorded_m| {
        span.map_or(recorded_m, |span| reduction.range_m(span, span.sample_at(recorded_m)))
    })
}

/// Source of the depth under the boat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DepthBy {
    /// The recorder's own sounding.
    Sounding,
    /// The first return of the side-scan: the recorder had lost the bottom, or has no depth.
    FirstReturn,
}

impl DepthBy {
    /// Returns `sounding` or `first return`.
    pub(super) fn name(self) -> &'static str {
        match self {
            DepthBy::Sounding => "sounding",
            DepthBy::FirstReturn => "first return",
        }
    }
}

/// The bottom under the boat at a ping, the same for every read-out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BottomBelow {
    /// Height of the transducer over the bottom, metres.
    pub altitude_m: f64,
    /// Depth as shown by the map, metres.
    pub depth_m: f64,
    /// Source of the depth.
    pub by: DepthBy,
}

/// Returns the bottom under the boat at a ping: by the sounding where the recorder had the bottom,
/// else by the mean of the first returns of the sides that have one; `None` without either.
pub(super) fn bottom(app: &App, ping: usize) -> Option<BottomBelow> {
    let recorded = app.logs.shown.judged()?.side_scan.get(ping)?;
    let reduction = reduction(app);
    let sounded_m = reduction.altitude_m(f64::from(recorded.good_depth_m()));
    let (altitude_m, by) = if sounded_m > 0.0 {
        (sounded_m, DepthBy::Sounding)
    } else {
        let altitudes_m = Side::BOTH.map(|side| first_return_altitude_m(app, side, ping));
        let known: Vec<f64> = altitudes_m.into_iter().flatten().collect();
        let mean_m = known.iter().sum::<f64>() / known.len() as f64;
        (mean_m, DepthBy::FirstReturn)
    };
    let depth_m = reduction.depth_below_m(recorded.time_s, altitude_m);
    depth_m.is_finite().then_some(BottomBelow { altitude_m, depth_m, by })
}

/// Returns the height of the transducer over the bottom under the boat, metres, from the first
/// return of a side.
fn first_return_altitude_m(app: &App, side: Side, ping: usize) -> Option<f64> {
    let survey = app.logs.shown.survey.as_ref()?;
    let across = app.logs.shown.products.as_ref()?.relief.across(side, ping);
    let pick = app.logs.shown.bottom_line()?.side(side).get(ping)?;
    let range_m = reduction(app).range_at_m(survey, ping, side, pick.sample);
    let altitude_m = across.altitude_m(range_m);
    (pick.is_some() && altitude_m > 0.0).then_some(altitude_m)
}

/// Describes the depth at a ping with the level that it counts from and its source; a dash, and
/// the reason if there is one, where the depth is unknown.
pub(super) fn depth(app: &App, ping: usize) -> String {
    let bottom = bottom(app, ping);
    bottom.map_or_else(
        || format!("{}, bottom lost", text::NONE),
        |bottom| {
            let depth = app.view.options.units.measure(bottom.depth_m, 2);
            let reference = reduction(app).reference_name();
            let by = bottom.by.name();
            format!("{depth} {reference}, {by}")
        },
    )
}

/// Writes the heading of the boat at a ping with a short label: `COG 212°` or `compass 212°`.
pub(super) fn labelled_heading(app: &App, ping: usize) -> String {
    let products = app.logs.shown.products.as_ref();
    let here = products.and_then(|products| Some((products, products.navigation.pings.get(ping)?)));
    let Some((products, here)) = here else {
        return format!("COG {}", text::NONE);
    };
    let label = match products.settings.heading.source {
        HeadingSource::Steps | HeadingSource::TrackFit | HeadingSource::Cog => "COG",
        HeadingSource::Compass => "compass",
    };
    let is_known = here.heading_rad.is_finite();
    let written = if is_known { whole_degrees(here.heading_rad) } else { text::NONE.to_owned() };
    format!("{label} {written}")
}

/// Formats a heading as `212°`; never as 360.
fn whole_degrees(heading_rad: f64) -> String {
    format!("{:.0}°", compass_deg(heading_rad, 0))
}

/// Describes the heading of the boat at a ping, clockwise from north, and its source.
pub(super) fn heading(app: &App, ping: usize) -> String {
    let products = app.logs.shown.products.as_ref();
    let here = products.and_then(|products| Some((products, products.navigation.pings.get(ping)?)));
    let Some((products, here)) = here else {
        return text::NONE.to_owned();
    };
    let offset_deg = products.settings.mounting.heading_offset_deg;
    let source = match products.settings.heading.source {
        HeadingSource::Steps => "fix to fix",
        HeadingSource::TrackFit => "track",
        HeadingSource::Cog => "recorded course",
        HeadingSource::Compass if offset_deg != 0.0 => &format!("compass {offset_deg:+.1}°"),
        HeadingSource::Compass => "compass",
    };
    if here.heading_rad.is_finite() {
        format!("{} ({source})", whole_degrees(here.heading_rad))
    } else {
        format!("none ({source})")
    }
}

/// Formats a position in the notation chosen by the user; UTM in the zone of the survey's first
/// fix, as in the products.
pub(super) fn written(app: &App, at: LonLat) -> String {
    let survey = app.logs.shown.survey.as_ref();
    let start = survey.map(|survey| survey.track.frame.origin());
    let zone = UtmZone::of(start.unwrap_or(at));
    app.view.options.coordinates.write(at, zone)
}

/// Returns the WGS84 position of a mark; `None` where it is unknown.
pub(super) fn lon_lat(app: &App, mark: LogPlace) -> Option<LonLat> {
    let track = &app.logs.shown.survey.as_ref()?.track;
    let navigation = &app.logs.shown.products.as_ref()?.navigation;
    let [east_m, north_m] = east_north(app, mark)?;
    Some(navigation.to_lon_lat(track, east_m, north_m))
}

/// Returns the position of an object that is to fill about a third of a view, metres east, north
/// and up, and its size, metres; `None` if the place is only to be brought into view, or the
/// object has no position.
pub(super) fn enlarged(reveal: &Reveal) -> Option<([f64; 3], f64)> {
    let close_up = reveal.close_up.filter(|close_up| close_up.enlarged == Enlarged::Third)?;
    Some((close_up.place_m?, close_up.size_m))
}

/// Returns metres east and north of the point of a mark; without a point, of its place on the
/// bottom across the track; without a sample, of the boat.
pub(super) fn east_north(app: &App, mark: LogPlace) -> Option<[f64; 2]> {
    let products = app.logs.shown.products.as_ref()?;
    let points = &products.cloud.points;
    if let Some(point) = mark.point.and_then(|point| points.get(point)) {
        return Some([point.east_m, point.north_m]);
    }
    let boat = products.navigation.pings.get(mark.ping)?;
    let ground_m = ground_m(app, mark).or_else(|| range_m(app, mark)).unwrap_or(0.0);
    // Starboard is a quarter turn clockwise from the heading.
    let across = mark.side.map_or(0.0, |side| across_m(side, ground_m));
    let (sin, cos) =
        if boat.heading_rad.is_finite() { boat.heading_rad.sin_cos() } else { (0.0, 0.0) };
    let (east_m, north_m) = (boat.east_m + across * cos, boat.north_m - across * sin);
    (east_m.is_finite() && north_m.is_finite()).then_some([east_m, north_m])
}

/// Returns the distance on the bottom between the track and a mark, metres. The bottom under the
/// boat is at the sounding, or else at the first return of the side; `None` if neither is known.
pub(super) fn ground_m(app: &App, mark: LogPlace) -> Option<f64> {
    let (slant_m, side) = (range_m(app, mark)?, mark.side?);
    let across = app.logs.shown.products.as_ref()?.relief.across(side, mark.ping);
    let recorded_m = f64::from(app.logs.shown.judged()?.side_scan.get(mark.ping)?.good_depth_m());
    let sounded_m = reduction(app).altitude_m(recorded_m);
    let altitude_m =
        if sounded_m > 0.0 { sounded_m } else { first_return_altitude_m(app, side, mark.ping)? };
    Some(across.ground_m(altitude_m, slant_m))
}

/// Formats an extent as `412 pings · 512 m · 1:02`.
pub(super) fn stretch_extent(extent: &ExcludedExtent, units: Units) -> String {
    let way = units.way(extent.length_m);
    let lasts = text::duration(extent.duration_s);
    match extent.pings {
        0 => format!("{way} · {lasts}"),
        pings => format!("{} · {way} · {lasts}", text::plural(pings, "ping", "pings")),
    }
}

/// Describes the effect of a drag with the tool on the stretch that it covers.
pub(super) fn drag_effect(edit: ExclusionEdit, covered: &ExcludedExtent, units: Units) -> String {
    let what = match edit {
        ExclusionEdit::Exclude => "exclude",
        ExclusionEdit::Include => "include again",
        ExclusionEdit::Trust => "trust the soundings of",
        ExclusionEdit::Reset => "reset",
    };
    format!("{what} {}", stretch_extent(covered, units))
}

/// Returns the reason why a ping is excluded, as `excluded: turn`; `None` where it is not excluded.
pub(super) fn excluded_at(app: &App, log: LogId, ping: usize) -> Option<String> {
    let stretch = app.logs.excluded_at(log, ping)?;
    Some(format!("excluded: {}", stretch.reason.name()))
}

/// Includes the excluded stretch at a ping again, if there is one.
pub(super) fn include_again(context: &mut ViewContext<'_>, log: LogId, ping: usize) {
    if let Some(stretch) = context.app.logs.excluded_at(log, ping) {
        let (part, edit) = (stretch.part(), ExclusionEdit::Include);
        context.push(Command::Exclude { log, part, edit });
    }
}

/// Adds to a view's menu an entry that includes the excluded stretch at a ping again, if there is
/// one.
pub(super) fn include_entry(ui: &mut Ui, context: &mut ViewContext<'_>, log: LogId, ping: usize) {
    let Some(stretch) = context.app.logs.excluded_at(log, ping) else {
        return;
    };
    let hint = format!("Excluded: {}.", stretch.reason.name());
    if ui.button(Action::IncludeAgain.label()).on_hover_text(hint).clicked() {
        include_again(context, log, ping);
        ui.close();
    }
}

/// Returns the number of excluded stretches of the shown log, after a comma; empty if there are
/// none.
pub(super) fn and_stretches(app: &App) -> String {
    let found = app.logs.shown.exclusions();
    let count = found.map_or(0, |found| found.exclusions.stretches.len());
    match count {
        0 => String::new(),
        count => format!(", {} excluded", text::plural(count, "stretch", "stretches")),
    }
}

/// Describes a flat stretch as `10 m, relief 4 cm, ±1.2 %`.
pub(super) fn stretch_brief(spot: &FlatSpot, units: Units) -> String {
    let length = units.measure(spot.length_m, 0);
    let relief = stretch_relief(spot, units);
    match stretch_spread(spot) {
        Some(spread) => format!("{length}, relief {relief}, {spread}"),
        None => format!("{length}, relief {relief}, no scale"),
    }
}

/// Formats the spread of the scale of single pings as `±1.2 %`; `None` if it is unknown.
pub(super) fn stretch_spread(spot: &FlatSpot) -> Option<String> {
    Some(format!("±{:.1} %", 100.0 * spot.spread()?))
}

/// Formats the factor on the recorded range as `×0.949`; `None` if it is unknown.
pub(super) fn stretch_factor(spot: &FlatSpot) -> Option<String> {
    Some(format!("×{:.3}", spot.factor?))
}

/// Formats the relief as `4 cm`; a dash if it is unknown.
pub(super) fn stretch_relief(spot: &FlatSpot, units: Units) -> String {
    let written = units.small_difference(spot.relief_m);
    if spot.relief_m.is_finite() {
        written.trim_start_matches('+').to_owned()
    } else {
        text::NONE.to_owned()
    }
}

/// Returns the label of the stretch that the calibration was measured on, which tells if its scale
/// is in use.
pub(super) fn calibrated_name(mode: ScaleMode) -> &'static str {
    match mode {
        ScaleMode::FlatSpot => "scale from here",
        ScaleMode::Header => "flat stretch, not in use",
    }
}
