//! Small files beside a survey: tracks, water levels, areas.

use super::projects::held_as;
use super::{check_finite, logs, say};
use bathyscope_log::formats::{TrackFile, open_bytes, read_area, read_gauge};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use std::sync::LazyLock;

/// A log to lay tracks over.
fn pond() -> Survey {
    static POND: LazyLock<Survey> = LazyLock::new(|| {
        let log = logs::sl2_seeds().swap_remove(0);
        open_bytes("pond.sl2", log, &Progress::new()).expect("a log")
    });
    POND.clone()
}

pub(super) fn track(bytes: &[u8]) {
    held_as("track", bytes, |path| match TrackFile::read(path) {
        Ok(track) => {
            let mut survey = pond();
            match track.apply(&mut survey, 0.0) {
                Ok(()) => check_finite(survey.track.fixes.iter().map(|fix| fix.time_s)),
                Err(error) => say(&error),
            }
        }
        Err(error) => say(&error),
    });
}

pub(super) fn track_seeds() -> Vec<Vec<u8>> {
    let csv = "time,lon,lat,heading_deg\n-1,-111.0,36.0,10\n0.1,-111.00001,36.00001,12\n9,-111.0002,36.0002,\n";
    let utc = "utc;longitude;latitude\n2021-10-12T00:53:20Z;-111.0;36.0\n2021-10-12T00:53:21.5+02:00;-111.00001;36.00001\n";
    let gpx = "<?xml version=\"1.0\"?><gpx><trk><trkseg><trkpt lat=\"36.0\" lon=\"-111.0\"><time>2021-10-12T00:53:20Z</time></trkpt>\n\
        <trkpt lat=\"36.00001\" lon=\"-111.00001\"><ele>1</ele><time>2021-10-12T00:53:21Z</time></trkpt></trkseg></trk></gpx>\n";
    [csv, utc, gpx].map(|text| text.as_bytes().to_vec()).into()
}

pub(super) fn gauge(bytes: &[u8]) {
    held_as("levels.csv", bytes, |path| match read_gauge(path) {
        Ok(gauge) => {
            assert!(!gauge.readings.is_empty());
            check_finite(gauge.readings.iter().flat_map(|(time_s, level_m)| [*time_s, *level_m]));
        }
        Err(error) => say(&error),
    });
}

pub(super) fn gauge_seeds() -> Vec<Vec<u8>> {
    let semicolons =
        "# gauge at the dam\nstation;time;level_m\nA;2021-10-12T00:53:20Z;1.5\nA;1634003600;2.5\n";
    let commas = "time,level_m\n1634000000,1.0\n1634000010,1.01\n";
    [semicolons, commas].map(|text| text.as_bytes().to_vec()).into()
}

pub(super) fn area(bytes: &[u8]) {
    held_as("area", bytes, |path| match read_area(path) {
        Ok(area) => {
            let corners = area.rings.iter().flatten();
            check_finite(corners.flat_map(|corner| [corner.lon_deg, corner.lat_deg]));
        }
        Err(error) => say(&error),
    });
}

pub(super) fn area_seeds() -> Vec<Vec<u8>> {
    let geojson = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":{"type":"MultiPolygon","coordinates":[[[[8,47],[8.1,47],[8.1,47.1],[8,47]]]]}},
        {"type":"GeometryCollection","geometries":[{"type":"Polygon","coordinates":[[[8,47],[8.1,47],[8.1,47.1]]]}]}]}"#;
    let kml = "<?xml version='1.0'?><kml><Placemark><Polygon><outerBoundaryIs><LinearRing><coordinates>\n 8,47,0 8.1,47,0\n8.1,47.1 8,47 </coordinates>\
        </LinearRing></outerBoundaryIs></Polygon></Placemark></kml>";
    let gpx = "<gpx><trk><trkseg><trkpt lat='47' lon='8'/><trkpt lat='47' lon='8.1'/><trkpt lat='47.1' lon='8.1'/></trkseg></trk><rte><rtept lat='47' lon='8'/></rte></gpx>";
    [geojson, kml, gpx].map(|text| text.as_bytes().to_vec()).into()
}
