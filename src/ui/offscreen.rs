//! Draws the window without opening one: frames are drawn into a texture and read back, on a GPU or
//! on lavapipe.

use super::Shell;
use super::adapter::{self, block_on};
use super::render::{extent, plain_texture};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_products::export::{ExportError, write_atomically};
use eframe::egui_wgpu::{
    RenderState, RendererOptions, ScreenDescriptor, WgpuConfiguration, WgpuError, wgpu,
};
use egui::epaint::ClippedShape;
use egui::{ClippedPrimitive, TexturesDelta};
use image::RgbaImage;
use std::io::{self, BufWriter, Write as _};
use std::path::Path;
use std::time::{Duration, Instant};

/// Longest wait for everything to be computed and drawn at its final quality.
const TIME_LIMIT: Duration = Duration::from_secs(240);
/// Quiet frames after which a picture is ready: sizes settle over two frames, and tiles requested
/// in one frame are drawn in the next.
const STILL: u32 = 4;
/// Steps of the progress.
const STEPS: u64 = 100;
/// Longest wait for the GPU to finish one frame.
const FRAME_LIMIT: Duration = Duration::from_secs(60);

/// Advice for a computer without a working graphics driver.
pub(crate) const DRIVER: &str = if cfg!(windows) {
    "install the newest driver of the graphics card, with DirectX 12 or Vulkan"
} else {
    "install a Vulkan driver (on Debian, `mesa-vulkan-drivers` has one that needs no GPU)"
};

/// Reason why there is no picture, in one sentence.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// No graphics adapter works.
    #[error("no graphics adapter: {DRIVER}: {0}")]
    NoAdapter(#[from] WgpuError),
    /// The adapter cannot hold a picture of this size.
    #[error(
        "a picture must have 1 to {largest} pixels a side on this adapter; asked for {}x{}", size[0], size[1]
    )]
    Size {
        /// Width and height that were asked for.
        size: [u32; 2],
        /// Longest side that the adapter holds.
        largest: u32,
    },
    /// The picture is not ready within the time limit.
    #[error(
        "the picture was not ready after {} s; ask for fewer pings or a smaller size", TIME_LIMIT.as_secs()
    )]
    Late,
    /// The adapter does not finish a frame.
    #[error("the graphics adapter did not finish a frame: {0}")]
    Frame(#[from] wgpu::PollError),
    /// The adapter does not give the picture back.
    #[error("the picture could not be read back: {0}")]
    ReadBack(#[from] wgpu::MapRangeError),
    /// The adapter gives back only a part of the picture.
    #[error("the picture could not be read back whole")]
    Cut,
    /// The content of the picture is not available; the text is the notice that the window shows.
    #[error("{0}")]
    Notice(String),
    /// The drawing was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The file of the picture cannot be written.
    #[error(transparent)]
    File(#[from] ExportError),
}

/// A graphics device that draws pictures. The views keep data on the device: draw one shell with
/// one studio only.
pub struct Studio {
    gpu: RenderState,
}

impl Studio {
    /// Opens the first usable adapter.
    ///
    /// # Errors
    /// When no graphics adapter works.
    pub fn new() -> Result<Self, PictureError> {
        Ok(Self { gpu: gpu()? })
    }

    /// Returns name, interface and kind of the adapter.
    pub fn adapter(&self) -> String {
        let info = self.gpu.adapter.get_info();
        format!("{} ({}, {:?})", info.name, info.backend, info.device_type)
    }

    /// Draws the content of the window, `shell`, into a picture of `size` pixels.
    ///
    /// # Errors
    /// When the picture is larger than the adapter can hold, takes too long, or is cancelled.
    pub fn draw(
        &self,
        shell: &mut Shell,
        size: [u32; 2],
        pixels_per_point: f32,
        progress: &Progress,
    ) -> Result<RgbaImage, PictureError> {
        let mut reel = self.reel(size, pixels_per_point)?;
        reel.settle(shell, STILL, progress)?;
        reel.read_back()
    }

    /// Creates a reel, which draws successive pictures of one size.
    ///
    /// # Errors
    /// As [`Studio::draw`].
    pub(crate) fn reel(&self, size: [u32; 2], pixels_per_point: f32) -> Result<Reel, PictureError> {
        let largest = self.gpu.device.limits().max_texture_dimension_2d;
        if size.iter().any(|side| *side == 0 || *side > largest) {
            return Err(PictureError::Size { size, largest });
        }
        Ok(Reel::new(self.gpu.clone(), size, pixels_per_point))
    }
}

/// Writes a picture as PNG, first into another file that is then renamed: an error never leaves a
/// part of a picture.
///
/// # Errors
/// When the file cannot be written.
pub(crate) fn write_picture(picture: &RgbaImage, path: &Path) -> Result<(), ExportError> {
    write_atomically(path, |file| {
        let mut out = BufWriter::new(file);
        picture.write_to(&mut out, image::ImageFormat::Png).map_err(io::Error::other)?;
        out.flush()
    })
}

fn gpu() -> Result<RenderState, WgpuError> {
    let setup = adapter::setup();
    let config = WgpuConfiguration { wgpu_setup: setup.clone(), ..WgpuConfiguration::default() };
    let instance = block_on(setup.new_instance());
    let created = RenderState::create(&config, &instance, None, RendererOptions::PREDICTABLE);
    block_on(created)
}

/// Draws successive pictures, as of a film: an egui context and the texture that it is drawn into.
pub(crate) struct Reel {
    gpu: RenderState,
    ctx: egui::Context,
    target: wgpu::Texture,
    size: [u32; 2],
    pixels_per_point: f32,
    frames: u32,
}

impl Reel {
    fn new(gpu: RenderState, size: [u32; 2], pixels_per_point: f32) -> Self {
        let ctx = egui::Context::default();
        ctx.all_styles_mut(|style| style.animation_time = 0.0);
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let target = plain_texture(&gpu.device, size, gpu.target_format, usage, &[]);
        Self { gpu, ctx, target, size, pixels_per_point, frames: 0 }
    }

    /// Returns the next picture, once everything in it is drawn.
    ///
    /// # Errors
    /// As [`Studio::draw`].
    pub(crate) fn draw(
        &mut self,
        shell: &mut Shell,
        progress: &Progress,
    ) -> Result<RgbaImage, PictureError> {
        progress.check()?;
        // Sizes have settled with the first picture.
        let still = if self.frames == 0 { STILL } else { 2 };
        self.settle(shell, still, &Progress::new())?;
        self.read_back()
    }

    /// Draws frames until everything is computed and drawn at its final quality.
    fn settle(
        &mut self,
        shell: &mut Shell,
        still: u32,
        progress: &Progress,
    ) -> Result<(), PictureError> {
        let started = Instant::now();
        let mut drawn = 0;
        progress.start(STEPS);
        let mut quiet = 0;
        while quiet < still {
            progress.check()?;
            let repaint = self.frame(shell)?;
            let now = (shell.drawn_share() * STEPS as f32) as u64;
            progress.advance(now.saturating_sub(drawn));
            drawn = drawn.max(now);
            quiet = if shell.is_settled() && !repaint { quiet + 1 } else { 0 };
            if started.elapsed() > TIME_LIMIT {
                return Err(PictureError::Late);
            }
            if quiet == 0 {
                std::thread::sleep(Duration::from_millis(5));
            }
        }
        Ok(())
    }

    fn input(&mut self) -> egui::RawInput {
        self.frames += 1;
        let points = egui::vec2(self.size[0] as f32, self.size[1] as f32) / self.pixels_per_point;
        let mut input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, points)),
            max_texture_side: Some(self.gpu.device.limits().max_texture_dimension_2d as usize),
            time: Some(f64::from(self.frames) / 60.0),
            ..egui::RawInput::default()
        };
        if let Some(viewport) = input.viewports.get_mut(&egui::ViewportId::ROOT) {
            viewport.native_pixels_per_point = Some(self.pixels_per_point);
        }
        input
    }

    /// Draws one frame; returns true if another one was requested at once.
    fn frame(&mut self, shell: &mut Shell) -> Result<bool, PictureError> {
        let input = self.input();
        let gpu = self.gpu.clone();
        let output = self.ctx.run_ui(input, |ui| shell.frame(ui, Some(&gpu)));
        let mut viewports = output.viewport_output.values();
        let repaint = viewports.any(|viewport| viewport.repaint_delay.is_zero());
        self.paint(output)?;
        Ok(repaint)
    }

    fn paint(&mut self, mut output: egui::FullOutput) -> Result<(), PictureError> {
        let screen = ScreenDescriptor {
            size_in_pixels: self.size,
            pixels_per_point: output.pixels_per_point,
        };
        upload_textures(&self.gpu, &mut output.textures_delta);
        let view = self.target.create_view(&Default::default());
        let load = wgpu::LoadOp::Clear(wgpu::Color::BLACK);
        draw_shapes(&self.gpu, &self.ctx, output.shapes, &screen, &view, load);
        for id in output.textures_delta.free.drain() {
            self.gpu.renderer.write().free_texture(&id);
        }
        Ok(wait(&self.gpu.device)?)
    }

    fn read_back(&self) -> Result<RgbaImage, PictureError> {
        let [width, height] = self.size;
        let bytes_per_row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let RenderState { device, queue, .. } = &self.gpu;
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: u64::from(bytes_per_row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            self.target.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(bytes_per_row),
                    rows_per_image: None,
                },
            },
            extent(self.size),
        );
        queue.submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        wait(device)?;
        let mapped = buffer.slice(..).get_mapped_range()?;
        let mut pixels = Vec::with_capacity(4 * (width * height) as usize);
        for row in mapped.chunks(bytes_per_row as usize) {
            pixels.extend_from_slice(&row[..4 * width as usize]);
        }
        opaque(&mut pixels, self.gpu.target_format);
        RgbaImage::from_raw(width, height, pixels).ok_or(PictureError::Cut)
    }
}

/// Puts red before blue and removes transparency: what is behind a window is not part of a picture.
fn opaque(pixels: &mut [u8], format: wgpu::TextureFormat) {
    let swapped = format == wgpu::TextureFormat::Bgra8Unorm;
    for pixel in pixels.as_chunks_mut::<4>().0 {
        if swapped {
            pixel.swap(0, 2);
        }
        pixel[3] = 255;
    }
}

fn wait(device: &wgpu::Device) -> Result<(), wgpu::PollError> {
    let polled =
        device.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(FRAME_LIMIT) });
    polled.map(|_| ())
}

/// Uploads new and changed textures of egui, and takes them out of `textures`.
pub(super) fn upload_textures(gpu: &RenderState, textures: &mut TexturesDelta) {
    let mut renderer = gpu.renderer.write();
    for (id, images) in textures.set.drain() {
        for image in images {
            renderer.update_texture(&gpu.device, &gpu.queue, id, &image);
        }
    }
}

/// Draws shapes, in their order, over what `load` leaves of a texture of the size of `screen`.
pub(super) fn draw_shapes(
    gpu: &RenderState,
    ctx: &egui::Context,
    shapes: Vec<ClippedShape>,
    screen: &ScreenDescriptor,
    target: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) {
    let primitives: Vec<ClippedPrimitive> = ctx.tessellate(shapes, screen.pixels_per_point);
    let RenderState { device, queue, .. } = gpu;
    let mut renderer = gpu.renderer.write();
    let mut encoder = device.create_command_encoder(&Default::default());
    let own = renderer.update_buffers(device, queue, &mut encoder, &primitives, screen);
    let attachment = wgpu::RenderPassColorAttachment {
        view: target,
        resolve_target: None,
        ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
        depth_slice: None,
    };
    let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("egui into a texture"),
        color_attachments: &[Some(attachment)],
        ..Default::default()
    });
    renderer.render(&mut pass.forget_lifetime(), &primitives, screen);
    queue.submit(own.into_iter().chain([encoder.finish()]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::{Action, App, Command, Jobs};
    use crate::ui::incremental::IncrementalPainter;
    use egui::epaint::ClippedShape;
    use egui::{Event, Key, Modifiers, MouseWheelUnit, Pos2, TouchPhase, pos2, vec2};
    use std::sync::Arc;
    use std::sync::Mutex;

    /// Keeps the shapes that a frame paints, before they are replaced.
    struct Spy(Arc<Mutex<Vec<ClippedShape>>>);

    impl egui::Plugin for Spy {
        fn debug_name(&self) -> &'static str {
            "spy"
        }

        fn output_hook(&mut self, _ctx: &egui::Context, output: &mut egui::FullOutput) {
            self.0.lock().unwrap().clone_from(&output.shapes);
        }
    }

    fn key(key: Key, modifiers: Modifiers) -> Event {
        Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers }
    }

    fn scroll(pings: f32) -> Event {
        Event::MouseWheel {
            unit: MouseWheelUnit::Point,
            delta: vec2(pings, 0.0),
            phase: TouchPhase::Move,
            source: egui::MouseWheelSource::Unknown,
            modifiers: Modifiers::NONE,
        }
    }

    /// Returns the events of a minute's work: pointing, scrolling, the palette, a dialog, another
    /// theme, a selected ping.
    fn work() -> Vec<Event> {
        let at = |x, y| Event::PointerMoved(pos2(x, y));
        let click = |pos: Pos2| {
            [true, false].map(|pressed| Event::PointerButton {
                pos,
                button: egui::PointerButton::Primary,
                pressed,
                modifiers: Modifiers::NONE,
            })
        };
        let mut events = vec![at(500.0, 200.0), at(505.0, 210.0)];
        events.extend([scroll(-40.0), scroll(-120.0), scroll(30.0)]);
        events.extend(click(pos2(505.0, 210.0)));
        events.extend([at(40.0, 10.0), at(90.0, 10.0), at(120.0, 300.0)]);
        events.push(key(Key::K, Modifiers::COMMAND));
        events.extend(["s", "c", "a"].map(|typed| Event::Text(typed.to_owned())));
        events.push(key(Key::Escape, Modifiers::NONE));
        events.push(key(Key::F1, Modifiers::NONE));
        events.push(key(Key::Escape, Modifiers::NONE));
        events.extend([at(700.0, 420.0), scroll(-60.0), at(300.0, 420.0)]);
        events
    }

    #[test]
    fn a_frame_drawn_in_parts_is_the_one_drawn_whole() {
        for pixels_per_point in [1.0, 1.25] {
            let size = [1000, 640].map(|side| (side as f32 * pixels_per_point) as u32);
            let gpu = gpu().unwrap();
            let mut reel = Reel::new(gpu.clone(), size, pixels_per_point);
            let mut whole = Reel::new(gpu.clone(), size, pixels_per_point);
            whole.ctx = reel.ctx.clone();
            let painted = Arc::new(Mutex::new(Vec::new()));
            reel.ctx.add_plugin(Spy(painted.clone()));
            reel.ctx.add_plugin(IncrementalPainter::new(gpu.clone()));
            let mut shell = Shell::new(App::new(Jobs::Inline));
            shell.app.apply(Command::OpenDemo);
            reel.settle(&mut shell, 2, &Progress::new()).unwrap();
            for (step, event) in work().into_iter().enumerate() {
                if step == 8 {
                    shell.app.apply(Command::Do(Action::Theme));
                }
                let mut input = reel.input();
                input.events.push(event.clone());
                let output = reel.ctx.run_ui(input, |ui| shell.frame(ui, Some(&gpu)));
                assert_eq!(output.shapes.len(), 1, "one picture");
                reel.paint(output).unwrap();
                let all = egui::FullOutput {
                    shapes: painted.lock().unwrap().clone(),
                    pixels_per_point,
                    ..Default::default()
                };
                whole.paint(all).unwrap();
                let [part, whole] = [&reel, &whole].map(|reel| reel.read_back().unwrap());
                let differing = (part.enumerate_pixels().zip(whole.pixels()))
                    .find(|((_, _, part), whole)| part != whole);
                assert_eq!(differing, None, "at {pixels_per_point} after {event:?}");
            }
        }
    }
}
