//! Prepares the cloud for drawing and picking; computed in a background thread.

use crate::app::{CloudColour, LogId, LogPlace, SwathShown, ViewOptions, VisibleLog};
use crate::ui::render::{CloudBuffers, PointVertex, ScenePart, Uploader};
use crate::ui::theme;
use bathyscope_bottom::calibration::Calibration;
use bathyscope_bottom::cloud::{
    ClassCounts, CloudPoint, Correction, PointClass, PointCloud, PointScales, PointSource,
    Reduction,
};
use bathyscope_bottom::presentation::colours::{depth_colour, depth_share, value_colour};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, Survey};
use glam::Vec3;
use std::sync::Arc;

/// Number of points between two checks for cancellation.
const CHECK: usize = 1 << 16;

/// Number of points of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PointCounts {
    /// Kept points under the boat.
    pub down_scan: usize,
    /// Kept points of port.
    pub port: usize,
    /// Kept points of starboard.
    pub starboard: usize,
    /// Kept points of a swath.
    pub swath: usize,
    /// Points that do not count for the map.
    pub set_aside: usize,
}

impl PointCounts {
    /// Returns the number of kept points.
    pub(super) fn kept(&self) -> usize {
        self.down_scan + self.port + self.starboard + self.swath
    }

    /// Returns the number of all points.
    pub(super) fn all(&self) -> usize {
        self.kept() + self.set_aside
    }

    fn add(&mut self, source: PointSource, kept: bool) {
        let count = match (kept, source) {
            (false, _) => &mut self.set_aside,
            (true, PointSource::DownScan) => &mut self.down_scan,
            (true, PointSource::Port) => &mut self.port,
            (true, PointSource::Starboard) => &mut self.starboard,
            (true, PointSource::Swath) => &mut self.swath,
        };
        *count += 1;
    }
}

/// Source of the slant range of a point.
#[derive(Clone)]
pub(super) struct Ranging {
    survey: Arc<Survey>,
    calibration: Arc<Calibration>,
    correction: Arc<Correction>,
}

/// The points of one log.
#[derive(Clone)]
pub(super) struct SceneLogPoints {
    /// The log.
    pub id: LogId,
    /// Name of the log.
    pub name: String,
    /// All points of the log.
    pub cloud: Arc<PointCloud>,
    /// The class of each point.
    pub classes: Arc<Vec<PointClass>>,
    /// Source of the slant ranges of the points; `None` if no slant range is known.
    pub ranging: Option<Ranging>,
    /// Colour of the log where colours distinguish logs.
    pub colour: [u8; 3],
    /// Setting that shows or hides the log's swath points.
    pub swath: SwathShown,
}

impl SceneLogPoints {
    /// Creates the points of a log with its results.
    pub(super) fn of(shown: &VisibleLog, swath: SwathShown) -> Self {
        let products = &shown.log.products;
        Self {
            id: shown.id,
            name: shown.name.clone(),
            cloud: products.cloud.clone(),
            classes: products.classes.clone(),
            ranging: Some(Ranging {
                survey: shown.log.survey.clone(),
                calibration: products.calibration.clone(),
                correction: products.correction.clone(),
            }),
            colour: shown.colour,
            swath,
        }
    }

    /// Returns the slant range of a point, metres; NaN where it is not known.
    fn range_m(&self, point: &CloudPoint) -> f64 {
        self.ranging.as_ref().map_or(f64::NAN, |ranging| {
            let reduction = Reduction::new(&ranging.calibration, &ranging.correction);
            reduction.point_range_m(&ranging.survey, point)
        })
    }

    /// Returns the points that have a place and are kept (`requested` true) or not kept, with their
    /// index.
    fn points(&self, requested: bool) -> impl Iterator<Item = (usize, &CloudPoint)> {
        let all = self.cloud.points.iter().enumerate();
        all.filter(move |(index, point)| {
            let is_kept = self.classes.get(*index).is_none_or(|class| class.is_kept());
            let is_hidden = point.source == PointSource::Swath && !self.swath.0;
            is_kept == requested && is_placed(point) && !is_hidden
        })
    }
}

/// Two are equal if they share the same results in memory; contents are not compared.
impl PartialEq for SceneLogPoints {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
            && Arc::ptr_eq(&self.cloud, &other.cloud)
            && Arc::ptr_eq(&self.classes, &other.classes)
            && self.colour == other.colour
            && self.swath == other.swath
    }
}

/// Selection of the points that are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ShownPoints {
    /// True if points that do not count for the map are drawn as well.
    pub outliers: bool,
    /// The part in which points are drawn, in coordinates of the scene.
    pub part: ScenePart,
}

/// The clouds of all logs on the GPU, with their counts and colour scales. The coordinates of
/// points are computed from the clouds when needed: a second copy of all of them would be the
/// largest item in memory.
pub(super) struct CloudScene {
    logs: Vec<SceneLogPoints>,
    /// Number of the first point of each log: the points of all logs are numbered in sequence.
    starts: Vec<usize>,
    /// Origin of the vertices, metres east, north and up.
    pub origin_m: [f64; 3],
    /// The points on the GPU: kept ones first, then the others; `None` without a GPU.
    pub buffers: Option<CloudBuffers>,
    /// Corners of the box around the kept points.
    pub corners: [Vec3; 2],
    /// Number of points of each kind.
    pub counts: PointCounts,
    /// Number of kept points of each log.
    kept: Vec<usize>,
    /// Number of points of each class.
    pub classes: ClassCounts,
    /// Ends of the colour scales.
    pub ends: ColourEnds,
}

/// The box of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SceneBox {
    /// Origin of the corners, metres east, north and up.
    pub origin_m: [f64; 3],
    /// Lower south-western and upper north-eastern corner of the box.
    pub corners: [Vec3; 2],
}

impl SceneBox {
    /// Returns a box of the same height that is horizontally extended to include another box about
    /// the same origin.
    #[must_use]
    pub(super) fn as_wide_as(self, [low, high]: [Vec3; 2]) -> Self {
        let [from, to] = self.corners;
        let corners = [low.min(from).with_z(from.z), high.max(to).with_z(to.z)];
        Self { corners, ..self }
    }
}

/// Ends of the colour scales of points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ColourEnds {
    /// Ends for depth, metres; `None` if there is no depth.
    pub depth_m: Option<[f32; 2]>,
    /// Ends for other properties of the points.
    pub scales: PointScales,
}

impl CloudScene {
    /// Creates the scene with colour scales between these ends; `None` when there is no point, or
    /// when cancelled.
    pub(super) fn new(
        logs: Vec<SceneLogPoints>,
        ends: ColourEnds,
        options: &ViewOptions,
        uploader: Option<&Uploader>,
        progress: &Progress,
    ) -> Option<Self> {
        let counts = counts(&logs);
        let in_box = counts.kept() > 0;
        let first = logs.iter().find_map(|log| log.points(in_box).next())?.1;
        let starts = logs.iter().scan(0, |sum, log| {
            let start = *sum;
            *sum += log.cloud.points.len();
            Some(start)
        });
        let mut classes = ClassCounts::default();
        for log in &logs {
            classes.add(&ClassCounts::of(&log.cloud, &log.classes));
        }
        let mut scene = Self {
            origin_m: [first.east_m, first.north_m, 0.0],
            buffers: None,
            corners: [Vec3::ZERO; 2],
            counts,
            kept: logs.iter().map(|log| log.points(true).count()).collect(),
            classes,
            ends,
            starts: starts.collect(),
            logs,
        };
        progress.check().ok()?;
        scene.corners = scene.corners(in_box);
        scene.buffers = uploader.map(|uploader| {
            let vertices = scene.vertices(options, progress);
            CloudBuffers::new(uploader, counts.all(), vertices)
        });
        progress.check().ok()?;
        Some(scene)
    }

    /// Returns name, colour and number of kept points of every log.
    pub(super) fn by_log(&self) -> impl Iterator<Item = (&str, [u8; 3], usize)> {
        let logs = self.logs.iter().zip(&self.kept);
        logs.map(|(log, kept)| (log.name.as_str(), log.colour, *kept))
    }

    /// Returns the number of points that are drawn.
    pub(super) fn shown(&self, outlier_preview: bool) -> usize {
        if outlier_preview { self.counts.all() } else { self.counts.kept() }
    }

    /// Returns number and place of every point that is drawn.
    pub(super) fn places(&self, shown: ShownPoints) -> impl Iterator<Item = (usize, Vec3)> {
        let removed = shown.outliers.then(|| self.points(false));
        let all = self.points(true).chain(removed.into_iter().flatten());
        all.map(|(number, _, point)| (number, self.place(point)))
            .filter(move |(_, place)| shown.part.holds(*place))
    }

    /// Returns the points of all logs that are kept (`requested` true) or not kept, each with its
    /// number and its log.
    fn points(
        &self,
        requested: bool,
    ) -> impl Iterator<Item = (usize, &SceneLogPoints, &CloudPoint)> {
        let logs = self.logs.iter().zip(&self.starts);
        logs.flat_map(move |(log, start)| {
            let points = log.points(requested);
            points.map(move |(index, point)| (start + index, log, point))
        })
    }

    /// Returns the log of the point with this number, and the index of the point in the log.
    fn of_number(&self, number: usize) -> Option<(&SceneLogPoints, usize)> {
        let after = self.starts.partition_point(|start| *start <= number);
        let log = after.checked_sub(1)?;
        Some((self.logs.get(log)?, number - self.starts[log]))
    }

    /// Returns the coordinates of a point in the scene.
    pub(super) fn place(&self, point: &CloudPoint) -> Vec3 {
        self.local(point.east_m, point.north_m, point.z_m)
    }

    /// Returns the coordinates of the point with this number in the scene.
    pub(super) fn place_of(&self, number: usize) -> Option<Vec3> {
        let (log, index) = self.of_number(number)?;
        log.cloud.points.get(index).map(|point| self.place(point))
    }

    /// Returns the coordinates of a place of the survey in the scene.
    pub(super) fn local(&self, east_m: f64, north_m: f64, z_m: f64) -> Vec3 {
        let [east, north, up] = self.origin_m;
        Vec3::from([east_m - east, north_m - north, z_m - up].map(|metres| metres as f32))
    }

    /// Returns the coordinates in the scene of the side-scan points of a log's ping.
    pub(super) fn of_ping(&self, log: LogId, ping: usize) -> impl Iterator<Item = Vec3> {
        let log = self.logs.iter().find(move |shown| shown.id == log);
        let points = log.into_iter().flat_map(move |log| log.cloud.of_ping(ping));
        points.filter(|point| is_placed(point)).map(|point| self.place(point))
    }

    /// Returns the log and the mark of the point with this number.
    pub(super) fn mark(&self, number: usize) -> Option<(LogId, LogPlace)> {
        let (log, index) = self.of_number(number)?;
        let point = log.cloud.points.get(index)?;
        let mark = LogPlace {
            ping: point.ping as usize,
            side: side(point.source),
            sample: point.source.is_side_scan().then_some(point.sample),
            point: Some(index),
        };
        Some((log.id, mark))
    }

    fn colour(
        &self,
        log: &SceneLogPoints,
        point: &CloudPoint,
        options: &ViewOptions,
    ) -> egui::Color32 {
        let [r, g, b] = match options.cloud.colour {
            CloudColour::Source => {
                return source_colour(point.source, options);
            }
            CloudColour::Depth => {
                let depth_m = -point.z_m as f32;
                let share = |range_m| depth_share(depth_m, range_m);
                depth_colour(self.ends.depth_m.map_or(f32::NAN, share))
            }
            // Soundings and swath points have no known level.
            CloudColour::Level if !point.source.is_side_scan() => {
                return source_colour(point.source, options);
            }
            CloudColour::Level => value_colour(f32::from(point.level), self.ends.scales.level),
            CloudColour::Range => value_colour(log.range_m(point) as f32, self.ends.scales.range_m),
            CloudColour::Log => log.colour,
        };
        egui::Color32::from_rgb(r, g, b)
    }

    /// Returns the box around the kept points.
    pub(super) fn extent(&self) -> SceneBox {
        SceneBox { origin_m: self.origin_m, corners: self.corners }
    }

    /// Returns the corners of the box around the kept points, or around the others.
    fn corners(&self, kept: bool) -> [Vec3; 2] {
        let start = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        self.points(kept).fold(start, |[low, high], (_, _, point)| {
            let place = self.place(point);
            [low.min(place), high.max(place)]
        })
    }

    /// Returns all points in the order of drawing; ends early when cancelled.
    fn vertices(
        &self,
        options: &ViewOptions,
        progress: &Progress,
    ) -> impl Iterator<Item = PointVertex> {
        let goes_on = |count: usize| !count.is_multiple_of(CHECK) || progress.check().is_ok();
        let kept = self.points(true);
        let kept = kept.map(|(_, log, point)| (point, self.colour(log, point, options)));
        let removed = self.points(false);
        let removed = removed.map(|(_, _, point)| (point, theme::OUTLIER_COLOUR));
        let all = kept.chain(removed).enumerate();
        all.map_while(move |(count, (point, colour))| {
            goes_on(count)
                .then(|| PointVertex { place: self.place(point).into(), colour: colour.to_array() })
        })
    }
}

fn source_colour(source: PointSource, options: &ViewOptions) -> egui::Color32 {
    match side(source) {
        Some(side) => theme::side_colour(options, side),
        None if source == PointSource::Swath => theme::SWATH_COLOUR,
        None => theme::down_scan_colour(options),
    }
}

/// Returns the side of the side-scan that measured a point; `None` if no side did.
pub(super) fn side(source: PointSource) -> Option<Side> {
    match source {
        PointSource::DownScan | PointSource::Swath => None,
        PointSource::Port => Some(Side::Port),
        PointSource::Starboard => Some(Side::Starboard),
    }
}

fn is_placed(point: &CloudPoint) -> bool {
    let place = [point.east_m, point.north_m, point.z_m];
    place.iter().all(|metres| metres.is_finite())
}

fn counts(logs: &[SceneLogPoints]) -> PointCounts {
    let mut counts = PointCounts::default();
    for requested in [true, false] {
        let points = logs.iter().flat_map(|log| log.points(requested));
        points.for_each(|(_, point)| counts.add(point.source, requested));
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_bottom::cloud::BySource;

    fn point(source: PointSource, ping: u32, z_m: f64) -> CloudPoint {
        CloudPoint {
            level: 200,
            confidence: 1.0,
            sample: 100.0,
            ..CloudPoint::new(source, ping, [f64::from(ping), 2.0, z_m])
        }
    }

    fn with_outliers(outliers: bool) -> ShownPoints {
        ShownPoints { outliers, part: ScenePart::WHOLE }
    }

    fn log(
        id: u64,
        points: &[CloudPoint],
        classes: &[PointClass],
        colour: [u8; 3],
    ) -> SceneLogPoints {
        SceneLogPoints {
            id: LogId(id),
            name: String::new(),
            cloud: Arc::new(PointCloud {
                points: BySource::from_iter(points.iter().copied()),
                zero_heading: 0,
            }),
            classes: Arc::new(classes.to_vec()),
            ranging: None,
            colour,
            swath: SwathShown::default(),
        }
    }

    /// Returns a log of four points: one is noise, and one has no depth.
    fn first_log() -> SceneLogPoints {
        use PointClass::{Bottom, LowNoise};
        let points = [
            point(PointSource::DownScan, 0, -2.0),
            point(PointSource::Port, 4, -9.0),
            point(PointSource::Port, 5, f64::NAN),
            point(PointSource::Starboard, 4, -3.0),
        ];
        log(4, &points, &[Bottom, LowNoise, Bottom, Bottom], [1, 2, 3])
    }

    fn second_log() -> SceneLogPoints {
        let points = [point(PointSource::Port, 4, -1.0)];
        log(2, &points, &[PointClass::Bottom], [7, 8, 9])
    }

    const LEVELS: Option<[f32; 2]> = Some([0.0, 255.0]);

    fn both_logs() -> CloudScene {
        let ends = ColourEnds {
            depth_m: Some([1.0, 9.0]),
            scales: PointScales { level: LEVELS, range_m: None },
        };
        let logs = vec![first_log(), second_log()];
        CloudScene::new(logs, ends, &ViewOptions::default(), None, &Progress::new()).unwrap()
    }

    fn only_first_log() -> CloudScene {
        let (options, ends) = (ViewOptions::default(), ColourEnds::default());
        CloudScene::new(vec![first_log()], ends, &options, None, &Progress::new()).unwrap()
    }

    /// Returns the colours of all points of both logs, in the order in which they are drawn.
    fn colours_by(colour: CloudColour) -> Vec<[u8; 3]> {
        let mut options = ViewOptions::default();
        options.cloud.colour = colour;
        let (both, progress) = (both_logs(), Progress::new());
        let vertices = both.vertices(&options, &progress);
        vertices.map(|vertex| [vertex.colour[0], vertex.colour[1], vertex.colour[2]]).collect()
    }

    #[test]
    fn kept_points_come_first_and_know_where_they_came_from() {
        let both = both_logs();
        let numbers = both.places(with_outliers(true)).map(|(number, _)| number);
        assert_eq!(numbers.collect::<Vec<_>>(), [0, 3, 4, 1], "kept ones of all logs first");
        let (log, mark) = both.mark(4).unwrap();
        assert_eq!((log, mark.point), (LogId(2), Some(0)), "a point knows its log");
        assert_eq!(both.of_ping(LogId(2), 4).count(), 1);
    }

    #[test]
    fn points_have_the_colour_of_their_log_or_level() {
        let by_log = colours_by(CloudColour::Log).into_iter();
        assert_eq!(by_log.map(|[red, ..]| red).collect::<Vec<_>>()[..3], [1, 1, 7]);
        let by_level = colours_by(CloudColour::Level);
        let sounding = theme::down_scan_colour(&ViewOptions::default()).to_array();
        assert_eq!(by_level[0], sounding[..3], "a sounding has no level");
        assert_eq!(by_level[1], value_colour(200.0, LEVELS));
    }

    #[test]
    fn noise_and_points_without_a_place_are_counted_and_not_shown() {
        let scene = only_first_log();
        let order = |preview| scene.places(with_outliers(preview)).map(|(index, _)| index);
        assert_eq!(order(true).collect::<Vec<_>>(), [0, 3, 1]);
        assert_eq!(order(false).collect::<Vec<_>>(), [0, 3]);
        assert_eq!((scene.shown(false), scene.shown(true)), (2, 3));
        let counts = (scene.classes.noise(), scene.classes.side_scan);
        assert_eq!(counts, (1, 3), "as the panel and the report count");
    }

    #[test]
    fn a_scene_gives_the_places_of_a_ping_and_the_mark_of_a_point() {
        let scene = only_first_log();
        let depths: Vec<f32> = scene.of_ping(LogId(4), 4).map(|place| place.z).collect();
        assert_eq!(depths, [-9.0, -3.0]);
        assert_eq!(scene.of_ping(LogId(4), 5).count(), 0);
        let drawn: Vec<f32> = scene
            .vertices(&ViewOptions::default(), &Progress::new())
            .map(|vertex| vertex.place[2])
            .collect();
        assert_eq!(drawn, [-2.0, -3.0, -9.0]);
        let (_, mark) = scene.mark(3).unwrap();
        assert_eq!((mark.ping, mark.side, mark.point), (4, Some(Side::Starboard), Some(3)));
        assert_eq!(scene.corners[0].z, -3.0);
    }
}
