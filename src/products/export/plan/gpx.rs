//! `.gpx` (GPX 1.1).

use super::{PlannedWay, WayPlace};
use bathyscope_bottom::planning::WaypointKind;
use bathyscope_log::support::printable::xml;

pub(super) fn text(way: &PlannedWay<'_>) -> String {
    let ends = way.places().filter(|place| place.station != WaypointKind::Turn);
    let waypoints: String = ends.map(|place| point("wpt", &place)).collect();
    let route: String = way.places().map(|place| point("rtept", &place)).collect();
    let (name, description) = (xml(way.name), xml(&way.description()));
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"Bathyscope\" \
         xmlns=\"http://www.topografix.com/GPX/1/1\">\n<metadata><name>{name}</name><desc>{description}</desc></metadata>\n\
         {waypoints}<rte><name>{name}</name><desc>{description}</desc>\n{route}</rte>\n</gpx>\n"
    )
}

fn point(kind: &str, place: &WayPlace) -> String {
    let (lat, lon) = (place.at.lat_deg, place.at.lon_deg);
    let name = place.name();
    format!("<{kind} lat=\"{lat:.8}\" lon=\"{lon:.8}\"><name>{name}</name></{kind}>\n")
}
