//! Draws waterfall tiles, one quad each. The shader colours them, so that a change of colours or
//! gain needs only a uniform write.

use super::pipeline::{
    PipelineParts, bind_group, bind_group_layout, buffer, extent, pipeline, plain_texture,
    texture_entry, uniform_entry,
};
use bytemuck::{Pod, Zeroable};

/// Largest number of tiles in one picture: 4K at the worst zoom needs 160.
pub(crate) const MAX_QUADS: usize = 512;

/// Largest number of rows of a tile. Same as in the shader.
pub(crate) const TILE_ROWS: usize = 512;
/// Values of a curve in the table of curves. Same as in the shader.
const CURVE_PLACES: usize = 64;

/// Conversion of echo strength into colour. Same layout as `EchoStyle` in `shaders/waterfall.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct EchoStyle {
    /// Gamma; the exponent is 1 / gamma.
    pub gamma: f32,
    /// Share of the maximum in the shown value; the rest is the mean.
    pub highlight: f32,
    /// Intensity shown as 0, after gain and before gamma.
    pub black: f32,
    /// Intensity shown as 1; above `black`.
    pub white: f32,
    /// 1 where pings run down the screen.
    pub time_is_down: u32,
    /// 1 where the target converts to sRGB on writing; set by [`WaterfallPicture::prepare`].
    pub linear_target: u32,
    /// Geometry of the across direction: 0 recorded slant range, 1 slant range beyond the altitude,
    /// 2 distance on the bottom.
    pub geometry: u32,
    /// Sum of 1 for the gain curves, 2 for the stripe factors, 4 for the median of 3 x 3.
    pub filters: u32,
    /// Time-varied gain, dB for each decade of slant range.
    pub spreading: f32,
    /// Time-varied gain, dB for each metre, there and back.
    pub absorption: f32,
    /// Slant range of 0 dB, metres.
    pub middle_m: f32,
    /// Factor of port.
    pub port: f32,
    /// Factor of starboard.
    pub starboard: f32,
    /// Slant range where the gain curves by range end, metres.
    pub curve_far_m: f32,
    /// Factor on the product of the curves.
    pub curve_factor: f32,
    /// Unused; fills the block.
    pub padding: f32,
}

/// Place of a tile, or of its visible part. Same layout as `Quad` in the shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Quad {
    /// Edges in the direction of time, clip space.
    pub along: [f32; 2],
    /// Edges in the direction of range, near to far, clip space.
    pub across: [f32; 2],
    /// Tile rows at the edges along.
    pub rows: [f32; 2],
    /// Tile columns at the edges across.
    pub columns: [f32; 2],
    /// Columns and rows that a pixel covers.
    pub footprint: [f32; 2],
    /// Metres from the middle at the edges across.
    pub across_m: [f32; 2],
    /// Recorded slant range where column 0 begins, and slant range that a column covers, metres.
    pub column_m: [f32; 2],
    /// Side: 0 port, 1 starboard.
    pub side: u32,
}

/// Gain curves of both sides, each by range (48 bins) and by angle (45 bins).
pub(crate) type GainCurves<'a> = [&'a [f32]; 4];

/// Values that bring a row of a tile to the common level: `[altitude, scale, offset, factor of the
/// stripe filter]`.
pub type TileRow = [f32; 4];

/// The gain curves that bring tiles to one level, on the GPU. Clones share the data.
pub(crate) type GainBuffer = wgpu::BindGroup;

/// A tile on the GPU. Clones share the data.
pub(crate) type TileTexture = wgpu::BindGroup;

/// Values of [`TileRow`] for the rows of a tile, on the GPU. Clones share them.
pub(crate) type TileRows = wgpu::BindGroup;

/// A tile and its rows, both on the GPU.
#[derive(Clone, Debug)]
pub(crate) struct DrawnTile {
    pub texture: TileTexture,
    pub rows: TileRows,
}

/// Pipeline and buffers of one waterfall.
#[derive(Debug)]
pub(crate) struct WaterfallPicture {
    pipeline: wgpu::RenderPipeline,
    tile_layout: wgpu::BindGroupLayout,
    rows_layout: wgpu::BindGroupLayout,
    frame_layout: wgpu::BindGroupLayout,
    look: wgpu::Buffer,
    quads: wgpu::Buffer,
    palette: wgpu::Buffer,
    linear_target: bool,
}

impl WaterfallPicture {
    /// Builds the pipeline and the buffers for targets of this format.
    pub(crate) fn new(device: &wgpu::Device, target: wgpu::TextureFormat) -> Self {
        // Arrays in a buffer are read several times faster than textures by a driver without a
        // graphics card.
        let frame = [0, 1, 2].map(uniform_entry);
        let frame_layout = bind_group_layout(device, &frame);
        let tile_layout = bind_group_layout(device, &[texture_entry(0)]);
        let rows_layout = bind_group_layout(device, &[uniform_entry(0)]);
        let uniform = wgpu::BufferUsages::UNIFORM;
        let quads = MAX_QUADS * size_of::<Quad>();
        let parts = PipelineParts {
            label: "waterfall",
            shader: include_str!("../../../shaders/waterfall.wgsl"),
            entries: ["vs_main", "fs_main"],
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Quad>() as u64,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes: &wgpu::vertex_attr_array![
                    0 => Float32x2, 1 => Float32x2, 2 => Float32x2, 3 => Float32x2, 4 => Float32x2,
                    5 => Float32x2, 6 => Float32x2, 7 => Uint32
                ],
            })],
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        };
        let layouts = [&frame_layout, &tile_layout, &rows_layout].map(Some);
        Self {
            pipeline: pipeline(device, &layouts, parts, target, None),
            tile_layout,
            rows_layout,
            frame_layout,
            look: buffer(device, size_of::<EchoStyle>(), uniform),
            quads: buffer(device, quads, wgpu::BufferUsages::VERTEX),
            palette: buffer(device, 256 * 4, uniform),
            linear_target: target.is_srgb(),
        }
    }

    /// Replaces the colours of the palette.
    pub(crate) fn set_palette(&self, queue: &wgpu::Queue, palette: &[[u8; 3]; 256]) {
        let rgba: Vec<[u8; 4]> = palette.iter().map(|&[r, g, b]| [r, g, b, 255]).collect();
        queue.write_buffer(&self.palette, 0, bytemuck::cast_slice(&rgba));
    }

    /// Puts the gain curves on the GPU.
    pub(crate) fn upload_gain(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        curves: GainCurves<'_>,
    ) -> GainBuffer {
        let mut values = [[1.0_f32; CURVE_PLACES]; 4];
        for (row, curve) in values.iter_mut().zip(curves) {
            for (value, known) in row.iter_mut().zip(curve) {
                *value = *known;
            }
        }
        let curves = filled(device, queue, bytemuck::cast_slice(&values));
        let resources = [&self.look, &self.palette, &curves].map(wgpu::Buffer::as_entire_binding);
        bind_group(device, &self.frame_layout, &resources)
    }

    /// Puts on the GPU the values that bring the rows of a tile to one level.
    pub(crate) fn upload_rows(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        rows: &[TileRow; TILE_ROWS],
    ) -> TileRows {
        let rows = filled(device, queue, bytemuck::cast_slice(rows));
        bind_group(device, &self.rows_layout, &[rows.as_entire_binding()])
    }

    /// Puts a tile on the GPU: `[mean, max]` texels, row by row.
    pub(crate) fn upload(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        size: [u32; 2],
        texels: &[[u8; 2]],
    ) -> TileTexture {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = plain_texture(device, size, wgpu::TextureFormat::Rg8Unorm, usage, &[]);
        let bytes: &[u8] = bytemuck::cast_slice(texels);
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(bytes.len() as u32 / size[1].max(1)),
            rows_per_image: None,
        };
        queue.write_texture(texture.as_image_copy(), bytes, layout, extent(size));
        let view = texture.create_view(&Default::default());
        let tile = wgpu::BindingResource::TextureView(&view);
        bind_group(device, &self.tile_layout, &[tile])
    }

    /// Writes the style and the quads that the next [`WaterfallPicture::paint`] draws; tiles beyond
    /// the first [`MAX_QUADS`] are not drawn.
    pub(crate) fn prepare<'a>(
        &self,
        queue: &wgpu::Queue,
        look: EchoStyle,
        quads: impl Iterator<Item = &'a Quad>,
    ) {
        let linear_target = u32::from(self.linear_target);
        let look = EchoStyle { linear_target, ..look };
        queue.write_buffer(&self.look, 0, bytemuck::bytes_of(&look));
        let quads: Vec<Quad> = quads.take(MAX_QUADS).copied().collect();
        queue.write_buffer(&self.quads, 0, bytemuck::cast_slice(&quads));
    }

    /// Draws the tiles in the order of the quads that were prepared.
    pub(crate) fn paint<'a>(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        gain: &GainBuffer,
        tiles: impl Iterator<Item = &'a DrawnTile>,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, gain, &[]);
        let stride = size_of::<Quad>() as u64;
        for (index, tile) in tiles.take(MAX_QUADS).enumerate() {
            // A slice instead of a first instance: OpenGL without base instances draws it too.
            let start = index as u64 * stride;
            pass.set_vertex_buffer(0, self.quads.slice(start..start + stride));
            pass.set_bind_group(1, &tile.texture, &[]);
            pass.set_bind_group(2, &tile.rows, &[]);
            pass.draw(0..4, 0..1);
        }
    }
}

/// Creates a uniform block of these bytes.
fn filled(device: &wgpu::Device, queue: &wgpu::Queue, bytes: &[u8]) -> wgpu::Buffer {
    let filled = buffer(device, bytes.len(), wgpu::BufferUsages::UNIFORM);
    queue.write_buffer(&filled, 0, bytes);
    filled
}

#[cfg(test)]
mod tests {
    use super::super::pipeline::tests::assert_laid_out;
    use super::*;

    #[test]
    fn look_is_laid_out_as_in_the_shader() {
        assert_laid_out!(
            "waterfall.wgsl",
            "EchoStyle",
            EchoStyle {
                gamma,
                highlight,
                black,
                white,
                time_is_down,
                linear_target,
                geometry,
                filters,
                spreading,
                absorption,
                middle_m,
                port,
                starboard,
                curve_far_m,
                curve_factor,
                padding
            }
        );
    }
}
