//! Keeps the window's last picture, and draws in each frame only what differs from the frame
//! before.
//!
//! In: the shapes of a frame. Out: the picture of the window.
//!
//! A processor that draws takes some 40 ns for each pixel of text and buttons, most of which stand
//! still while a recording moves.

use super::flat::{self, FlatPicture};
use super::offscreen::{draw_shapes, upload_textures};
use super::render::plain_texture;
use eframe::egui_wgpu::{RenderState, ScreenDescriptor};
use egui::epaint::{ClippedShape, ImageDelta};
use egui::{Color32, FullOutput, Pos2, Rect, Shape, TextureId};
use std::collections::HashSet;

/// Replaces all that a frame paints by one picture of the window.
pub(super) struct IncrementalPainter {
    gpu: RenderState,
    kept: Option<Kept>,
}

/// The last frame.
struct Kept {
    texture: wgpu::Texture,
    picture: FlatPicture,
    ground: FrameTarget,
    shapes: Vec<ClippedShape>,
}

/// Size, scale and background of a frame. A change of them requires a new picture.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FrameTarget {
    size: [u32; 2],
    pixels_per_point: f32,
    colour: Color32,
}

impl IncrementalPainter {
    /// A painter of the window with this device, before its first frame.
    pub(super) fn new(gpu: RenderState) -> Self {
        Self { gpu, kept: None }
    }

    /// Draws what differs from the last frame into the kept picture.
    fn draw(&mut self, ctx: &egui::Context, ground: FrameTarget, output: &mut FullOutput) {
        let textures: HashSet<TextureId> = replaced(output);
        upload_textures(&self.gpu, &mut output.textures_delta);
        // Glyphs that shapes show already may have moved within it.
        let is_font_new = textures.contains(&TextureId::default());
        let kept = self.kept.take();
        let kept = kept.filter(|kept| kept.ground == ground && !is_font_new);
        let mut kept = kept.unwrap_or_else(|| Kept::new(&self.gpu, ground));
        let now = std::mem::take(&mut output.shapes);
        let shapes = kept.shapes_to_draw(ctx, &self.gpu, &now, &textures);
        if !shapes.is_empty() {
            let screen = ScreenDescriptor {
                size_in_pixels: ground.size,
                pixels_per_point: ground.pixels_per_point,
            };
            let view = kept.texture.create_view(&Default::default());
            let load = wgpu::LoadOp::Load;
            draw_shapes(&self.gpu, ctx, shapes, &screen, &view, load);
        }
        kept.shapes = now;
        let window = ground.rect();
        let shape = kept.picture.shape(window, Color32::WHITE, &self.gpu);
        output.shapes = vec![ClippedShape::new(window, shape)];
        self.kept = Some(kept);
    }
}

impl egui::Plugin for IncrementalPainter {
    fn debug_name(&self) -> &'static str {
        "incremental painter"
    }

    fn output_hook(&mut self, ctx: &egui::Context, output: &mut FullOutput) {
        let pixels_per_point = output.pixels_per_point;
        let size = ctx.viewport_rect().size() * pixels_per_point;
        let ground = FrameTarget {
            size: [size.x.round() as u32, size.y.round() as u32],
            pixels_per_point,
            colour: ctx.global_style().visuals.panel_fill,
        };
        let largest = self.gpu.device.limits().max_texture_dimension_2d;
        if (ground.size.iter()).all(|side| (1..=largest).contains(side)) {
            self.draw(ctx, ground, output);
        }
    }
}

impl FrameTarget {
    /// The whole window, points.
    fn rect(&self) -> Rect {
        let size = self.size.map(|side| side as f32 / self.pixels_per_point);
        Rect::from_min_size(egui::Pos2::ZERO, size.into())
    }
}

impl Kept {
    fn new(gpu: &RenderState, ground: FrameTarget) -> Self {
        let as_stored = gpu.target_format.remove_srgb_suffix();
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let (size, format) = (ground.size, gpu.target_format);
        let texture = plain_texture(&gpu.device, size, format, usage, &[as_stored]);
        // Colours are copied as they are stored, without a way over linear ones.
        let stored = texture.create_view(&wgpu::TextureViewDescriptor {
            format: Some(as_stored),
            ..Default::default()
        });
        let picture = FlatPicture::new(gpu, &stored);
        Self { texture, picture, ground, shapes: Vec::new() }
    }

    /// The ground and the shapes of each area that changed, cut to the area.
    fn shapes_to_draw(
        &self,
        ctx: &egui::Context,
        gpu: &RenderState,
        now: &[ClippedShape],
        textures: &HashSet<TextureId>,
    ) -> Vec<ClippedShape> {
        let FrameTarget { pixels_per_point, colour, .. } = self.ground;
        let fill = |rect| ClippedShape::new(rect, flat::filled(ctx, rect, colour, gpu));
        if self.shapes.is_empty() {
            let ground = fill(self.ground.rect());
            return std::iter::once(ground).chain(now.to_vec()).collect();
        }
        let areas = changed(&self.shapes, now, textures, pixels_per_point);
        let mut shapes = Vec::new();
        for area in areas {
            let rect = area.rect(pixels_per_point).intersect(self.ground.rect());
            shapes.push(fill(rect));
            let overlaps = |shape: &&ClippedShape| {
                covered(shape, pixels_per_point).is_some_and(|covered| covered.overlaps(&area))
            };
            shapes.extend(now.iter().filter(overlaps).map(|shape| ClippedShape {
                clip_rect: shape.clip_rect.intersect(rect),
                ..shape.clone()
            }));
        }
        shapes
    }
}

/// Textures with new content in places that a shape may already show.
fn replaced(output: &FullOutput) -> HashSet<TextureId> {
    let set = output.textures_delta.set.iter();
    // A part of the font's texture is a glyph that no shape has shown so far.
    let is_new = |id: &TextureId, images: &[ImageDelta]| {
        *id != TextureId::default() || images.iter().any(|image| image.is_whole())
    };
    set.filter(|(id, images)| is_new(id, images)).map(|(id, _)| *id).collect()
}

/// Most areas that are drawn apart: beyond, one that holds them all costs less.
const MOST_AREAS: usize = 24;

/// An area of whole pixels; its ends are excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PixelArea {
    pub min: [i32; 2],
    pub max: [i32; 2],
}

impl PixelArea {
    /// The pixels that a rectangle touches.
    fn around(rect: Rect, pixels_per_point: f32) -> Self {
        let low = |at: f32| (at * pixels_per_point).floor() as i32;
        let high = |at: f32| (at * pixels_per_point).ceil() as i32;
        Self { min: [low(rect.min.x), low(rect.min.y)], max: [high(rect.max.x), high(rect.max.y)] }
    }

    /// Its rectangle, points.
    fn rect(&self, pixels_per_point: f32) -> Rect {
        let corner = |[x, y]: [i32; 2]| Pos2::new(x as f32, y as f32) / pixels_per_point;
        Rect::from_min_max(corner(self.min), corner(self.max))
    }

    /// Returns true if two areas share a pixel.
    fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.min[axis] < other.max[axis] && other.min[axis] < self.max[axis])
    }

    fn union(&self, other: &Self) -> Self {
        Self {
            min: [0, 1].map(|axis| self.min[axis].min(other.min[axis])),
            max: [0, 1].map(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    fn pixels(&self) -> i64 {
        let side = |axis: usize| i64::from(self.max[axis]) - i64::from(self.min[axis]);
        side(0) * side(1)
    }

    /// Returns true if drawing both as one costs no more than drawing them apart: about a quarter
    /// more pixels.
    fn joins(&self, other: &Self) -> bool {
        let apart = self.pixels() + other.pixels();
        self.overlaps(other) || 4 * self.union(other).pixels() <= 5 * apart
    }
}

/// Pixels that a shape can cover, soft edges included; `None` where it covers none.
fn covered(shape: &ClippedShape, pixels_per_point: f32) -> Option<PixelArea> {
    let sharp_corners = match &shape.shape {
        Shape::Path(path) => path.stroke.width,
        _ => 0.0,
    };
    let bounds = shape.shape.visual_bounding_rect().expand(sharp_corners);
    let reach = (shape.transform_after_tessellation * bounds).expand(1.0 / pixels_per_point);
    let rect = reach.intersect(shape.clip_rect);
    bounds
        .is_finite()
        .then(|| PixelArea::around(rect, pixels_per_point))
        .filter(|area| area.min[0] < area.max[0] && area.min[1] < area.max[1])
}

/// The areas, none over another, outside of which two frames look the same. `textures` are those
/// with new content.
fn changed(
    before: &[ClippedShape],
    now: &[ClippedShape],
    textures: &HashSet<TextureId>,
    pixels_per_point: f32,
) -> Vec<PixelArea> {
    let mut areas = Vec::new();
    let mut add = |shape: &ClippedShape| add(&mut areas, covered(shape, pixels_per_point));
    let [runs_before, runs_now] = [before, now].map(runs);
    let has_same_clip = |a: &&[ClippedShape], b: &&[ClippedShape]| a[0].clip_rect == b[0].clip_rect;
    let aligned = align(&runs_before, &runs_now, has_same_clip);
    for run in aligned.removed.iter().chain(aligned.added) {
        run.iter().for_each(&mut add);
    }
    for (before, now) in aligned.pairs {
        let is_one_to_one = before.len() == now.len();
        let shapes = align(before, now, |a, b| is_one_to_one || is_same(a, b, textures));
        shapes.removed.iter().chain(shapes.added).for_each(&mut add);
        for (before, now) in shapes.pairs {
            if is_one_to_one && !is_same(before, now, textures) {
                add(before);
                add(now);
            }
        }
    }
    areas
}

/// Shapes that follow each other with one clip rectangle.
fn runs(shapes: &[ClippedShape]) -> Vec<&[ClippedShape]> {
    shapes.chunk_by(|a, b| a.clip_rect == b.clip_rect).collect()
}

/// Two sequences, the beginnings and the ends of which belong together.
struct Aligned<'a, T> {
    pairs: Vec<(&'a T, &'a T)>,
    removed: &'a [T],
    added: &'a [T],
}

fn align<'a, T>(
    before: &'a [T],
    now: &'a [T],
    belong_together: impl Fn(&T, &T) -> bool,
) -> Aligned<'a, T> {
    let head = (before.iter().zip(now)).take_while(|(a, b)| belong_together(a, b)).count();
    let [left_before, left_now] = [&before[head..], &now[head..]];
    let tail = (left_before.iter().rev().zip(left_now.iter().rev()))
        .take_while(|(a, b)| belong_together(a, b))
        .count();
    let (removed, tail_before) = left_before.split_at(left_before.len() - tail);
    let (added, tail_now) = left_now.split_at(left_now.len() - tail);
    let pairs = before[..head].iter().zip(now);
    Aligned { pairs: pairs.chain(tail_before.iter().zip(tail_now)).collect(), removed, added }
}

/// Returns true if two shapes are drawn alike.
fn is_same(before: &ClippedShape, now: &ClippedShape, textures: &HashSet<TextureId>) -> bool {
    !reads(&now.shape, textures) && before == now
}

/// Returns true if a shape shows one of the textures, or one that another owner can draw into at
/// any time.
fn reads(shape: &Shape, textures: &HashSet<TextureId>) -> bool {
    match shape {
        Shape::Vec(shapes) => shapes.iter().any(|shape| reads(shape, textures)),
        shape => match shape.texture_id() {
            TextureId::User(_) => true,
            managed => textures.contains(&managed),
        },
    }
}

/// Adds an area to areas none of which lies over another.
fn add(areas: &mut Vec<PixelArea>, area: Option<PixelArea>) {
    let Some(mut area) = area else {
        return;
    };
    while let Some(near) = areas.iter().position(|other| other.joins(&area)) {
        area = area.union(&areas.swap_remove(near));
    }
    areas.push(area);
    if areas.len() > MOST_AREAS {
        let whole = areas.drain(..).reduce(|a, b| a.union(&b));
        areas.extend(whole);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::vec2;
    use proptest::collection::vec;
    use proptest::prelude::*;

    fn square(at: [f32; 2], clip: Rect, colour: Color32) -> ClippedShape {
        let rect = Rect::from_min_size(at.into(), vec2(10.0, 10.0));
        ClippedShape::new(clip, Shape::rect_filled(rect, 0.0, colour))
    }

    fn clip(x: f32) -> Rect {
        Rect::from_min_size(Pos2::new(x, 0.0), vec2(100.0, 100.0))
    }

    fn areas(before: &[ClippedShape], now: &[ClippedShape]) -> Vec<[i32; 4]> {
        let mut areas: Vec<[i32; 4]> = changed(before, now, &HashSet::new(), 1.0)
            .iter()
            .map(|area| [area.min[0], area.min[1], area.max[0], area.max[1]])
            .collect();
        areas.sort_unstable();
        areas
    }

    #[test]
    fn a_frame_like_the_one_before_changes_nothing() {
        let frame = [square([10.0, 10.0], clip(0.0), Color32::RED)];
        assert_eq!(areas(&frame, &frame), Vec::<[i32; 4]>::new());
    }

    #[test]
    fn a_shape_that_moves_changes_where_it_was_and_where_it_is() {
        let [left, right] = [clip(0.0), clip(200.0)];
        let still = square([210.0, 10.0], right, Color32::BLUE);
        let before = [square([10.0, 10.0], left, Color32::RED), still.clone()];
        let now = [square([70.0, 70.0], left, Color32::RED), still];
        let expected = vec![[9, 9, 21, 21], [69, 69, 81, 81]];
        assert_eq!(areas(&before, &now), expected);
    }

    #[test]
    fn shapes_that_are_added_move_no_others() {
        let [left, right] = [clip(0.0), clip(200.0)];
        let first = square([10.0, 10.0], left, Color32::RED);
        let last = square([60.0, 60.0], left, Color32::RED);
        let beside = square([210.0, 10.0], right, Color32::BLUE);
        let added = square([40.0, 10.0], left, Color32::GREEN);
        let before = [first.clone(), last.clone(), beside.clone()];
        let now = [first.clone(), added.clone(), last.clone(), beside.clone()];
        assert_eq!(areas(&before, &now), [[39, 9, 51, 21]]);
        // And with a part of the window that was not there before.
        let other = ClippedShape { clip_rect: clip(20.0), ..added };
        let now = [first, last, other, beside];
        assert_eq!(areas(&before, &now), [[39, 9, 51, 21]]);
    }

    #[test]
    fn shapes_that_change_their_order_are_drawn_again() {
        let [a, b] = [[10.0, 10.0], [15.0, 15.0]];
        let below = square(a, clip(0.0), Color32::RED);
        let above = square(b, clip(1.0), Color32::BLUE);
        let changed = areas(&[below.clone(), above.clone()], &[above, below]);
        assert_eq!(changed, [[9, 9, 26, 26]]);
    }

    #[test]
    fn a_texture_with_new_content_changes_what_shows_it() {
        let shown = |id| {
            let mut mesh = egui::Mesh::with_texture(id);
            mesh.add_rect_with_uv(clip(0.0), clip(0.0), Color32::WHITE);
            [ClippedShape::new(clip(0.0), Shape::mesh(mesh))]
        };
        let [new, old] = [TextureId::Managed(3), TextureId::Managed(4)];
        let textures = HashSet::from([new]);
        let count = |frame: &[ClippedShape]| changed(frame, frame, &textures, 1.0).len();
        assert_eq!([count(&shown(new)), count(&shown(old))], [1, 0]);
    }

    proptest! {
        #[test]
        fn many_areas_become_few_and_none_lies_over_another(
            corners in vec((0..1200, 0..700, 1..90, 1..90), 1..400),
        ) {
            let mut areas = Vec::new();
            let all: Vec<PixelArea> = (corners.into_iter())
                .map(|(x, y, width, height)| PixelArea { min: [x, y], max: [x + width, y + height] })
                .collect();
            all.iter().for_each(|area| add(&mut areas, Some(*area)));
            prop_assert!(areas.len() <= MOST_AREAS);
            let is_held =
                |area: &PixelArea| areas.iter().any(|kept| kept.union(area) == *kept);
            prop_assert!(all.iter().all(is_held));
            for (index, area) in areas.iter().enumerate() {
                prop_assert!(!areas[..index].iter().any(|earlier| earlier.overlaps(area)));
            }
        }
    }
}
