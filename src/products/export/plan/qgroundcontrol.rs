//! `.plan` of QGroundControl, version 1, as its developer guide has it ("Plan File Format").

use super::{PlannedWay, WayPlace};
use serde_json::{Value, json};

/// `MAV_CMD_NAV_WAYPOINT` of MAVLink.
pub(super) const NAV_WAYPOINT: u16 = 16;
/// `MAV_FRAME_GLOBAL_RELATIVE_ALT`: heights count from home.
pub(super) const RELATIVE_HEIGHT: u8 = 3;
/// `MAV_AUTOPILOT_ARDUPILOTMEGA`.
const ARDUPILOT: u8 = 3;
/// `MAV_TYPE_SURFACE_BOAT`.
const SURFACE_BOAT: u8 = 11;

pub(super) fn text(way: &PlannedWay<'_>) -> String {
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
