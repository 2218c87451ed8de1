//! A waterfall that stays from frame to frame: what only moved is copied, and what is new is drawn. A pixel costs many reads of
//! textures, which a driver without a graphics card does slowly; a step of the wheel leaves nearly all pixels as they are.

use super::Target;
use super::waterfall::{Look, Quad, Tables, TileTexture, WaterfallPicture};
use std::ops::Range;

/// Plain sRGB bytes, which the window shows unchanged.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// A picture that has moved by so much more or less than whole pixels is drawn anew, pixels.
const MOST_OFF_PX: f64 = 0.02;

/// What a frame shows.
pub struct WaterfallFrame {
    /// How colours are made.
    pub look: Look,
    /// What tiles are brought to one level by.
    pub tables: Tables,
    /// The tiles, where they lie.
    pub tiles: Vec<(Quad, TileTexture)>,
    /// Where the picture begins along the track, pixels: what is shown moves to the left, or up, as it grows.
    pub start_px: f64,
    /// Scales and colours: where one of them is another, nothing stays.
    pub scales: [f64; 4],
}

impl WaterfallFrame {
    /// Pixels along the track that a quad covers.
    fn along_px(&self, quad: &Quad, length_px: u32) -> Range<u32> {
        let length = f64::from(length_px);
        let place = |clip: f32| match self.look.time_is_down {
            1 => 0.5 * (1.0 - f64::from(clip)) * length,
            _ => 0.5 * (1.0 + f64::from(clip)) * length,
        };
        let [a, b] = quad.along.map(place);
        let [from, to] = [a.min(b).floor(), a.max(b).ceil()].map(|end| end.clamp(0.0, length));
        from as u32..to as u32
    }
}

/// A picture, and what it shows.
pub struct ScrolledWaterfall {
    size_px: [u32; 2],
    front: wgpu::Texture,
    back: wgpu::Texture,
    drawn: Option<WaterfallFrame>,
}

impl ScrolledWaterfall {
    /// An empty one, of at most the device's largest texture.
    pub fn new(device: &wgpu::Device, size_px: [u32; 2]) -> Self {
        let size_px = Target::possible(device, size_px);
        Self {
            size_px,
            front: texture(device, size_px),
            back: texture(device, size_px),
            drawn: None,
        }
    }

    /// What draws the tiles of such a picture.
    pub fn renderer(device: &wgpu::Device) -> WaterfallPicture {
        WaterfallPicture::new(device, FORMAT)
    }

    /// Width and height in pixels.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// The picture, until it is drawn again.
    pub fn view(&self) -> wgpu::TextureView {
        self.front.create_view(&Default::default())
    }

    /// Draws a frame; whether the picture is in another texture then.
    pub fn draw(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        renderer: &WaterfallPicture,
        frame: WaterfallFrame,
    ) -> bool {
        let length_px = self.size_px[usize::from(frame.look.time_is_down == 1)];
        let stays = self
            .drawn
            .as_ref()
            .and_then(|drawn| stays(drawn, &frame, length_px));
        if stays
            .as_ref()
            .is_some_and(|(moved_px, fresh)| *moved_px == 0 && fresh.is_empty())
        {
            return false;
        }
        renderer.prepare(queue, frame.look, frame.tiles.iter().map(|(quad, _)| quad));
        let mut encoder = device.create_command_encoder(&Default::default());
        let view = self.back.create_view(&Default::default());
        let fresh = match &stays {
            Some((moved_px, fresh)) => {
                begin(
                    &mut encoder,
                    &view,
                    wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                );
                for kept in kept(*moved_px, fresh, length_px) {
                    self.copy(&mut encoder, *moved_px, kept, frame.look.time_is_down == 1);
                }
                fresh.clone()
            }
            None => 0..length_px,
        };
        if !fresh.is_empty() {
            let load = match stays {
                Some(_) => wgpu::LoadOp::Load,
                None => wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
            };
            let mut pass = begin(&mut encoder, &view, load);
            let [width, height] = self.size_px;
            match frame.look.time_is_down {
                1 => pass.set_scissor_rect(0, fresh.start, width, fresh.len() as u32),
                _ => pass.set_scissor_rect(fresh.start, 0, fresh.len() as u32, height),
            }
            let tiles = frame.tiles.iter().map(|(_, tile)| tile);
            renderer.paint(&mut pass, &frame.tables, tiles);
        }
        queue.submit([encoder.finish()]);
        std::mem::swap(&mut self.front, &mut self.back);
        // What was copied lies on whole pixels of where it was drawn.
        let start_px = match (&self.drawn, stays) {
            (Some(drawn), Some((moved_px, _))) => drawn.start_px + moved_px as f64,
            _ => frame.start_px,
        };
        self.drawn = Some(WaterfallFrame { start_px, ..frame });
        true
    }

    /// Copies pixels from where they were to where they are now.
    fn copy(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        moved_px: i64,
        kept: Range<u32>,
        time_is_down: bool,
    ) {
        let [width, height] = self.size_px;
        let place = |along: i64| match time_is_down {
            true => wgpu::Origin3d {
                x: 0,
                y: along as u32,
                z: 0,
            },
            false => wgpu::Origin3d {
                x: along as u32,
                y: 0,
                z: 0,
            },
        };
        let (width, height) = match time_is_down {
            true => (width, kept.len() as u32),
            false => (kept.len() as u32, height),
        };
        let of = |texture, along| wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: place(along),
            aspect: wgpu::TextureAspect::All,
        };
        let start = i64::from(kept.start);
        encoder.copy_texture_to_texture(
            of(&self.front, start + moved_px),
            of(&self.back, start),
            wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
        );
    }
}

/// By how many pixels a picture has moved, and the pixels along the track that have to be drawn; `None` where all have to be.
fn stays(
    drawn: &WaterfallFrame,
    next: &WaterfallFrame,
    length_px: u32,
) -> Option<(i64, Range<u32>)> {
    if drawn.look != next.look || drawn.tables != next.tables || drawn.scales != next.scales {
        return None;
    }
    let by_px = next.start_px - drawn.start_px;
    let moved_px = by_px.round();
    if (by_px - moved_px).abs() > MOST_OFF_PX || moved_px.abs() >= f64::from(length_px) {
        return None;
    }
    let moved_px = moved_px as i64;
    let is_new = |tile: &TileTexture| drawn.tiles.iter().all(|(_, known)| known != tile);
    let new = next.tiles.iter().filter(|(_, tile)| is_new(tile));
    let new = new.map(|(quad, _)| next.along_px(quad, length_px));
    let all = new.fold(exposed(moved_px, length_px), |all, one| {
        match all.is_empty() {
            true => one,
            false => all.start.min(one.start)..all.end.max(one.end),
        }
    });
    Some((moved_px, all))
}

/// The pixels along the track that come into view.
fn exposed(moved_px: i64, length_px: u32) -> Range<u32> {
    let count = moved_px.unsigned_abs() as u32;
    match moved_px > 0 {
        true => length_px - count..length_px,
        false => 0..count,
    }
}

/// The pixels that are copied: those that were in view, but for those that are drawn.
fn kept(moved_px: i64, fresh: &Range<u32>, length_px: u32) -> impl Iterator<Item = Range<u32>> {
    let count = moved_px.unsigned_abs() as u32;
    let seen = match moved_px > 0 {
        true => 0..length_px - count,
        false => count..length_px,
    };
    let before = seen.start..seen.end.min(fresh.start.max(seen.start));
    let after = seen.start.max(fresh.end.min(seen.end))..seen.end;
    let parts = match fresh.is_empty() {
        true => [seen, 0..0],
        false => [before, after],
    };
    parts.into_iter().filter(|part| !part.is_empty())
}

fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("scrolled waterfall"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load,
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    })
}

fn texture(device: &wgpu::Device, [width, height]: [u32; 2]) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("scrolled waterfall"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_copied_or_drawn_once() {
        for moved_px in [-7, -1, 0, 1, 4] {
            let exposed = exposed(moved_px, 10);
            for fresh in [exposed.clone(), 0..10, 3..10, 0..8] {
                let hull = match exposed.is_empty() {
                    true => fresh,
                    false => fresh.start.min(exposed.start)..fresh.end.max(exposed.end),
                };
                let mut times = [0; 10];
                for part in kept(moved_px, &hull, 10).chain([hull.clone()]) {
                    part.clone().for_each(|pixel| times[pixel as usize] += 1);
                    let from = i64::from(part.start) + moved_px;
                    assert!(
                        part == hull || (0..10).contains(&from),
                        "{moved_px} {hull:?}"
                    );
                }
                assert_eq!(times, [1; 10], "{moved_px} {hull:?}");
            }
        }
    }
}
