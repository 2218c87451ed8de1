//! Returns what all maps of the page show: a picture, the track and the objects in a frame.

use super::frame::PageTransform;
use super::{ReportData, objects};
use crate::pipeline::ProcessedLog;
use bathyscope_bottom::presentation::page::{Value, context};

/// Returns the values of a map around a picture.
pub(super) fn map(from: &ReportData<'_>, frame: &PageTransform, picture: Value) -> Value {
    context! {
        picture,
        track => track(from, frame),
        marks => objects::marks(from, frame),
        ..frame.values()
    }
}

/// Returns the path of the boat in all logs.
fn track(from: &ReportData<'_>, frame: &PageTransform) -> String {
    let of_log = |log: &ProcessedLog| {
        let navigation = &log.products.navigation;
        let pings =
            if navigation.pings.is_empty() { &navigation.soundings } else { &navigation.pings };
        let places = pings.iter().map(|place| {
            let track = &log.survey.track;
            from.map.place(navigation.to_lon_lat(track, place.east_m, place.north_m))
        });
        frame.path(places)
    };
    from.logs.iter().map(of_log).collect()
}
