//! Crossline analysis of one log: depths where its track crosses itself.

use super::residuals::kept_of;
use crate::bathymetry::crosslines::{Crossing, LEAST_ANGLE_DEG, REACH_M, TrackDepth, crossings};
use crate::cloud::{PointSource, Residuals};
use crate::pipeline::Products;
use crate::progress::{Cancelled, Progress};
use crate::survey::Survey;
use serde::Serialize;

/// The differences at the crossings, and their statistics.
#[derive(Serialize)]
pub struct OwnCrosslines {
    sign: &'static str,
    least_angle_deg: f64,
    reach_m: f64,
    #[serde(flatten)]
    residuals: Residuals,
    /// The first of them in time order.
    list: Vec<Listed>,
}

#[derive(Serialize)]
struct Listed {
    lon: f64,
    lat: f64,
    time_s: [f64; 2],
    depth_m: [f64; 2],
    difference_m: f64,
    angle_deg: f64,
}

const SIGN: &str =
    "elevation of the later pass minus that of the earlier, metres; positive is shallower";
/// More than this are not listed one by one.
const MOST_LISTED: usize = 10_000;

/// `None` where the track never crosses itself over soundings.
pub fn own_crosslines(
    survey: &Survey,
    products: &Products,
    progress: &Progress,
) -> Result<Option<OwnCrosslines>, Cancelled> {
    let soundings = kept_of(products, &[PointSource::DownScan]);
    let depths = soundings.into_iter().filter_map(|point| {
        Some(TrackDepth {
            time_s: survey.soundings.get(point.sounding?.get())?.time_s,
            east_m: point.east_m,
            north_m: point.north_m,
            depth_m: -point.z_m,
        })
    });
    let depths = depths.filter(|depth| depth.depth_m.is_finite());
    let found = crossings(&[depths.collect()], progress)?;
    let mut differences: Vec<f64> = found.iter().map(Crossing::difference_m).collect();
    let listed = |one: &Crossing| {
        let [east_m, north_m] = one.place;
        let at = products
            .navigation
            .to_lon_lat(&survey.track, east_m, north_m);
        Listed {
            lon: at.lon_deg,
            lat: at.lat_deg,
            time_s: one.passes.map(|pass| pass.time_s),
            depth_m: one.passes.map(|pass| pass.depth_m),
            difference_m: one.difference_m(),
            angle_deg: one.angle_deg,
        }
    };
    Ok(
        Residuals::of(&mut differences).map(|residuals| OwnCrosslines {
            sign: SIGN,
            least_angle_deg: LEAST_ANGLE_DEG,
            reach_m: REACH_M,
            residuals,
            list: found.iter().take(MOST_LISTED).map(listed).collect(),
        }),
    )
}
