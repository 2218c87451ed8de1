//! Results of a log that is still being written: the stages are run over its last pings, and what they find is joined to what was there.
//!
//! Nothing is measured anew that belongs to the log as a whole: calibration, flat stretches, correction of depths and the scale of the
//! picture stay those of the last run over all of it. The results are good for looking at the log while it grows; those that stay come
//! from [`run`](super::run) over the whole log.

use super::Products;
use super::products::bottom_line;
use crate::bathymetry;
use crate::cloud::{
    self, CloudPoint, PointCloud, PointScales, PointSource, Reduction, SoundingIndex,
};
use crate::first_return::{self, FirstReturns, Normalisation};
use crate::pipeline::Settings;
use crate::progress::{Cancelled, Progress};
use crate::survey::{LeftOut, Navigation, Side, Survey, navigate_mounted};
use std::ops::Range;
use std::sync::Arc;

/// Pings before the first new one whose results are made again: they had no neighbours behind them.
const AGAIN: usize = 128;
/// Pings before those that the stages look at as well.
const CONTEXT: usize = 384;
/// The line of first returns is found in stretches that begin at multiples of this: here as over the whole log.
const ALIGNED: usize = 512;

/// What the results of a growing log go on with, measured over all of it.
#[derive(Clone, Debug)]
pub struct GrowingScale {
    normalisation: Normalisation,
}

impl GrowingScale {
    /// Of a log as it is now.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn measure(
        survey: &Survey,
        settings: &Settings,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let dead_zone_m = settings.first_return.dead_zone_m;
        let normalisation = Normalisation::measure(survey, &settings.image, dead_zone_m, progress)?;
        Ok(Self { normalisation })
    }
}

/// Pings whose results are made again, and those that are looked at for it; both reach to the end of the log.
struct Part {
    first: usize,
    context: usize,
    /// First sounding of each.
    first_sounding: usize,
    context_sounding: usize,
}

/// The results of `before`, of the same log when it was shorter, with those of what was added. All pings before `unchanged` are as they
/// were. Takes time for the new pings and copies the rest.
///
/// # Errors
/// When the work was cancelled.
pub fn extend(
    survey: &Survey,
    unchanged: usize,
    before: &Products,
    settings: &Arc<Settings>,
    scale: &mut GrowingScale,
    progress: &Progress,
) -> Result<Products, Cancelled> {
    let known = unchanged.min(before.navigation.pings.len());
    let first = known.saturating_sub(AGAIN);
    let context = first.saturating_sub(CONTEXT) / ALIGNED * ALIGNED;
    let (stretch, context_sounding) = survey.stretch_from(context);
    let from_s = survey
        .side_scan
        .get(first)
        .map_or(f64::INFINITY, |ping| ping.time_s);
    let part = Part {
        first,
        context,
        first_sounding: survey.soundings.partition_point(|one| one.time_s < from_s),
        context_sounding,
    };
    let (how, mounting) = (&settings.heading, &settings.mounting);
    let navigation = navigate_mounted(&stretch, how, mounting, settings.projection, progress)?;
    let found = found(&stretch, &part, before, settings, scale, progress)?;
    let mut returns = found.clone();
    settings.bottom.apply(survey, &mut returns);
    let all_navigation = part.join_navigation(&before.navigation, &navigation);
    let left_out = LeftOut::new(survey, &all_navigation, &settings.left_out);
    let counted = match left_out.is_empty() {
        true => of_stretch(&returns, part.context..survey.side_scan.len()),
        false => of_stretch(
            &returns.without(&left_out),
            part.context..survey.side_scan.len(),
        ),
    };
    let correction = &before.correction;
    let cloud = cloud::build(
        &stretch,
        &navigation,
        &counted,
        &before.calibration,
        &settings.cloud,
        correction,
        progress,
    )?;
    let least = settings.first_return.min_confidence;
    let kept = cloud::keep_points(&cloud, least, &settings.outliers, progress)?;
    let depths = cloud::ping_depths(&stretch, &cloud, &kept, correction);
    let all_depths = [
        &before.depths[..part.first.min(before.depths.len())],
        &depths[part.first - part.context..],
    ]
    .concat();
    let all_depths = cloud::without_left_out(all_depths, &left_out);
    let new_depths = all_depths[part.first..].iter().map(|depth| depth.depth_m);
    let depth_range_m = wider(before.depth_range_m, bathymetry::depth_range(new_depths));
    let reduction = Reduction::new(&before.calibration, correction);
    let returns = Arc::new(returns);
    let bottom_line = bottom_line(survey, settings, &returns, &reduction);
    let new_scales = PointScales::of(&stretch, &cloud, &kept, &reduction);
    let (cloud, kept) = part.join_cloud(before, &cloud, &kept, &left_out, &all_navigation);
    Ok(Products {
        settings: settings.clone(),
        navigation: Arc::new(all_navigation),
        left_out: Arc::new(left_out),
        flat_spots: before.flat_spots.clone(),
        found: Arc::new(found),
        returns,
        bottom_line,
        calibration: before.calibration.clone(),
        correction: correction.clone(),
        cloud: Arc::new(cloud),
        kept: Arc::new(kept),
        depths: Arc::new(all_depths),
        depth_range_m,
        scales: before.scales.with(new_scales),
    })
}

/// First returns of all pings, those of the part anew.
fn found(
    stretch: &Survey,
    part: &Part,
    before: &Products,
    settings: &Settings,
    scale: &mut GrowingScale,
    progress: &Progress,
) -> Result<FirstReturns, Cancelled> {
    let dead_zone_m = settings.first_return.dead_zone_m;
    let here = Normalisation::measure(stretch, &settings.image, dead_zone_m, progress)?;
    scale.normalisation = scale.normalisation.widened(&here);
    let new = first_return::detect_with(
        stretch,
        &settings.image,
        &settings.first_return,
        &scale.normalisation,
        progress,
    )?;
    let side = |side: Side| {
        let known = &before.found.side(side)[..part.first];
        [known, &new.side(side)[part.first - part.context..]].concat()
    };
    Ok(FirstReturns {
        port: side(Side::Port),
        starboard: side(Side::Starboard),
        warnings: new.warnings,
        drawn: Vec::new(),
    })
}

fn of_stretch(returns: &FirstReturns, pings: Range<usize>) -> FirstReturns {
    FirstReturns {
        port: returns.port[pings.clone()].to_vec(),
        starboard: returns.starboard[pings].to_vec(),
        ..FirstReturns::default()
    }
}

impl Part {
    fn join_navigation(&self, before: &Navigation, new: &Navigation) -> Navigation {
        let pings = [
            &before.pings[..self.first],
            &new.pings[self.first - self.context..],
        ]
        .concat();
        let known = self.first_sounding.min(before.soundings.len());
        let soundings = [
            &before.soundings[..known],
            &new.soundings[known - self.context_sounding..],
        ]
        .concat();
        // How many pings of the part move is not told apart from how many of the context do.
        let share =
            (new.pings.len() + self.context - self.first) as f64 / new.pings.len().max(1) as f64;
        let known_share = self.first as f64 / before.pings.len().max(1) as f64;
        let moving = before.moving as f64 * known_share + new.moving as f64 * share;
        // Neither has one, or both have one for each ping.
        let known_antenna = &before.antenna[..self.first.min(before.antenna.len())];
        let added = new.antenna.get(self.first - self.context..);
        let antenna = [known_antenna, added.unwrap_or_default()].concat();
        Navigation {
            antenna,
            zero_heading: pings
                .iter()
                .filter(|ping| ping.heading_rad.is_nan())
                .count(),
            moving: moving.round() as usize,
            pings,
            soundings,
            projection: new.projection,
        }
    }

    /// Which points of a source, of points in the order of [`PointCloud`], lie before the part.
    fn known_of(&self, points: &[CloudPoint], source: PointSource) -> Range<usize> {
        let start = points.partition_point(|point| point.source < source);
        let known = points[start..].partition_point(|point| {
            point.source == source
                && match point.sounding {
                    Some(sounding) => sounding.get() < self.first_sounding,
                    None => (point.ping as usize) < self.first,
                }
        });
        start..start + known
    }

    /// The points of before that lie before the part, and the new ones of the part; sorted as [`PointCloud`] says.
    fn join_cloud(
        &self,
        before: &Products,
        new: &PointCloud,
        kept: &[bool],
        left_out: &LeftOut,
        navigation: &Navigation,
    ) -> (PointCloud, Vec<bool>) {
        let count = before.cloud.points.len() + new.points.len();
        let (mut points, mut flags) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for source in [
            PointSource::DownScan,
            PointSource::Port,
            PointSource::Starboard,
        ] {
            // Copied as a whole: looked at one by one, the points of a long log would take longer than all that is new.
            let old = self.known_of(&before.cloud.points, source);
            points.extend_from_slice(&before.cloud.points[old.clone()]);
            flags.extend_from_slice(&before.kept[old]);
            let added = new
                .points
                .iter()
                .zip(kept)
                .filter(|(point, _)| point.source == source);
            for (point, flag) in added {
                let ping = point.ping as usize + self.context;
                let sounding = point.sounding.map(|one| one.get() + self.context_sounding);
                let (is_new, is_out) = match sounding {
                    Some(sounding) => (
                        sounding >= self.first_sounding,
                        left_out.sounding(sounding).is_some(),
                    ),
                    None => (ping >= self.first, left_out.ping(ping).is_some()),
                };
                if is_new && !is_out {
                    let mut point = *point;
                    point.ping = ping as u32;
                    point.sounding = sounding.and_then(SoundingIndex::new);
                    points.push(point);
                    flags.push(*flag);
                }
            }
        }
        let cloud = PointCloud {
            points,
            zero_heading: navigation.zero_heading,
        };
        (cloud, flags)
    }
}

fn wider(one: Option<[f32; 2]>, other: Option<[f32; 2]>) -> Option<[f32; 2]> {
    match (one, other) {
        (Some([a, b]), Some([c, d])) => Some([a.min(c), b.max(d)]),
        (one, other) => one.or(other),
    }
}
