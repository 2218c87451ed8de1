//! The cloud, ready to draw and to pick; made off the window's thread.

use crate::app::{CloudColour, Mark, ViewOptions};
use crate::bathymetry;
use crate::cloud::{CloudPoint, PointCloud, PointSource};
use crate::progress::Progress;
use crate::render::{CloudBuffers, PointVertex, depth_colour, depth_share};
use crate::survey::Side;
use crate::ui::theme;
use glam::Vec3;

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

    /// Share of the side-scan points that the filter removes, percent.
    pub fn removed_percent(&self) -> f64 {
        let side_scan = self.port + self.starboard + self.removed;
        100.0 * self.removed as f64 / side_scan.max(1) as f64
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

/// Points in drawing order with what belongs to them.
pub struct CloudScene {
    /// What the vertices are relative to, metres east, north and up.
    pub origin_m: [f64; 3],
    /// Kept points first, then those that the filter would remove.
    pub vertices: Vec<PointVertex>,
    /// Index into the cloud of each vertex.
    pub order: Vec<u32>,
    /// The vertices on the GPU.
    pub buffers: Option<CloudBuffers>,
    /// Corners of the box around the kept points.
    pub corners: [Vec3; 2],
    /// How many points there are.
    pub counts: Counts,
    /// Ends of the colour scale of depth, metres.
    pub range_m: Option<[f32; 2]>,
    /// Ping and vertex of every side-scan point, by ping.
    by_ping: Vec<(u32, u32)>,
}

impl CloudScene {
    /// `None` when there is no point, or cancelled.
    pub fn new(
        cloud: &PointCloud,
        kept: &[bool],
        options: &ViewOptions,
        device: Option<&wgpu::Device>,
        progress: &Progress,
    ) -> Option<Self> {
        let is_kept = |index: usize| kept.get(index).copied().unwrap_or(true);
        let (order, counts) = order(cloud, is_kept);
        let first = cloud.points.get(*order.first()? as usize)?;
        let origin_m = [first.east_m, first.north_m, 0.0];
        let shown = || order.iter().map(|&index| &cloud.points[index as usize]);
        let depths = shown().take(counts.kept()).map(|point| -point.z_m as f32);
        let range_m = bathymetry::depth_range(depths);
        let mut vertices = Vec::with_capacity(order.len());
        for (index, point) in shown().enumerate() {
            if index % CHECK == 0 {
                progress.check().ok()?;
            }
            let colour = match index < counts.kept() {
                true => colour(point, options, range_m),
                false => theme::outlier_colour(),
            };
            vertices.push(vertex(point, origin_m, colour));
        }
        let corners = corners(match counts.kept() {
            0 => &vertices,
            kept => &vertices[..kept],
        });
        Some(Self {
            origin_m,
            buffers: device.map(|device| CloudBuffers::new(device, &vertices)),
            by_ping: by_ping(cloud, &order),
            vertices,
            order,
            corners,
            counts,
            range_m,
        })
    }

    /// Vertices that are drawn.
    pub fn shown(&self, outlier_preview: bool) -> usize {
        match outlier_preview {
            true => self.vertices.len(),
            false => self.counts.kept(),
        }
    }

    /// A vertex's place.
    pub fn place(&self, vertex: usize) -> Option<Vec3> {
        self.vertices.get(vertex).map(|vertex| vertex.place.into())
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

    /// Side-scan vertices of a ping.
    pub fn of_ping(&self, ping: usize) -> impl Iterator<Item = usize> {
        let ping = ping.min(u32::MAX as usize) as u32;
        let start = self.by_ping.partition_point(|(other, _)| *other < ping);
        let same = self.by_ping[start..]
            .iter()
            .take_while(move |(other, _)| *other == ping);
        same.map(|(_, vertex)| *vertex as usize)
    }

    /// The mark of a vertex.
    pub fn mark(&self, cloud: &PointCloud, vertex: usize) -> Option<Mark> {
        let index = *self.order.get(vertex)? as usize;
        let point = cloud.points.get(index)?;
        Some(Mark {
            ping: point.ping as usize,
            side: side(point.source),
            sample: point.sample.is_finite().then_some(point.sample),
            point: Some(index),
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

fn order(cloud: &PointCloud, is_kept: impl Fn(usize) -> bool) -> (Vec<u32>, Counts) {
    let mut counts = Counts::default();
    let (mut order, mut removed) = (Vec::new(), Vec::new());
    for (index, point) in cloud.points.iter().enumerate() {
        let place = [point.east_m, point.north_m, point.z_m];
        if !place.iter().all(|metres| metres.is_finite()) {
            continue;
        }
        let kept = is_kept(index);
        counts.add(point.source, kept);
        match kept {
            true => order.push(index as u32),
            false => removed.push(index as u32),
        }
    }
    order.append(&mut removed);
    (order, counts)
}

fn vertex(point: &CloudPoint, origin_m: [f64; 3], colour: egui::Color32) -> PointVertex {
    let [east, north, up] = origin_m;
    PointVertex {
        place: [
            (point.east_m - east) as f32,
            (point.north_m - north) as f32,
            (point.z_m - up) as f32,
        ],
        colour: colour.to_array(),
    }
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

fn corners(vertices: &[PointVertex]) -> [Vec3; 2] {
    let start = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    vertices.iter().fold(start, |[low, high], vertex| {
        let place = Vec3::from(vertex.place);
        [low.min(place), high.max(place)]
    })
}

fn by_ping(cloud: &PointCloud, order: &[u32]) -> Vec<(u32, u32)> {
    let points = order.iter().map(|&index| &cloud.points[index as usize]);
    let mut pings: Vec<(u32, u32)> = points
        .enumerate()
        .filter(|(_, point)| point.source != PointSource::DownScan)
        .map(|(vertex, point)| (point.ping, vertex as u32))
        .collect();
    pings.sort_unstable();
    pings
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
        let scene = CloudScene::new(&cloud, &kept, &options, None, &Progress::new()).unwrap();
        assert_eq!(scene.order, [0, 3, 1]);
        assert_eq!((scene.shown(false), scene.shown(true)), (2, 3));
        assert_eq!(scene.counts.removed_percent(), 50.0);
        assert_eq!(scene.of_ping(4).collect::<Vec<_>>(), [1, 2]);
        let mark = scene.mark(&cloud, 1).unwrap();
        assert_eq!(
            (mark.ping, mark.side, mark.point),
            (4, Some(Side::Starboard), Some(3))
        );
        assert_eq!(scene.corners[0].z, -3.0);
    }
}
