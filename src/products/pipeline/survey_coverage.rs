//! Collects the data for a plan of further lines: soundings, insonified bottom, objects and
//! disagreements of all logs in one plane.

use super::ProcessedLog;
use super::joint::track_depths;
use super::surface::depth_points;
use bathyscope_bottom::bathymetry::crosslines::{TrackDepth, crossings};
use bathyscope_bottom::bathymetry::{DepthPoint, sigma_by_distance};
use bathyscope_bottom::planning::{Doubt, InsonifiedSide, SeenObject, SigmaLaw, SurveyCoverage};
use bathyscope_log::support::geo::LocalFrame;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::{median, spread_about};
use bathyscope_log::survey::{Projection, Side};
use bathyscope_objects::objects::{Object, ObjectList};
use std::f64::consts::FRAC_PI_3;

/// Least distance along the track between two looks of one side, metres.
const LOOK_STEP_M: f64 = 0.4;
/// Turn of the boat since the start of a pass at which a new pass begins, radians.
const NEW_PASS_RAD: f64 = FRAC_PI_3;
/// Speed above which the boat is taken to move, metres a second.
const MOVING_MPS: f64 = 0.3;

/// Collects the coverage of the logs of a survey in the plane of the local coordinate frame of the
/// first log. The places of `objects` are in that plane. `None` without any log.
///
/// # Errors
/// When the work was cancelled.
pub fn survey_coverage(
    logs: &[ProcessedLog],
    objects: &ObjectList,
    progress: &Progress,
) -> Result<Option<SurveyCoverage>, Cancelled> {
    let Some(first) = logs.first() else {
        return Ok(None);
    };
    let frame = &first.survey.track.frame;
    let max_gap_m = first.products.settings.surface.max_gap_m;
    let mut points: Vec<DepthPoint> = Vec::new();
    let mut tracks: Vec<Vec<TrackDepth>> = Vec::new();
    let (mut looks, mut ranges_m, mut speeds_mps) = (Vec::new(), Vec::new(), Vec::new());
    for log in logs {
        progress.check()?;
        let log = Log { log, frame };
        points.extend(log.points());
        tracks.push(log.track());
        log.add_looks(&mut looks, &mut ranges_m);
        let places = &log.log.products.navigation.pings;
        let speeds = places.iter().map(|place| place.speed_mps);
        speeds_mps.extend(speeds.filter(|speed| *speed > MOVING_MPS));
    }
    let held_out = sigma_by_distance(&points, max_gap_m, progress)?;
    let mut depths_m: Vec<f64> = points.iter().map(|point| point.depth_m).collect();
    let depth_m = median(&mut depths_m);
    let limit_m = spread_about(&mut depths_m, depth_m);
    let doubts = crossings(&tracks, progress)?.into_iter();
    Ok(Some(SurveyCoverage {
        soundings: points.iter().map(DepthPoint::place).collect(),
        sigma: SigmaLaw::new(held_out.as_ref(), finite_or_zero(limit_m)),
        looks,
        objects: seen_objects(objects, &Log { log: first, frame }),
        doubts: doubts
            .map(|crossing| Doubt { place: crossing.place, difference_m: crossing.difference_m() })
            .collect(),
        depth_m: finite_or_zero(depth_m),
        range_m: finite_or_zero(median(&mut ranges_m)),
        speed_mps: median(&mut speeds_mps),
        max_gap_m,
    }))
}

fn finite_or_zero(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

/// Log in the plane that all logs share.
struct Log<'a> {
    log: &'a ProcessedLog,
    frame: &'a LocalFrame,
}

impl Log<'_> {
    /// Returns the place in the shared plane for a place in the log's own plane.
    fn place(&self, east_m: f64, north_m: f64) -> [f64; 2] {
        let navigation = &self.log.products.navigation;
        match navigation.projection {
            // All logs of a survey are in one local coordinate frame.
            Projection::Enu => [east_m, north_m],
            Projection::Mercator => {
                let track = &self.log.survey.track;
                self.frame.to_enu(navigation.to_lon_lat(track, east_m, north_m))
            }
        }
    }

    /// Returns the points that count for the depth map.
    fn points(&self) -> Vec<DepthPoint> {
        let products = &self.log.products;
        let (cloud, classes) = (&products.cloud, &products.classes);
        depth_points(cloud, classes, &products.settings.surface, |point| {
            let [east_m, north_m] = self.place(point.east_m, point.north_m);
            [east_m, north_m, point.z_m]
        })
    }

    fn track(&self) -> Vec<TrackDepth> {
        let depths = track_depths(self.log).into_iter();
        let placed = depths.map(|depth| {
            let place = self.place(depth.east_m, depth.north_m);
            TrackDepth::new(depth.time_s, place, depth.depth_m)
        });
        placed.collect()
    }

    /// Adds the ground that both sides insonified, without excluded stretches, and the ranges.
    fn add_looks(&self, looks: &mut Vec<InsonifiedSide>, ranges_m: &mut Vec<f64>) {
        let ProcessedLog { survey, products } = self.log;
        if !survey.has_side_scan() {
            return;
        }
        let mut pass = looks.last().map_or(0, |look| look.pass + 1);
        let mut begun_rad = f64::NAN;
        let mut last = [f64::INFINITY; 2];
        for (ping, boat) in products.navigation.pings.iter().enumerate() {
            let step_m = (boat.east_m - last[0]).hypot(boat.north_m - last[1]);
            let Some([x, y]) = boat.starboard().filter(|_| step_m >= LOOK_STEP_M) else {
                continue;
            };
            if products.exclusions.ping(ping).is_some() {
                continue;
            }
            last = boat.place();
            let turned = (boat.heading_rad - begun_rad).cos();
            if begun_rad.is_nan() {
                begun_rad = boat.heading_rad;
            } else if turned < NEW_PASS_RAD.cos() {
                (pass, begun_rad) = (pass + 1, boat.heading_rad);
            }
            let depth_m = f64::from(survey.good_depth_m(ping));
            let depth_m = if depth_m > 0.0 { depth_m } else { 0.0 };
            for side in Side::BOTH {
                let Some(span) = survey.span(ping, side) else {
                    continue;
                };
                let range_m = f64::from(span.far_m);
                ranges_m.push(range_m);
                let across_m = (range_m * range_m - depth_m * depth_m).max(0.0).sqrt();
                let out_m = side.to_starboard(across_m);
                looks.push(InsonifiedSide {
                    from: self.place(boat.east_m, boat.north_m),
                    to: self.place(boat.east_m + x * out_m, boat.north_m + y * out_m),
                    pass,
                });
            }
        }
    }
}

/// Returns the objects that were accepted or drawn by hand, with the headings of their sightings in
/// all logs.
fn seen_objects(list: &ObjectList, first: &Log<'_>) -> Vec<SeenObject> {
    let is_decided = |object: &&Object| {
        let mut members = list.members(object);
        members.any(|object_box| object_box.one.state.is_object())
    };
    let seen = list.objects.iter().filter(is_decided).map(|object| {
        let targets = list.members(object).filter_map(|object_box| object_box.target.as_ref());
        let headings = targets.map(|target| target.heading_rad);
        let [east_m, north_m] = object.place_m;
        SeenObject {
            place: first.place(east_m, north_m),
            headings_rad: headings.filter(|heading| heading.is_finite()).collect(),
        }
    });
    seen.filter(|object| object.place.iter().all(|value| value.is_finite())).collect()
}
