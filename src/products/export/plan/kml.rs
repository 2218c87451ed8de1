//! `.kml` (KML 2.2).

use super::PlannedWay;
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::support::printable::xml;

pub(super) fn text(way: &PlannedWay<'_>) -> String {
    let line = |(number, leg): (usize, &bathyscope_bottom::planning::Leg)| {
        let ends = [leg.from, leg.to].map(|place| way.lon_lat(place));
        placemark(&format!("L{number}"), ends.into_iter(), "line")
    };
    let lines: String = (1..).zip(&way.plan.lines).map(line).collect();
    let whole = placemark("way", way.places().map(|place| place.at), "way");
    let (name, description) = (xml(way.name), xml(&way.description()));
    // Colours are alpha, blue, green, red.
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n\
         <name>{name}</name><description>{description}</description>\n\
         <Style id=\"line\"><LineStyle><color>ff00a5ff</color><width>3</width></LineStyle></Style>\n\
         <Style id=\"way\"><LineStyle><color>b0ffffff</color><width>1</width></LineStyle></Style>\n\
         <Folder><name>Lines</name>\n{lines}</Folder>\n{whole}</Document>\n</kml>\n"
    )
}

fn placemark(name: &str, places: impl Iterator<Item = LonLat>, style: &str) -> String {
    let coordinates: Vec<String> =
        places.map(|at| format!("{:.8},{:.8}", at.lon_deg, at.lat_deg)).collect();
    format!(
        "<Placemark><name>{name}</name><styleUrl>#{style}</styleUrl><LineString><tessellate>1</tessellate>\
         <coordinates>{}</coordinates></LineString></Placemark>\n",
        coordinates.join(" ")
    )
}
