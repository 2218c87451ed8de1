//! The cloud, ready to draw and to pick; made off the window's thread.

use crate::app::{CloudColour, Mark, ViewOptions};
use crate::bathymetry;
use crate::cloud::{CloudPoint, Outliers, PointCloud, PointSource};
use crate::presentation::colours::{depth_colour, depth_share};
use crate::progress::Progress;
use crate::render::{CloudBuffers, PointVertex, Uploader};
use crate::survey::Side;
use crate::ui::theme;
use glam::Vec3;
use std::sync::Arc;

/// Points between two looks at whether the work was cancelled.
const CHECK: usize = 1 << 16;

/// How many points there are of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Kept, under the boat.
    pub down_scan: usize,
    /// Kept, port.
    pub port: usize,
    /// Kept, starboard.
    pub starboard: usize,
    /// Side-scan points that the outlier filter would remove.
    pub removed: usize,
    /// Soundings at which the recorder had lost the bottom; drawn with the removed ones.
    pub lost: usize,
}

impl Counts {
    /// Kept points.
    pub fn kept(&self) -> usize {
        self.down_scan + self.port + self.starboard
    }

    /// All points.
    pub fn all(&self) -> usize {
        self.kept() + self.removed + self.lost
    }

    fn add(&mut self, source: PointSource, kept: bool) {
        let count = match (kept, source) {
            (false, PointSource::DownScan) => &mut self.lost,
            (false, _) => &mut self.removed,
            (true, PointSource::DownScan) => &mut self.down_scan,
            (true, PointSource::Port) => &mut self.port,
            (true, PointSource::Starboard) => &mut self.starboard,
        };
        *count += 1;
    }
}

/// A cloud on the GPU with what belongs to it. The places of points are worked out from the cloud when they are asked for:
/// a second copy of them all would be the largest thing in memory.
pub struct CloudScene {
    cloud: Arc<PointCloud>,
    kept: Arc<Vec<bool>>,
    /// What the vertices are relative to, metres east, north and up.
    pub origin_m: [f64; 3],
    /// The points on the GPU: kept ones first, then those that the filter would remove.
    pub buffers: Option<CloudBuffers>,
    /// Corners of the box around the kept points.
    pub corners: [Vec3; 2],
    /// How many points there are.
    pub counts: Counts,
    /// What the outlier filter removes.
    pub outliers: Outliers,
    /// Ends of the colour scale of depth, metres.
    pub range_m: Option<[f32; 2]>,
}

impl CloudScene {
    /// `None` when there is no point, or cancelled. Points below `min_confidence` are no outliers ([`PointCloud::outliers`]).
    pub fn new(
        cloud: Arc<PointCloud>,
        kept: Arc<Vec<bool>>,
        min_confidence: f32,
        options: &ViewOptions,
        uploader: Option<&Uploader>,
        progress: &Progress,
    ) -> Option<Self> {
        let counts = counts(&cloud, &kept);
        let in_box = counts.kept() > 0;
        let first = points(&cloud, &kept, in_box).next()?.1;
        let depths = points(&cloud, &kept, true).map(|(_, point)| -point.z_m as f32);
        let range_m = bathymetry::depth_range(depths);
        let mut scene = Self {
            origin_m: [first.east_m, first.north_m, 0.0],
            buffers: None,
            corners: [Vec3::ZERO; 2],
            counts,
            outliers: cloud.outliers(&kept, min_confidence),
            range_m,
            cloud,
            kept,
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

    /// How many points are drawn.
    pub fn shown(&self, outlier_preview: bool) -> usize {
        match outlier_preview {
            true => self.counts.all(),
            false => self.counts.kept(),
        }
    }

    /// Index and place of every point that is drawn.
    pub fn places(&self, outlier_preview: bool) -> impl Iterator<Item = (usize, Vec3)> {
        let kept = points(&self.cloud, &self.kept, true);
        let removed = outlier_preview.then(|| points(&self.cloud, &self.kept, false));
        kept.chain(removed.into_iter().flatten())
            .map(|(index, point)| (index, self.place(point)))
    }

    /// A point's place in the scene.
    pub fn place(&self, point: &CloudPoint) -> Vec3 {
        self.local(point.east_m, point.north_m, point.z_m)
    }

    /// Place of a point by its index in the cloud.
    pub fn place_of(&self, index: usize) -> Option<Vec3> {
        self.cloud.points.get(index).map(|point| self.place(point))
    }

    /// A place of the survey in the scene.
    pub fn local(&self, east_m: f64, north_m: f64, z_m: f64) -> Vec3 {
        let [east, north, up] = self.origin_m;
        Vec3::new(
            (east_m - east) as f32,
            (north_m - north) as f32,
            (z_m - up) as f32,
        )
    }

    /// Places of the side-scan points of a ping.
    pub fn of_ping(&self, ping: usize) -> impl Iterator<Item = Vec3> {
        let points = self.cloud.of_ping(ping);
        points
            .filter(|point| is_placed(point))
            .map(|point| self.place(point))
    }

    /// The mark of a point.
    pub fn mark(&self, index: usize) -> Option<Mark> {
        let point = self.cloud.points.get(index)?;
        Some(Mark {
            ping: point.ping as usize,
            side: side(point.source),
            sample: point.sample.is_finite().then_some(point.sample),
            point: Some(index),
        })
    }

    /// The box around the kept points, or around the others.
    fn corners(&self, kept: bool) -> [Vec3; 2] {
        let start = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let points = points(&self.cloud, &self.kept, kept);
        points.fold(start, |[low, high], (_, point)| {
            let place = self.place(point);
            [low.min(place), high.max(place)]
        })
    }

    /// All points in the order of drawing; ends early when cancelled.
    fn vertices(
        &self,
        options: &ViewOptions,
        progress: &Progress,
    ) -> impl Iterator<Item = PointVertex> {
        let goes_on = |count: usize| !count.is_multiple_of(CHECK) || progress.check().is_ok();
        let kept = points(&self.cloud, &self.kept, true)
            .map(|(_, point)| (point, colour(point, options, self.range_m)));
        let removed = points(&self.cloud, &self.kept, false)
            .map(|(_, point)| (point, theme::outlier_colour()));
        let all = kept.chain(removed).enumerate();
        all.map_while(move |(count, (point, colour))| {
            goes_on(count).then(|| PointVertex {
                place: self.place(point).into(),
                colour: colour.to_array(),
            })
        })
    }
}

/// The side that a point lies on.
pub fn side(source: PointSource) -> Option<Side> {
    match source {
        PointSource::DownScan => None,
        PointSource::Port => Some(Side::Port),
        PointSource::Starboard => Some(Side::Starboard),
    }
}

/// Points that have a place and are kept, or are not, with their index.
fn points<'a>(
    cloud: &'a PointCloud,
    kept: &'a [bool],
    wanted: bool,
) -> impl Iterator<Item = (usize, &'a CloudPoint)> {
    let all = cloud.points.iter().enumerate();
    all.filter(move |(index, point)| {
        kept.get(*index).copied().unwrap_or(true) == wanted && is_placed(point)
    })
}

fn is_placed(point: &CloudPoint) -> bool {
    let place = [point.east_m, point.north_m, point.z_m];
    place.iter().all(|metres| metres.is_finite())
}

fn counts(cloud: &PointCloud, kept: &[bool]) -> Counts {
    let mut counts = Counts::default();
    for wanted in [true, false] {
        points(cloud, kept, wanted).for_each(|(_, point)| counts.add(point.source, wanted));
    }
    counts
}

fn colour(point: &CloudPoint, options: &ViewOptions, range_m: Option<[f32; 2]>) -> egui::Color32 {
    match options.cloud.colour {
        CloudColour::Source => match side(point.source) {
            None => theme::down_scan_colour(options),
            Some(side) => theme::side_colour(options, side),
        },
        CloudColour::Depth => {
            let share = range_m.map_or(f32::NAN, |range_m| depth_share(-point.z_m as f32, range_m));
            let [r, g, b] = depth_colour(share);
            egui::Color32::from_rgb(r, g, b)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(source: PointSource, ping: u32, z_m: f64) -> CloudPoint {
        CloudPoint {
            source,
            ping,
            sounding: None,
            sound: true,
            canopy: false,
            above_bottom_m: 0.0,
            confidence: 1.0,
            sample: 100.0,
            east_m: f64::from(ping),
            north_m: 2.0,
            z_m,
        }
    }

    #[test]
    fn kept_points_come_first_and_know_where_they_came_from() {
        let cloud = PointCloud {
            points: vec![
                point(PointSource::DownScan, 0, -2.0),
                point(PointSource::Port, 4, -9.0),
                point(PointSource::Port, 5, f64::NAN),
                point(PointSource::Starboard, 4, -3.0),
            ],
            zero_heading: 0,
        };
        let kept = [true, false, true, true];
        let options = ViewOptions::default();
        let progress = Progress::new();
        let kept = Arc::new(kept.to_vec());
        let scene = CloudScene::new(Arc::new(cloud), kept, 0.0, &options, None, &progress).unwrap();
        let order = |preview| scene.places(preview).map(|(index, _)| index);
        assert_eq!(order(true).collect::<Vec<_>>(), [0, 3, 1]);
        assert_eq!(order(false).collect::<Vec<_>>(), [0, 3]);
        assert_eq!((scene.shown(false), scene.shown(true)), (2, 3));
        let removed = Outliers {
            removed: 1,
            side_scan: 3,
        };
        assert_eq!(scene.outliers, removed, "as the panel and the report count");
        let depths: Vec<f32> = scene.of_ping(4).map(|place| place.z).collect();
        assert_eq!(depths, [-9.0, -3.0]);
        assert_eq!(scene.of_ping(5).count(), 0);
        let drawn: Vec<f32> = scene
            .vertices(&options, &progress)
            .map(|vertex| vertex.place[2])
            .collect();
        assert_eq!(drawn, [-2.0, -3.0, -9.0]);
        let mark = scene.mark(3).unwrap();
        assert_eq!(
            (mark.ping, mark.side, mark.point),
            (4, Some(Side::Starboard), Some(3))
        );
        assert_eq!(scene.corners[0].z, -3.0);
    }
}
