//! Writes lines to sail, for plotters, maps and autopilots.
//!
//! In: planned lines. Out: a file for a plotter, a map or an autopilot.
//!
//! GPX and KML files hold the lines and the whole way; the files of QGroundControl and Mission
//! Planner hold the way as a mission.

use super::{ExportError, GPX_HEAD, KML_HEAD, write_bytes};
use crate::Error;
use bathyscope_bottom::planning::{Plan, WaypointKind};
use bathyscope_log::support::geo::{LocalFrame, LonLat};
use bathyscope_log::support::printable::xml;
use serde_json::{Value, json};
use std::path::Path;

/// `MAV_CMD_NAV_WAYPOINT` of MAVLink.
const NAV_WAYPOINT: u16 = 16;
/// `MAV_FRAME_GLOBAL_RELATIVE_ALT`: heights are relative to the home position.
const RELATIVE_HEIGHT: u8 = 3;
/// `MAV_AUTOPILOT_ARDUPILOTMEGA`.
const ARDUPILOT: u8 = 3;
/// `MAV_TYPE_SURFACE_BOAT`.
const SURFACE_BOAT: u8 = 11;
/// `MAV_FRAME_GLOBAL`, for the home position.
const ABSOLUTE_HEIGHT: u8 = 0;

/// A kind of file that a plan can be written to.
#[derive(Clone, Copy, Debug)]
pub struct PlanFormat {
    /// Ending of the files of the format.
    ending: &'static str,
    /// Returns the content of a file.
    text: fn(&PlannedWay<'_>) -> String,
}

/// All formats: GPX 1.1 with a waypoint at both ends of every line, and the way as a route; KML 2.2
/// with the lines and the way; a mission of QGroundControl; a mission of Mission Planner, `QGC WPL
/// 110`.
const PLAN_FORMATS: [PlanFormat; 4] = [
    PlanFormat { ending: "gpx", text: gpx_text },
    PlanFormat { ending: "kml", text: kml_text },
    PlanFormat { ending: "plan", text: qgroundcontrol_text },
    PlanFormat { ending: "waypoints", text: mission_planner_text },
];

impl PlanFormat {
    /// Returns the format for the ending of a file name.
    ///
    /// # Errors
    /// When there is no format for this ending.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let ending = path.extension().unwrap_or_default();
        let format =
            PLAN_FORMATS.into_iter().find(|format| ending.eq_ignore_ascii_case(format.ending));
        let refused = || {
            format!(
                "lines are written as .gpx, .kml, .plan (QGroundControl) or .waypoints (Mission Planner); name the file so: {}",
                path.display()
            )
        };
        Ok(format.ok_or_else(refused)?)
    }
}

/// A plan with its place on the Earth.
#[derive(Clone, Copy, Debug)]
pub struct PlannedWay<'a> {
    /// Name of the plan.
    pub name: &'a str,
    /// The plan.
    pub plan: &'a Plan,
    /// Local coordinate frame of the plan.
    pub frame: &'a LocalFrame,
    /// Place where the boat starts and to which it returns.
    pub home: LonLat,
}

/// A place of the way in longitude and latitude.
struct WayPlace {
    at: LonLat,
    station: WaypointKind,
}

impl PlannedWay<'_> {
    /// Writes the plan to a file.
    pub fn write(&self, path: &Path, format: PlanFormat) -> Result<(), ExportError> {
        write_bytes(path, (format.text)(self))
    }

    fn places(&self) -> impl Iterator<Item = WayPlace> {
        let way = self.plan.way.iter();
        way.map(|waypoint| WayPlace { at: self.lon_lat(waypoint.place), station: waypoint.station })
    }

    fn lon_lat(&self, [east_m, north_m]: [f64; 2]) -> LonLat {
        self.frame.to_lon_lat(east_m, north_m)
    }

    /// Describes the plan: `14 lines, 2310 m with turns, 19.8 min at 1.9 m/s`.
    fn description(&self) -> String {
        let plan = self.plan;
        format!(
            "{} lines, {:.0} m with turns, {:.1} min at {:.1} m/s",
            plan.lines.len(),
            plan.length_m,
            plan.minutes(),
            plan.speed_mps
        )
    }
}

impl WayPlace {
    /// Returns the name of the place: `L3 start`, `L3 end`, `turn`; lines are counted from 1.
    fn name(&self) -> String {
        match self.station {
            WaypointKind::Start(line) => format!("L{} start", line + 1),
            WaypointKind::End(line) => format!("L{} end", line + 1),
            WaypointKind::Turn => "turn".to_owned(),
        }
    }
}

fn gpx_text(way: &PlannedWay<'_>) -> String {
    let ends = way.places().filter(|place| place.station != WaypointKind::Turn);
    let waypoints: String = ends.map(|place| point("wpt", &place)).collect();
    let route: String = way.places().map(|place| point("rtept", &place)).collect();
    let (name, description) = (xml(way.name), xml(&way.description()));
    format!(
        "{GPX_HEAD}>\n<metadata><name>{name}</name><desc>{description}</desc></metadata>\n\
         {waypoints}<rte><name>{name}</name><desc>{description}</desc>\n{route}</rte>\n</gpx>\n"
    )
}

fn point(kind: &str, place: &WayPlace) -> String {
    let (lat, lon) = (place.at.lat_deg, place.at.lon_deg);
    let name = place.name();
    format!("<{kind} lat=\"{lat:.8}\" lon=\"{lon:.8}\"><name>{name}</name></{kind}>\n")
}

fn kml_text(way: &PlannedWay<'_>) -> String {
    let line = |(number, leg): (usize, &bathyscope_bottom::planning::Leg)| {
        let ends = [leg.from, leg.to].map(|place| way.lon_lat(place));
        placemark(&format!("L{number}"), ends.into_iter(), "line")
    };
    let lines: String = (1..).zip(&way.plan.lines).map(line).collect();
    let whole = placemark("way", way.places().map(|place| place.at), "way");
    let (name, description) = (xml(way.name), xml(&way.description()));
    // Colours are alpha, blue, green, red.
    format!(
        "{KML_HEAD}<name>{name}</name><description>{description}</description>\n\
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

fn qgroundcontrol_text(way: &PlannedWay<'_>) -> String {
    let items: Vec<Value> = (1..).zip(way.places()).map(item).collect();
    let speed_mps = way.plan.speed_mps;
    let plan = json!({
        "fileType": "Plan",
        "geoFence": { "circles": [], "polygons": [], "version": 2 },
        "groundStation": "QGroundControl",
        "mission": {
            "cruiseSpeed": speed_mps,
            "firmwareType": ARDUPILOT,
            "globalPlanAltitudeMode": 1,
            "hoverSpeed": speed_mps,
            "items": items,
            "plannedHomePosition": [degrees(way.home.lat_deg), degrees(way.home.lon_deg), 0.0],
            "vehicleType": SURFACE_BOAT,
            "version": 2,
        },
        "rallyPoints": { "points": [], "version": 2 },
        "version": 1,
    });
    format!("{plan:#}\n")
}

fn item((number, place): (u32, WayPlace)) -> Value {
    let (lat_deg, lon_deg) = (degrees(place.at.lat_deg), degrees(place.at.lon_deg));
    json!({
        "AMSLAltAboveTerrain": null,
        "Altitude": 0.0,
        "AltitudeMode": 1,
        "autoContinue": true,
        "command": NAV_WAYPOINT,
        "doJumpId": number,
        "frame": RELATIVE_HEIGHT,
        // Hold time, acceptance radius, pass radius, yaw (the autopilot's own), latitude,
        // longitude, height.
        "params": [0.0, 0.0, 0.0, null, lat_deg, lon_deg, 0.0],
        "type": "SimpleItem",
    })
}

/// Rounds degrees to about a millimetre.
fn degrees(degrees: f64) -> f64 {
    (degrees * 1e8).round() / 1e8
}

/// Returns a row for each place: number, a flag for the current place, frame, command, four
/// parameters, latitude, longitude, height, a flag to continue automatically. Row 0 is home.
fn mission_planner_text(way: &PlannedWay<'_>) -> String {
    let mut text = "QGC WPL 110\n".to_owned() + &row(0, ABSOLUTE_HEIGHT, way.home);
    for (number, place) in (1..).zip(way.places()) {
        text += &row(number, RELATIVE_HEIGHT, place.at);
    }
    text
}

fn row(number: u32, frame: u8, at: LonLat) -> String {
    let current = u8::from(number == 0);
    let (lat, lon) = (at.lat_deg, at.lon_deg);
    let parameters = "0\t0\t0\t0";
    format!(
        "{number}\t{current}\t{frame}\t{NAV_WAYPOINT}\t{parameters}\t{lat:.8}\t{lon:.8}\t0.000000\t1\n"
    )
}
