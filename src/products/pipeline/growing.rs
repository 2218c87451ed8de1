//! Extends the results of a log that is still being written: the stages are run over its last
//! pings, and their results are joined to the earlier ones.
//!
//! Properties of the whole log are not measured again: calibration, flat stretches, correction of
//! depths and the scale of the picture stay those of the last run over the whole log. The results
//! are for viewing the log while it grows; the final results come from [`run`](super::run) over the
//! whole log.

use super::Products;
use super::run_stages::bottom_line;
use crate::pipeline::Settings;
use bathyscope_bottom::cloud::{
    self, BySource, CloudPoint, PingDepth, PointClass, PointCloud, PointRecord, PointScales,
    PointSource, RecordIndex, Reduction,
};
use bathyscope_bottom::first_return::{self, FalseSoundings, FirstReturns, Normalisation, Pick};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::{colour_ends, wider};
use bathyscope_log::support::versions::Versions;
use bathyscope_log::survey::{
    Exclusions, Navigation, PingNav, Side, StretchStart, Survey, navigate_with,
};
use std::ops::Range;
use std::sync::Arc;

/// Number of pings before the first new ping whose results are computed again, since they had no
/// neighbours after them.
const AGAIN: usize = 128;
/// Number of further pings before those, which the stages read as well.
const CONTEXT: usize = 384;
/// Stretches in which the line of first returns is found begin at multiples of this number of
/// pings, as in a run over the whole log.
const ALIGNED: usize = 512;

/// State from which the results of a growing log are extended.
#[derive(Debug)]
pub struct GrowingResults {
    /// Scale of the picture, measured over the whole log.
    normalisation: Normalisation,
    versions: ResultVersions,
}

/// Versions of the lists of results, each of which extends the one before.
#[derive(Debug, Default)]
struct ResultVersions {
    pings: Versions<PingNav>,
    soundings: Versions<PingNav>,
    swath: Versions<PingNav>,
    antenna: Versions<[f64; 2]>,
    port: Versions<Pick>,
    starboard: Versions<Pick>,
    points: [Versions<CloudPoint>; PointSource::ALL.len()],
    depths: Versions<PingDepth>,
}

impl GrowingResults {
    /// Measures the scale of the picture of a log in its current state.
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
        Ok(Self { normalisation, versions: ResultVersions::default() })
    }
}

/// Pings whose results are computed again (from `first`), and those that the stages read for it
/// (from `context`); both reach to the end of the log.
struct Part {
    first: usize,
    context: usize,
    /// Starts of `first` and `context` in the other records.
    first_start: StretchStart,
    context_start: StretchStart,
}

/// Extends the results `before`, of the same log when it was shorter, by the results of the added
/// pings. All pings before `unchanged` are unchanged. The time needed depends on the number of new
/// pings; for the other pings, only the classes of points are copied, and the bottom edits and
/// excluded stretches are applied again.
///
/// # Errors
/// When the work was cancelled.
pub fn extend(
    survey: &Survey,
    unchanged: usize,
    before: &Products,
    settings: &Arc<Settings>,
    growing: &mut GrowingResults,
    progress: &Progress,
) -> Result<Products, Cancelled> {
    let known = unchanged.min(before.navigation.pings.len());
    let first = known.saturating_sub(AGAIN);
    let context = first.saturating_sub(CONTEXT) / ALIGNED * ALIGNED;
    let (stretch, context_start) = survey.stretch_from(context);
    let part = Part { first, context, first_start: survey.stretch_start(first), context_start };
    let navigation = navigate_with(&stretch, settings.position_settings(), progress)?;
    let found = found(&stretch, &part, before, settings, growing, progress)?;
    let stretch = part.judged(stretch, &found);
    let mut returns = found.clone();
    settings.bottom.apply(survey, &mut returns);
    let versions = &mut growing.versions;
    let all_navigation = part.join_navigation(&before.navigation, &navigation, versions);
    let exclusions = Exclusions::new(survey, &all_navigation, &settings.excluded);
    let counted = counted_of(&returns, part.context..survey.side_scan.len(), &exclusions);
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
    let classes = cloud::classify(&cloud, &settings.class_rules(), progress)?;
    let depths = cloud::ping_depths(
        &stretch,
        &navigation.pings,
        (&cloud, settings.cloud.geometry),
        &classes,
        correction,
    );
    let new_depths = &depths[part.first - part.context..];
    let all_depths =
        (versions.depths).next_changed(&before.depths, part.first, new_depths, |all| {
            let first = part.first.min(all.len());
            cloud::clear_excluded_depths(&mut all[first..], first, &exclusions);
            first
        });
    let new_depths = all_depths[part.first..].iter().map(|depth| depth.depth_m);
    let depth_range_m = wider(before.depth_range_m, colour_ends(new_depths));
    let reduction = Reduction::new(&before.calibration, correction);
    let returns = Arc::new(returns);
    let bottom_line = bottom_line(survey, settings, &returns, &reduction);
    let new_scales = PointScales::of(&stretch, &cloud, &classes, &reduction);
    let points = &mut versions.points;
    let (points, classes) = part.join_points(before, &cloud.points, &classes, &exclusions, points);
    let cloud = PointCloud { points, zero_heading: all_navigation.zero_heading };
    Ok(Products {
        settings: settings.clone(),
        navigation: Arc::new(all_navigation),
        exclusions: Arc::new(exclusions),
        flat_spots: before.flat_spots.clone(),
        found: Arc::new(found),
        judged: None,
        latency: before.latency,
        repeatability: before.repeatability,
        clutter: before.clutter,
        returns,
        bottom_line,
        calibration: before.calibration.clone(),
        correction: correction.clone(),
        cloud: Arc::new(cloud),
        classes: Arc::new(classes),
        depths: all_depths,
        // The new part has a level bottom: the surface is that of the last run over the whole log.
        relief: before.relief.clone(),
        depth_range_m,
        scales: before.scales.with(new_scales),
    })
}

/// Returns the first returns of all pings; those of the part are found again.
fn found(
    stretch: &Survey,
    part: &Part,
    before: &Products,
    settings: &Settings,
    growing: &mut GrowingResults,
    progress: &Progress,
) -> Result<FirstReturns, Cancelled> {
    let dead_zone_m = settings.first_return.dead_zone_m;
    let here = Normalisation::measure(stretch, &settings.image, dead_zone_m, progress)?;
    growing.normalisation = growing.normalisation.widened(&here);
    let new = first_return::detect_with(
        stretch,
        &settings.image,
        &settings.first_return,
        &growing.normalisation,
        progress,
    )?;
    let from = part.first - part.context;
    let (known, versions) = (&before.found, &mut growing.versions);
    let false_soundings = Arc::new(part.join_false_soundings(known, &new));
    Ok(FirstReturns {
        port: (versions.port).next(&known.port, part.first, &new.port[from..]),
        starboard: (versions.starboard).next(&known.starboard, part.first, &new.starboard[from..]),
        warnings: new.warnings,
        drawn: Vec::new(),
        false_soundings,
    })
}

/// Returns the picks of a stretch of pings, without those of excluded pings.
fn counted_of(
    returns: &FirstReturns,
    pings: Range<usize>,
    exclusions: &Exclusions,
) -> FirstReturns {
    let counted = |side: Side| {
        let picks = pings.clone().map(|ping| match exclusions.ping(ping) {
            Some(_) => Pick::NONE,
            None => returns.side(side)[ping],
        });
        Arc::new(picks.collect())
    };
    FirstReturns {
        port: counted(Side::Port),
        starboard: counted(Side::Starboard),
        ..FirstReturns::default()
    }
}

impl Part {
    /// Returns the stretch from the context on, with the soundings marked that first returns
    /// contradict.
    fn judged(&self, stretch: Survey, found: &FirstReturns) -> Survey {
        let from = self.context_start.sounding;
        let here =
            found.false_soundings.iter().filter(|false_stretch| false_stretch.soundings.end > from);
        let here = here.map(|false_stretch| FalseSoundings {
            soundings: false_stretch.soundings.start.saturating_sub(from)
                ..false_stretch.soundings.end - from,
            fault: false_stretch.fault,
        });
        let here =
            FirstReturns { false_soundings: Arc::new(here.collect()), ..FirstReturns::default() };
        here.judged(&stretch).unwrap_or(stretch)
    }

    /// Returns the earlier false soundings before the part, and the new ones in the part.
    fn join_false_soundings(
        &self,
        known: &FirstReturns,
        new: &FirstReturns,
    ) -> Vec<FalseSoundings> {
        let (part, from) = (self.first_start.sounding, self.context_start.sounding);
        let before = known
            .false_soundings
            .iter()
            .filter(|false_stretch| false_stretch.soundings.start < part)
            .cloned();
        let mut all: Vec<FalseSoundings> = before.collect();
        for false_stretch in new.false_soundings.iter() {
            let soundings =
                false_stretch.soundings.start + from..false_stretch.soundings.end + from;
            if soundings.end <= part {
                continue;
            }
            match all.last_mut() {
                Some(last) if last.soundings.end > soundings.start => {
                    last.soundings.end = last.soundings.end.max(soundings.end);
                }
                _ => all.push(FalseSoundings { soundings, fault: false_stretch.fault }),
            }
        }
        all
    }

    fn join_navigation(
        &self,
        before: &Navigation,
        new: &Navigation,
        versions: &mut ResultVersions,
    ) -> Navigation {
        let without_heading = |pings: &[PingNav]| {
            let without = pings.iter().filter(|ping| ping.heading_rad.is_nan());
            without.count()
        };
        let (again, added) = (&before.pings[self.first..], &new.pings[self.first - self.context..]);
        let known = self.first_start.sounding.min(before.soundings.len());
        let new_soundings = &new.soundings[known - self.context_start.sounding..];
        let known_swath = self.first_start.swath.min(before.swath.len());
        let new_swath = &new.swath[known_swath - self.context_start.swath..];
        // The share of moving pings is taken to be equal in the part and in the context.
        let share = added.len() as f64 / new.pings.len().max(1) as f64;
        let known_share = self.first as f64 / before.pings.len().max(1) as f64;
        let moving = before.moving as f64 * known_share + new.moving as f64 * share;
        let records = [self.first + known, added.len() + new_soundings.len()];
        let [known_records, new_records] = records.map(|count| count as f64);
        let squares =
            known_records * before.rounding_m.powi(2) + new_records * new.rounding_m.powi(2);
        // Either no ping has an antenna place, or each ping has one.
        let antenna = new.antenna.get(self.first - self.context..);
        Navigation {
            antenna: (versions.antenna).next(
                &before.antenna,
                self.first,
                antenna.unwrap_or_default(),
            ),
            zero_heading: before.zero_heading - without_heading(again) + without_heading(added),
            moving: moving.round() as usize,
            pings: versions.pings.next(&before.pings, self.first, added),
            soundings: (versions.soundings).next(&before.soundings, known, new_soundings),
            swath: (versions.swath).next(&before.swath, known_swath, new_swath),
            projection: new.projection,
            rounding_m: (squares / (known_records + new_records).max(1.0)).sqrt(),
        }
    }

    /// Joins the earlier points before the part and the new points of the part, with their classes.
    fn join_points(
        &self,
        before: &Products,
        new: &BySource<CloudPoint>,
        classes: &[PointClass],
        exclusions: &Exclusions,
        versions: &mut [Versions<CloudPoint>; PointSource::ALL.len()],
    ) -> (BySource<CloudPoint>, Vec<PointClass>) {
        let mut joined = Vec::with_capacity(before.classes.len() + classes.len());
        let points = BySource::from_parts(|source| {
            let old = before.cloud.points.of(source);
            let known = old.partition_point(|point| !self.is_new(point.record()));
            let start = before.cloud.points.start(source);
            joined.extend_from_slice(&before.classes[start..start + known]);
            let of_source = new.of(source).iter().zip(&classes[new.start(source)..]);
            let added = of_source.filter_map(|(point, class)| {
                let point = self.counted_point(point, exclusions)?;
                joined.push(*class);
                Some(point)
            });
            let added: Vec<CloudPoint> = added.collect();
            versions[source as usize].next(old, known, &added)
        });
        (points, joined)
    }

    /// Converts a point of the stretch to a point of the log; `None` if it is before the part or
    /// excluded.
    fn counted_point(&self, point: &CloudPoint, exclusions: &Exclusions) -> Option<CloudPoint> {
        let StretchStart { sounding, swath } = self.context_start;
        let record = match point.record() {
            PointRecord::Sounding(index) => RecordIndex::new(index + sounding),
            PointRecord::Swath(index) => RecordIndex::new(index + swath),
            PointRecord::Ping(_) => None,
        };
        let point =
            CloudPoint { ping: (point.ping as usize + self.context) as u32, record, ..*point };
        let counts = self.is_new(point.record()) && point.record().exclusion(exclusions).is_none();
        counts.then_some(point)
    }

    /// Returns true if a record of the log is in the part.
    fn is_new(&self, record: PointRecord) -> bool {
        match record {
            PointRecord::Ping(index) => index >= self.first,
            PointRecord::Sounding(index) => index >= self.first_start.sounding,
            PointRecord::Swath(index) => index >= self.first_start.swath,
        }
    }
}
