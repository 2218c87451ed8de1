//! Keeps the window's last picture, and draws in each frame only what differs from the frame
//! before.
//!
//! In: the shapes of a frame. Out: the picture of the window.
//!
//! A processor that draws takes some 40 ns for each pixel of text and buttons, most of which stand
//! still while a recording moves.

mod changes;

use super::flat::{self, FlatPicture};
use super::offscreen::{draw_shapes, upload_textures};
use super::render::extent;
use changes::{changed, covered};
use eframe::egui_wgpu::{RenderState, ScreenDescriptor};
use egui::epaint::{ClippedShape, ImageDelta};
use egui::{Color32, FullOutput, Rect, TextureId};
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
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("window"),
            size: extent(ground.size),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: gpu.target_format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[as_stored],
        });
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
