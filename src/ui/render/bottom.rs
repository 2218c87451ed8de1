//! Draws the bottom into a [`RenderTarget`]'s pass, as tiles of a grid, each with squares as fine
//! as the screen can show.

use super::camera::corners;
use super::pipeline::{OffscreenPipeline, PipelineParts, RenderTarget, ScenePart, Uniform};
use super::{CameraProjection, Uploader};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec2, Vec3, Vec4};
use std::ops::Range;

/// Squares along a side of a tile. A side has one corner more than squares, and adjacent tiles
/// share the corners of their common side.
pub const BOTTOM_TILE: usize = 64;
/// Corners along a side of a tile.
const SIDE: usize = BOTTOM_TILE + 1;
/// Vertices of a tile: its corners, and those of the skirts along its four sides.
const VERTICES: usize = SIDE * SIDE + 4 * SIDE;
/// Levels of detail of a tile: it is drawn with squares of 1, 2, 4 ... of the finest ones along a
/// side.
const LEVELS: usize = BOTTOM_TILE.ilog2() as usize + 1;
/// Largest side of a drawn square, pixels, unless the finest squares are larger.
const SQUARE_PX: f32 = 3.0;
/// Tiles in one buffer: some 7 MB, which are in memory during the upload.
const TILES_A_BUFFER: usize = 64;
/// Height of the skirts that hang below a tile, as a share of the tile's relief: they hide the gaps
/// to a coarser neighbour.
const SKIRT: f32 = 0.1;

/// A corner, as the shader reads it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BottomVertex {
    /// Metres from the scene's origin: east, north, up.
    pub place: [f32; 3],
    /// East and north components of the unit vector perpendicular to the bottom, times 32767.
    pub faces: [i16; 2],
    /// sRGB; alpha 255 where something is drawn ([`BottomPart`]), else 0.
    pub colour: [u8; 4],
    /// sRGB for squares that are four of the finest ones long, or more: the mean of the ground
    /// around; alpha 255 where the corner is lit, else 0.
    pub far_colour: [u8; 4],
}

/// Rendering of a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BottomPart {
    /// The corner and its squares are not drawn.
    None,
    /// The corner has its colour alone, without light and isobaths.
    Plain,
    /// The corner has its colour in the light, with isobaths.
    Lit,
}

impl BottomVertex {
    /// Creates a corner at a place, with `normal` (of length 1) perpendicular to the bottom.
    pub fn new(place: Vec3, normal: [f32; 3], rgb: [u8; 3], part: BottomPart) -> Self {
        let whole = |part: f32| (part.clamp(-1.0, 1.0) * f32::from(i16::MAX)).round() as i16;
        let [r, g, b] = rgb;
        let alpha = |is_so: bool| if is_so { 255 } else { 0 };
        Self {
            place: place.into(),
            faces: [whole(normal[0]), whole(normal[1])],
            colour: [r, g, b, alpha(part != BottomPart::None)],
            far_colour: [r, g, b, alpha(part != BottomPart::Plain)],
        }
    }

    /// Returns the corner with another colour for the view from far away.
    #[must_use]
    pub fn with_far_colour(self, [r, g, b]: [u8; 3]) -> Self {
        let [.., lit] = self.far_colour;
        Self { far_colour: [r, g, b, lit], ..self }
    }

    fn is_drawn(&self) -> bool {
        self.colour[3] == 255
    }
}

/// The box around the drawn corners of a tile.
type Extent = [Vec3; 2];

/// Returns the box around the drawn corners of a tile; `None` where nothing is drawn.
fn extent(tile: &[BottomVertex]) -> Option<Extent> {
    let mut drawn = tile.iter().filter(|vertex| vertex.is_drawn());
    let first = Vec3::from(drawn.next()?.place);
    Some(drawn.fold([first; 2], |[low, high], vertex| {
        let place = Vec3::from(vertex.place);
        [low.min(place), high.max(place)]
    }))
}

/// Returns the corners of a tile with those of its skirts, which are the corners of each side
/// again, lower.
fn with_skirts(tile: Vec<BottomVertex>, extent: Extent) -> impl Iterator<Item = BottomVertex> {
    let [low, high] = extent;
    let drop_m = SKIRT * (high.z - low.z);
    let skirts: Vec<BottomVertex> = (0..4 * SIDE)
        .filter_map(|index| tile.get(on_side(index / SIDE, index % SIDE)))
        .map(|corner| {
            let [east, north, up] = corner.place;
            BottomVertex { place: [east, north, up - drop_m], ..*corner }
        })
        .collect();
    tile.into_iter().chain(skirts)
}

/// Returns the index of the corner at the number `along` of a side of a tile.
fn on_side(side: usize, along: usize) -> usize {
    match side {
        0 => along,
        1 => (SIDE - 1) * SIDE + along,
        2 => along * SIDE,
        _ => along * SIDE + SIDE - 1,
    }
}

/// Returns the triangles of a tile as indices of corners, with squares that are `stride` of the
/// finest ones long.
fn triangles(stride: usize) -> Vec<u16> {
    let mut numbers = Vec::new();
    let mut square = |[a, b, c, d]: [usize; 4]| {
        numbers.extend([a, c, b, b, c, d].map(|corner| corner as u16));
    };
    let steps = || (0..BOTTOM_TILE).step_by(stride);
    for row in steps() {
        for column in steps() {
            let north = row * SIDE + column;
            let south = north + stride * SIDE;
            square([north, north + stride, south, south + stride]);
        }
    }
    for side in 0..4 {
        let hanging = SIDE * SIDE + side * SIDE;
        for along in steps() {
            let [from, to] = [along, along + stride].map(|along| on_side(side, along));
            square([from, to, hanging + along, hanging + along + stride]);
        }
    }
    numbers
}

/// Returns the coarsest level whose squares are no longer than [`SQUARE_PX`], with finest squares
/// of `finest_px` pixels; level 0 if the finest are already longer.
fn level(finest_px: f32) -> usize {
    let times = SQUARE_PX / finest_px.max(1e-9);
    (times.log2().floor().max(0.0) as usize).min(LEVELS - 1)
}

/// A bottom on the GPU.
pub struct BottomBuffers {
    /// Buffers of the tiles with something to draw: most of the grid around a river, or around
    /// ponds far apart, is empty.
    tiles: Vec<wgpu::Buffer>,
    extents: Vec<Extent>,
    numbers: wgpu::Buffer,
    /// Range of the triangles of each level in `numbers`.
    levels: [Range<u32>; LEVELS],
    cell_m: f32,
}

impl BottomBuffers {
    /// Uploads tiles of (`BOTTOM_TILE` + 1) squared corners each, row by row, `cell_m` metres
    /// apart.
    pub fn new(
        uploader: &Uploader,
        cell_m: f32,
        tiles: impl Iterator<Item = Vec<BottomVertex>>,
    ) -> Self {
        let mut numbers = Vec::new();
        let levels = std::array::from_fn(|level| {
            let start = numbers.len() as u32;
            numbers.extend(triangles(1 << level));
            start..numbers.len() as u32
        });
        let mut drawn = tiles.filter_map(|tile| extent(&tile).map(|extent| (tile, extent)));
        let (mut buffers, mut extents) = (Vec::new(), Vec::new());
        loop {
            let held: Vec<_> = drawn.by_ref().take(TILES_A_BUFFER).collect();
            if held.is_empty() {
                break;
            }
            extents.extend(held.iter().map(|(_, extent)| *extent));
            let (usage, count) = (wgpu::BufferUsages::VERTEX, held.len() * VERTICES);
            let vertices = held.into_iter().flat_map(|(tile, extent)| with_skirts(tile, extent));
            buffers.push(uploader.buffer("bottom", usage, count, vertices));
        }
        let (usage, count) = (wgpu::BufferUsages::INDEX, numbers.len());
        Self {
            tiles: buffers,
            numbers: uploader.buffer("triangles", usage, count, numbers.into_iter()),
            extents,
            levels,
            cell_m,
        }
    }

    /// Returns the box around everything that is drawn; `None` where nothing is.
    pub fn extent(&self) -> Option<[Vec3; 2]> {
        let boxes = self.extents.iter().copied();
        boxes.reduce(|[low, high], [from, to]| [low.min(from), high.max(to)])
    }

    /// Returns the tiles that are visible in a picture of this height, and the level of each.
    fn seen(&self, draw: &BottomDraw, height_px: f32) -> impl Iterator<Item = (usize, usize)> {
        let tiles = self.extents.iter().enumerate();
        tiles.filter_map(move |(tile, extent)| {
            let nearest = nearest(&draw.projection, *extent)?;
            let pixels_a_metre = draw.pixels_a_metre(height_px, nearest);
            Some((tile, level(self.cell_m * pixels_a_metre)))
        })
    }
}

/// Returns the distance of the nearest corner of a box in front of the camera, 0 where the camera
/// is within; `None` where none of it is in the picture.
fn nearest(projection: &CameraProjection, [low, high]: [Vec3; 2]) -> Option<f32> {
    let clip = corners(low, high).map(|place| projection.clip_from_world * place.extend(1.0));
    let all = |is_out: fn(&Vec4) -> bool| clip.iter().all(is_out);
    let is_out = all(|c| c.x < -c.w)
        || all(|c| c.x > c.w)
        || all(|c| c.y < -c.w)
        || all(|c| c.y > c.w)
        || all(|c| c.w <= 0.0);
    (!is_out).then(|| clip.iter().map(|c| c.w).fold(f32::MAX, f32::min).max(0.0))
}

/// Parameters of a picture of the bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BottomDraw {
    /// Projection from world metres to the picture.
    pub projection: CameraProjection,
    /// Unit vector towards the light: east, north, up.
    pub light: Vec3,
    /// Vertical exaggeration, which the projection includes.
    pub exaggeration: f32,
    /// Distance between isobaths and the depth of one of them, metres; `None` for no isobaths.
    pub isobaths_m: Option<[f32; 2]>,
    /// Width of an isobath, pixels.
    pub line_px: f32,
    /// Brightness of a bottom that is turned away from the light; that of level ground is 1.
    pub darkest: f32,
    /// The part that is drawn.
    pub part: ScenePart,
}

impl BottomDraw {
    /// Returns the pixels that a metre perpendicular to the view takes at `away_m` in front of the
    /// camera.
    fn pixels_a_metre(&self, height_px: f32, away_m: f32) -> f32 {
        let upward = self.projection.clip_from_world.row(1).truncate();
        let upward = Vec3::new(upward.x, upward.y, upward.z / self.exaggeration);
        0.5 * height_px * upward.length() / away_m.max(1e-6)
    }
}

/// Returns the unit vector towards a light at this compass direction and height over the horizon,
/// degrees.
pub fn towards_light(azimuth_deg: f32, altitude_deg: f32) -> Vec3 {
    let (sin_altitude, cos_altitude) = altitude_deg.to_radians().sin_cos();
    let (sin_azimuth, cos_azimuth) = azimuth_deg.to_radians().sin_cos();
    (Vec2::new(sin_azimuth, cos_azimuth) * cos_altitude).extend(sin_altitude)
}

/// The uniform block `View` of `bottom.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct ViewUniform {
    clip_from_world: Mat4,
    light: Vec3,
    exaggeration: f32,
    isobath_m: f32,
    first_m: f32,
    half_line_px: f32,
    darkest: f32,
    low: Vec4,
    high: Vec4,
    cut: Vec4,
}

/// The pipeline for the bottom, with the uniforms of one view.
pub struct BottomRenderer {
    pipeline: OffscreenPipeline,
    view: Uniform,
}

impl BottomRenderer {
    /// Builds the pipeline.
    pub fn new(device: &wgpu::Device) -> Self {
        let pipeline = OffscreenPipeline::new(
            device,
            PipelineParts {
                label: "bottom",
                shader: include_str!("../../../shaders/bottom.wgsl"),
                entries: ["vertex", "fragment"],
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: size_of::<BottomVertex>() as u64,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![
                        0 => Float32x3, 1 => Snorm16x2, 2 => Unorm8x4, 3 => Unorm8x4
                    ],
                })],
                blend: None,
                topology: wgpu::PrimitiveTopology::TriangleList,
            },
            true,
        );
        let view = pipeline.uniform(device, size_of::<ViewUniform>());
        Self { pipeline, view }
    }

    /// Draws the bottom in a pass of the target.
    pub fn draw(
        &self,
        queue: &wgpu::Queue,
        target: &RenderTarget,
        pass: &mut wgpu::RenderPass<'_>,
        bottom: &BottomBuffers,
        draw: &BottomDraw,
    ) {
        let [isobath_m, first_m] = draw.isobaths_m.unwrap_or_default();
        let [low, high, cut] = draw.part.uniform();
        let uniform = ViewUniform {
            clip_from_world: draw.projection.clip_from_world,
            light: draw.light,
            exaggeration: draw.exaggeration,
            isobath_m,
            first_m,
            half_line_px: 0.5 * draw.line_px,
            darkest: draw.darkest,
            low,
            high,
            cut,
        };
        pass.set_pipeline(&self.pipeline.pipeline);
        self.view.set(queue, pass, &uniform);
        pass.set_index_buffer(bottom.numbers.slice(..), wgpu::IndexFormat::Uint16);
        let height_px = target.size_px()[1] as f32;
        for (tile, level) in bottom.seen(draw, height_px) {
            let (buffer, place) = (tile / TILES_A_BUFFER, tile % TILES_A_BUFFER);
            pass.set_vertex_buffer(0, bottom.tiles[buffer].slice(..));
            let first = (place * VERTICES) as i32;
            // The shader gets the level as the number of the instance.
            let instance = level as u32;
            pass.draw_indexed(bottom.levels[level].clone(), first, instance..instance + 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::OrbitCamera;
    use super::super::pipeline::tests::assert_laid_out;
    use super::*;

    #[test]
    fn the_shader_reads_the_view_as_it_is_written() {
        assert_laid_out!(
            "bottom.wgsl",
            "View",
            ViewUniform {
                clip_from_world,
                light,
                exaggeration,
                isobath_m,
                first_m,
                half_line_px,
                darkest,
                low,
                high,
                cut
            }
        );
    }

    #[test]
    fn triangles_of_every_level_cover_a_tile_once_and_reach_no_further() {
        for stride in (0..LEVELS).map(|level| 1 << level) {
            let numbers = triangles(stride);
            assert!(numbers.iter().all(|corner| usize::from(*corner) < VERTICES));
            let flat = numbers
                .chunks(3)
                .filter(|corners| corners.iter().all(|corner| usize::from(*corner) < SIDE * SIDE));
            let place = |corner: u16| {
                let corner = usize::from(corner);
                Vec2::new((corner % SIDE) as f32, (corner / SIDE) as f32)
            };
            let area = flat.map(|corners| {
                let [a, b, c] = [corners[0], corners[1], corners[2]].map(place);
                0.5 * (b - a).perp_dot(c - a).abs()
            });
            let whole = (BOTTOM_TILE * BOTTOM_TILE) as f32;
            assert_eq!(area.sum::<f32>(), whole, "squares of {stride}");
            let of_skirts = 4 * 2 * BOTTOM_TILE / stride;
            let all = 2 * (BOTTOM_TILE / stride).pow(2) + of_skirts;
            assert_eq!(numbers.len(), 3 * all);
        }
    }

    #[test]
    fn squares_are_as_fine_as_the_screen_shows_them() {
        let levels = [8.0, 2.0, 1.0, 0.6, 0.5, 0.1, 0.001].map(level);
        assert_eq!(levels, [0, 0, 1, 2, 2, 4, 6]);
    }

    #[test]
    fn a_metre_takes_the_pixels_that_the_projection_gives_it_at_any_exaggeration() {
        for exaggeration in [1.0, 10.0] {
            let camera = OrbitCamera { distance_m: 50.0, exaggeration, ..OrbitCamera::default() };
            let projection = camera.projection(1.5);
            let draw = BottomDraw {
                projection,
                light: Vec3::Z,
                exaggeration,
                isobaths_m: None,
                line_px: 1.0,
                darkest: 0.25,
                part: ScenePart::WHOLE,
            };
            // Along the picture's horizontal axis, a metre is a metre of the world whatever the
            // exaggeration.
            let (sin, cos) = camera.azimuth_rad.sin_cos();
            let at = |metres: f32| projection.project(Vec3::new(cos, -sin, 0.0) * metres);
            let apart = at(0.5).zip(at(-0.5)).map(|(a, b)| (a - b).x);
            let expected = 0.5 * 900.0 * apart.expect("in front") * 1.5;
            let found = draw.pixels_a_metre(900.0, 50.0);
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        }
    }

    #[test]
    fn what_is_behind_or_beside_the_picture_is_not_drawn() {
        let camera = OrbitCamera::default();
        let projection = camera.projection(1.0);
        let cube = |centre: Vec3| [centre - Vec3::ONE, centre + Vec3::ONE];
        let here = nearest(&projection, cube(Vec3::ZERO)).expect("at the target");
        assert!((here - camera.distance_m).abs() < 2.0);
        let eye = projection.eye;
        assert_eq!(nearest(&projection, cube(eye)), Some(0.0));
        assert_eq!(nearest(&projection, cube(2.0 * eye)), None, "behind");
        assert_eq!(nearest(&projection, cube(Vec3::new(500.0, 0.0, 0.0))), None);
    }

    #[test]
    fn the_light_comes_from_where_it_is_said_to() {
        let near = |a: Vec3, b: Vec3| assert!((a - b).length() < 1e-6, "{a} {b}");
        near(towards_light(90.0, 0.0), Vec3::X);
        near(towards_light(0.0, 0.0), Vec3::Y);
        near(towards_light(123.0, 90.0), Vec3::Z);
    }
}
