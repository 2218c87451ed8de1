//! Draws without egui's painter, whose triangles would take most of the time of a frame without a
//! graphics card: areas of one colour, and pictures, in the window's pass (see [`FlatRenderer`]);
//! and curves and strips into pixels.

use super::render::{FlatRenderer, RenderTarget, Rgba};
use eframe::egui_wgpu::{
    Callback, CallbackResources, CallbackTrait, RenderState, ScreenDescriptor,
};
use egui::emath::GuiRounding as _;
use egui::{
    Color32, ColorImage, Context, PaintCallback, Painter, Pos2, Rect, Shape, TextureHandle,
    TextureOptions, pos2,
};
use std::any::Any;
use std::collections::HashMap;
use std::sync::Arc;

/// Paint callback of an area; where two frames share the callback, they look the same.
type Drawing = Arc<dyn Any + Send + Sync>;

/// Fills an area with an opaque colour.
pub(super) fn fill(painter: &Painter, rect: Rect, colour: Color32, state: Option<&RenderState>) {
    match state {
        Some(state) => painter.add(filled(painter.ctx(), rect, colour, state)),
        None => painter.rect_filled(rect, 0.0, colour),
    };
}

/// Returns a shape that fills an area with an opaque colour.
pub(super) fn filled(ctx: &Context, rect: Rect, colour: Color32, state: &RenderState) -> Shape {
    let callback = ctx.data_mut(|data| {
        let fills = data.get_temp_mut_or_default::<Fills>(egui::Id::NULL);
        let fill = fills.0.entry(colour);
        fill.or_insert_with(|| drawing(colour, state, None)).clone()
    });
    Shape::Callback(PaintCallback { rect, callback })
}

/// The fills that the window has used so far, by colour.
#[derive(Clone, Default)]
struct Fills(HashMap<Color32, Drawing>);

/// A texture that the window's pass shows with one texel per pixel.
pub(super) struct FlatPicture {
    binding: wgpu::BindGroup,
    drawing: Option<(Color32, Drawing)>,
}

impl FlatPicture {
    /// Creates a picture that shows what is drawn into a texture.
    pub(super) fn new(state: &RenderState, texture: &wgpu::TextureView) -> Self {
        let mut renderer = state.renderer.write();
        let resources = &mut renderer.callback_resources;
        let flat = flat_renderer(resources, &state.device, state.target_format);
        Self { binding: flat.bind_picture(&state.device, texture), drawing: None }
    }

    /// Returns a shape that shows the picture in an area of its size, multiplied by a colour.
    pub(super) fn shape(&mut self, rect: Rect, tint: Color32, state: &RenderState) -> Shape {
        let before = self.drawing.take().filter(|(last, _)| *last == tint);
        let new = || (tint, drawing(tint, state, Some(self.binding.clone())));
        let (_, callback) = self.drawing.insert(before.unwrap_or_else(new));
        let callback = callback.clone();
        Shape::Callback(PaintCallback { rect, callback })
    }
}

fn drawing(colour: Color32, state: &RenderState, picture: Option<wgpu::BindGroup>) -> Drawing {
    let flat = Flat { target: state.target_format, colour: colour.to_array(), picture };
    Callback::new_paint_callback(Rect::NOTHING, flat).callback
}

/// Returns the renderer of the window, which all its views share; builds it on the first call.
fn flat_renderer<'r>(
    resources: &'r mut CallbackResources,
    device: &wgpu::Device,
    target: wgpu::TextureFormat,
) -> &'r mut FlatRenderer {
    resources.entry::<FlatRenderer>().or_insert_with(|| FlatRenderer::new(device, target))
}

/// Paint callback of one area: a colour, or a picture multiplied by a colour.
struct Flat {
    target: wgpu::TextureFormat,
    colour: Rgba,
    picture: Option<wgpu::BindGroup>,
}

impl CallbackTrait for Flat {
    fn prepare(
        &self,
        device: &wgpu::Device,
        _queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        flat_renderer(resources, device, self.target).prepare(device, self.colour);
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        let Some(renderer) = resources.get::<FlatRenderer>() else {
            return;
        };
        match &self.picture {
            Some(picture) => renderer.show(pass, picture, self.colour),
            None => renderer.fill(pass, self.colour),
        }
    }
}

/// An offscreen picture shown in the window: a target that follows the size of a view, and what was
/// drawn into it last.
pub(super) struct ViewTexture<D> {
    shown: Option<(RenderTarget, FlatPicture)>,
    drawn: Option<D>,
}

impl<D> Default for ViewTexture<D> {
    fn default() -> Self {
        Self { shown: None, drawn: None }
    }
}

impl<D: PartialEq> ViewTexture<D> {
    /// Makes the target as large as `rect` on screen, draws into it if its size or the drawing has
    /// changed, and shows it over what was drawn before, with the opacity of the painter.
    pub(super) fn show(
        &mut self,
        painter: &Painter,
        rect: Rect,
        state: &RenderState,
        drawing: D,
        draw: impl FnOnce(&RenderTarget, &D),
    ) {
        let pixels_per_point = painter.pixels_per_point();
        let rect = rect.round_to_pixels(pixels_per_point);
        let size = rect.size() * pixels_per_point;
        let requested = [size.x.round() as u32, size.y.round() as u32];
        let size_px = RenderTarget::possible(&state.device, requested);
        let before = self.shown.take().filter(|(target, _)| target.size_px() == size_px);
        let is_new = before.is_none();
        let (target, picture) = self.shown.insert(before.unwrap_or_else(|| {
            let target = RenderTarget::new(&state.device, size_px);
            let picture = FlatPicture::new(state, target.colour());
            (target, picture)
        }));
        if is_new || self.drawn.as_ref() != Some(&drawing) {
            // The content of the texture is new, so the next shape gets a new callback.
            picture.drawing = None;
            draw(target, &drawing);
            self.drawn = Some(drawing);
        }
        let tint = Color32::WHITE.gamma_multiply(painter.opacity());
        painter.add(picture.shape(rect, tint, state));
    }
}

/// An area of the window, painted column by column.
pub(super) struct PaintedArea {
    area: Rect,
    pixels_per_point: f32,
    image: ColorImage,
}

impl PaintedArea {
    /// Creates an area filled with one colour.
    pub(super) fn new(painter: &Painter, area: Rect, ground: Color32) -> Self {
        let pixels_per_point = painter.pixels_per_point();
        let area = area.round_to_pixels(pixels_per_point);
        // A texture needs at least one pixel a side, and no more than every driver can hold.
        let side = |points: f32| ((points * pixels_per_point) as usize).clamp(1, 2048);
        let size = [side(area.width()), side(area.height())];
        Self { area, pixels_per_point, image: ColorImage::filled(size, ground) }
    }

    /// Returns the number of columns of pixels.
    pub(super) fn width(&self) -> usize {
        self.image.size[0]
    }

    /// Paints the part of a column between two heights of the screen, points.
    pub(super) fn span(&mut self, column: usize, from_y: f32, to_y: f32, colour: Color32) {
        let [width, height] = self.image.size;
        let row =
            |y: f32| ((y - self.area.top()) * self.pixels_per_point).clamp(0.0, height as f32);
        let (top, bottom) = (row(from_y.min(to_y)), row(from_y.max(to_y)));
        if column >= width {
            return;
        }
        for y in top as usize..(bottom.ceil() as usize).min(height) {
            let covered = (bottom.min(y as f32 + 1.0) - top.max(y as f32)).clamp(0.0, 1.0);
            let pixel = &mut self.image.pixels[y * width + column];
            *pixel = pixel.blend(colour.gamma_multiply(covered));
        }
    }

    /// Paints a line through points of the screen, which are ordered by column in either direction.
    pub(super) fn line(&mut self, points: &[Pos2], width: f32, colour: Color32) {
        // Everything that the line crosses in a column is one span, painted once.
        let mut spans = vec![None; self.width()];
        for pair in points.windows(2) {
            self.add_segment(&mut spans, pair[0], pair[1]);
        }
        for (column, span) in spans.into_iter().enumerate() {
            if let Some([top, bottom]) = span {
                self.span(column, top - 0.5 * width, bottom + 0.5 * width, colour);
            }
        }
    }

    fn add_segment(&self, spans: &mut [Option<[f32; 2]>], a: Pos2, b: Pos2) {
        let (a, b) = if a.x <= b.x { (a, b) } else { (b, a) };
        let [first, last] = [a.x, b.x].map(|x| (x - self.area.left()) * self.pixels_per_point);
        if !(first.is_finite() && last.is_finite()) || last < 0.0 {
            return;
        }
        let slope = (b.y - a.y) / (last - first).max(1e-6);
        let y = |x: f32| a.y + slope * (x.clamp(first, last) - first);
        for column in first.max(0.0) as usize..=(last as usize).min(spans.len().wrapping_sub(1)) {
            let x = column as f32;
            let ends = if last - first > 1e-6 { [y(x), y(x + 1.0)] } else { [a.y, b.y] };
            let [top, bottom] = spans[column].unwrap_or([ends[0]; 2]);
            let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            spans[column] = Some([top.min(low), bottom.max(high)]);
        }
    }

    /// Shows the painted area; `texture` keeps its image on the GPU from frame to frame.
    pub(super) fn show(self, painter: &Painter, texture: &mut Option<RasterTexture>) {
        let shown = texture.get_or_insert_with(|| RasterTexture::new(painter, self.image.clone()));
        shown.take(self.image);
        let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(shown.texture.id(), self.area, all, Color32::WHITE);
    }
}

/// A [`PaintedArea`] on the GPU.
pub(super) struct RasterTexture {
    image: ColorImage,
    texture: TextureHandle,
}

impl RasterTexture {
    fn new(painter: &Painter, image: ColorImage) -> Self {
        let context = painter.ctx();
        Self {
            texture: context.load_texture("raster", image.clone(), TextureOptions::NEAREST),
            image,
        }
    }

    /// Uploads an image if it differs from the last one.
    fn take(&mut self, image: ColorImage) {
        if self.image != image {
            self.texture.set(image.clone(), TextureOptions::NEAREST);
            self.image = image;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::vec2;

    fn raster() -> PaintedArea {
        let context = egui::Context::default();
        let painter = Painter::new(context, egui::LayerId::background(), Rect::EVERYTHING);
        let area = Rect::from_min_size(pos2(10.0, 20.0), vec2(4.0, 8.0));
        PaintedArea::new(&painter, area, Color32::BLACK)
    }

    fn column(raster: &PaintedArea, x: usize) -> Vec<u8> {
        let rows = raster.image.pixels.chunks(raster.width());
        rows.map(|row| row[x].r()).collect()
    }

    #[test]
    fn a_span_covers_its_ends_in_part_and_stays_within_the_area() {
        let mut raster = raster();
        raster.span(1, 21.5, 23.0, Color32::WHITE);
        let painted = column(&raster, 1);
        assert!((120..136).contains(&painted[1]), "{painted:?}");
        assert_eq!([painted[0], painted[2], painted[3]], [0, 255, 0]);
        raster.span(2, -1e9, 1e9, Color32::WHITE);
        assert_eq!(column(&raster, 2), [255; 8]);
        raster.span(9, 21.0, 23.0, Color32::WHITE);
        assert_eq!(column(&raster, 3), [0; 8]);
    }

    #[test]
    fn a_line_covers_every_column_on_its_way_in_either_direction() {
        let points = [pos2(10.0, 21.0), pos2(14.0, 25.0)];
        let [mut right, mut left] = [raster(), raster()];
        right.line(&points, 1.0, Color32::WHITE);
        left.line(&[points[1], points[0]], 1.0, Color32::WHITE);
        assert_eq!(right.image, left.image);
        for x in 0..4 {
            let painted = column(&right, x);
            assert_eq!(painted[x + 1], 255, "column {x}: {painted:?}");
            assert_eq!(painted[x + 4], 0, "column {x}: {painted:?}");
        }
    }

    #[test]
    fn a_line_of_a_spike_within_one_column_is_as_tall_as_the_spike() {
        let mut raster = raster();
        let [x, gone] = [11.5, f32::NAN];
        raster.line(&[pos2(x, 22.0), pos2(x, 27.0), pos2(gone, 0.0)], 1.0, Color32::WHITE);
        assert_eq!(column(&raster, 1)[2..7], [255; 5]);
        assert_eq!(column(&raster, 0), [0; 8]);
    }
}
