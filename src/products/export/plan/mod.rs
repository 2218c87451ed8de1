//! Lines to sail, for plotters, maps and autopilots.
//!
//! In: planned lines. Out: a file for a plotter, a map or an autopilot.
//!
//! `gpx` and `kml` have lines and way, `qgroundcontrol` and `mission_planner` the way as a mission.

mod gpx;
mod kml;
mod mission_planner;
mod qgroundcontrol;

use super::{ExportError, write_bytes};
use bathyscope_bottom::planning::{Plan, WaypointKind};
use bathyscope_log::support::geo::{LocalFrame, LonLat};
use std::path::{Path, PathBuf};

/// A kind of file that a plan can be written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanFormat {
    /// GPX 1.1: a waypoint at both ends of every line, and the way as a route.
    Gpx,
    /// KML 2.2: lines and way.
    Kml,
    /// A mission of QGroundControl.
    QGroundControl,
    /// A mission of Mission Planner, `QGC WPL 110`.
    MissionPlanner,
}

/// A name that says nothing of what is to be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "lines are written as .gpx, .kml, .plan (QGroundControl) or .waypoints (Mission Planner); name the file so: {}", .0.display()
)]
pub struct PlanFormatError(pub PathBuf);

impl PlanFormat {
    /// All of them.
    pub const ALL: [PlanFormat; 4] =
        [PlanFormat::Gpx, PlanFormat::Kml, PlanFormat::QGroundControl, PlanFormat::MissionPlanner];

    /// Returns the ending of its files.
    pub(crate) fn ending(self) -> &'static str {
        match self {
            PlanFormat::Gpx => "gpx",
            PlanFormat::Kml => "kml",
            PlanFormat::QGroundControl => "plan",
            PlanFormat::MissionPlanner => "waypoints",
        }
    }

    /// Returns the format that the name of a file asks for.
    ///
    /// # Errors
    /// When it ends like none of them.
    pub fn of(path: &Path) -> Result<Self, PlanFormatError> {
        let ending = path.extension().unwrap_or_default();
        let format =
            Self::ALL.into_iter().find(|format| ending.eq_ignore_ascii_case(format.ending()));
        format.ok_or_else(|| PlanFormatError(path.to_owned()))
    }
}

/// A plan on the Earth.
#[derive(Clone, Copy, Debug)]
pub struct PlannedWay<'a> {
    /// Name.
    pub name: &'a str,
    /// The plan.
    pub plan: &'a Plan,
    /// The frame of its plane.
    pub frame: &'a LocalFrame,
    /// Place where the boat starts and to which it returns.
    pub home: LonLat,
}

/// A place of the way on the Earth.
struct WayPlace {
    at: LonLat,
    station: WaypointKind,
}

impl PlannedWay<'_> {
    /// Writes it.
    pub fn write(&self, path: &Path, format: PlanFormat) -> Result<(), ExportError> {
        let text = match format {
            PlanFormat::Gpx => gpx::text(self),
            PlanFormat::Kml => kml::text(self),
            PlanFormat::QGroundControl => qgroundcontrol::text(self),
            PlanFormat::MissionPlanner => mission_planner::text(self),
        };
        write_bytes(path, text)
    }

    fn places(&self) -> impl Iterator<Item = WayPlace> {
        let way = self.plan.way.iter();
        way.map(|waypoint| WayPlace { at: self.lon_lat(waypoint.place), station: waypoint.station })
    }

    fn lon_lat(&self, [east_m, north_m]: [f64; 2]) -> LonLat {
        self.frame.to_lon_lat(east_m, north_m)
    }

    /// `14 lines, 2310 m with turns, 19.8 min at 1.9 m/s`.
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
    /// `L3 start`, `L3 end`, `turn`; lines count from 1.
    fn name(&self) -> String {
        match self.station {
            WaypointKind::Start(line) => format!("L{} start", line + 1),
            WaypointKind::End(line) => format!("L{} end", line + 1),
            WaypointKind::Turn => "turn".to_owned(),
        }
    }
}
