//! Draws waterfall tiles: one quad each, coloured in the shader, so that colours and gain cost a uniform write.

use bytemuck::{Pod, Zeroable};

/// Tiles in one picture at most: 4K at the worst zoom needs 160.
pub(crate) const MAX_QUADS: usize = 512;

/// Texels in a row of the table of pings. Same as in the shader.
const PING_TEXELS: u32 = 2048;
/// Places of a curve in the table of curves. Same as in the shader.
const CURVE_PLACES: usize = 64;

/// How echo strength becomes colour. Same layout as `EchoStyle` in `shaders/waterfall.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct EchoStyle {
    /// Exponent is 1 / gamma.
    pub gamma: f32,
    /// Share of the maximum in what is shown; the rest is the mean.
    pub highlight: f32,
    /// Intensity shown as 0, after gain and before gamma.
    pub black: f32,
    /// Intensity shown as 1; above `black`.
    pub white: f32,
    /// 1 where pings run down the screen.
    pub time_is_down: u32,
    /// 1 where the target converts to sRGB on writing; set by [`WaterfallPicture::prepare`].
    pub linear_target: u32,
    /// What lies across: 0 recorded slant range, 1 slant range beyond the altitude, 2 distance on the ground.
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
    /// Nothing.
    pub padding: f32,
}

/// Where a tile, or the part of it in view, lies. Same layout as `Quad` in the shader.
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
    /// Recorded slant range where column 0 begins, and what a column covers, metres.
    pub column_m: [f32; 2],
    /// Pair of texels of row 0 in the table of pings, how many follow of its reduction, itself included, and the side: 0 port,
    /// 1 starboard.
    pub pair: [u32; 3],
}

/// Gain curves of both sides, each by range (48 bins) and by angle (45 bins).
pub(crate) type Curves<'a> = [&'a [f32]; 4];

/// What tiles are brought to one level by, on the GPU. Clones share it.
#[derive(Clone, Debug)]
pub(crate) struct Tables {
    bind_group: wgpu::BindGroup,
}

/// A tile on the GPU. Clones share it.
#[derive(Clone, Debug)]
pub(crate) struct TileTexture {
    bind_group: wgpu::BindGroup,
}

/// Pipeline and buffers of one waterfall.
#[derive(Debug)]
pub(crate) struct WaterfallPicture {
    pipeline: wgpu::RenderPipeline,
    tile_layout: wgpu::BindGroupLayout,
    frame_layout: wgpu::BindGroupLayout,
    look: wgpu::Buffer,
    quads: wgpu::Buffer,
    palette: wgpu::Buffer,
    linear_target: bool,
}

impl WaterfallPicture {
    /// Builds everything for targets of this format.
    pub(crate) fn new(device: &wgpu::Device, target: wgpu::TextureFormat) -> Self {
        let frame_layout = frame_layout(device);
        let tile_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("waterfall tile"),
            entries: &[texture_entry(0)],
        });
        let look = buffer(
            device,
            "waterfall look",
            size_of::<EchoStyle>(),
            wgpu::BufferUsages::UNIFORM,
        );
        let bytes = MAX_QUADS * size_of::<Quad>();
        let quads = buffer(device, "waterfall quads", bytes, wgpu::BufferUsages::VERTEX);
        let uniform = wgpu::BufferUsages::UNIFORM;
        let palette = buffer(device, "waterfall palette", 256 * 4, uniform);
        Self {
            pipeline: pipeline(device, &[Some(&frame_layout), Some(&tile_layout)], target),
            tile_layout,
            frame_layout,
            look,
            quads,
            palette,
            linear_target: target.is_srgb(),
        }
    }

    /// Replaces the colours.
    pub(crate) fn set_palette(&self, queue: &wgpu::Queue, palette: &[[u8; 3]; 256]) {
        let rgba: Vec<[u8; 4]> = palette.iter().map(|&[r, g, b]| [r, g, b, 255]).collect();
        queue.write_buffer(&self.palette, 0, bytemuck::cast_slice(&rgba));
    }

    /// Puts scales and factors of all pings on the GPU, four numbers for each side of each ping, and the gain curves. What does not fit
    /// is left out, as `false` says.
    pub(crate) fn upload_tables(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        pings: &[[f32; 4]],
        curves: Curves<'_>,
    ) -> (Tables, bool) {
        let most = device.limits().max_texture_dimension_2d.min(8192);
        let width = PING_TEXELS.min(most);
        let fits = width == PING_TEXELS && pings.len() as u64 <= u64::from(width) * u64::from(most);
        let mut texels = match fits {
            true => pings.to_vec(),
            false => Vec::new(),
        };
        let rows = texels.len().div_ceil(width as usize).max(1) as u32;
        texels.resize((width * rows) as usize, [0.0, 1.0, 0.0, 1.0]);
        let size = [width, rows];
        let pings = texture(device, size, wgpu::TextureFormat::Rgba32Float);
        write(queue, &pings, size, bytemuck::cast_slice(&texels));
        let mut values = [[1.0_f32; CURVE_PLACES]; 4];
        for (row, curve) in values.iter_mut().zip(curves) {
            for (value, known) in row.iter_mut().zip(curve) {
                *value = *known;
            }
        }
        let uniform = wgpu::BufferUsages::UNIFORM;
        let curves = buffer(device, "waterfall curves", size_of_val(&values), uniform);
        queue.write_buffer(&curves, 0, bytemuck::cast_slice(&values));
        let pings = pings.create_view(&Default::default());
        let entry = |binding: u32, resource| wgpu::BindGroupEntry { binding, resource };
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("waterfall frame"),
            layout: &self.frame_layout,
            entries: &[
                entry(0, self.look.as_entire_binding()),
                entry(1, self.palette.as_entire_binding()),
                entry(2, wgpu::BindingResource::TextureView(&pings)),
                entry(3, curves.as_entire_binding()),
            ],
        });
        (Tables { bind_group }, fits)
    }

    /// Puts a tile on the GPU: `[mean, max]` texels, row by row.
    pub(crate) fn upload(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        size: [u32; 2],
        texels: &[[u8; 2]],
    ) -> TileTexture {
        let texture = texture(device, size, wgpu::TextureFormat::Rg8Unorm);
        write(queue, &texture, size, bytemuck::cast_slice(texels));
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("waterfall tile"),
            layout: &self.tile_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(
                    &texture.create_view(&Default::default()),
                ),
            }],
        });
        TileTexture { bind_group }
    }

    /// Writes what the next [`WaterfallPicture::paint`] draws; beyond [`MAX_QUADS`] tiles nothing is drawn.
    pub(crate) fn prepare<'a>(
        &self,
        queue: &wgpu::Queue,
        look: EchoStyle,
        quads: impl Iterator<Item = &'a Quad>,
    ) {
        let linear_target = u32::from(self.linear_target);
        let look = EchoStyle {
            linear_target,
            ..look
        };
        queue.write_buffer(&self.look, 0, bytemuck::bytes_of(&look));
        let quads: Vec<Quad> = quads.take(MAX_QUADS).copied().collect();
        queue.write_buffer(&self.quads, 0, bytemuck::cast_slice(&quads));
    }

    /// Draws the tiles in the order of the quads that were prepared.
    pub(crate) fn paint<'a>(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        tables: &Tables,
        tiles: impl Iterator<Item = &'a TileTexture>,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &tables.bind_group, &[]);
        let stride = size_of::<Quad>() as u64;
        for (index, tile) in tiles.take(MAX_QUADS).enumerate() {
            // A slice instead of a first instance: OpenGL without base instances draws it too.
            let start = index as u64 * stride;
            pass.set_vertex_buffer(0, self.quads.slice(start..start + stride));
            pass.set_bind_group(1, &tile.bind_group, &[]);
            pass.draw(0..4, 0..1);
        }
    }
}

fn frame_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let uniform = |binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("waterfall frame"),
        // Arrays in a buffer are read several times faster than textures by a driver without a graphics card.
        entries: &[uniform(0), uniform(1), texture_entry(2), uniform(3)],
    })
}

fn texture_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
}

fn buffer(
    device: &wgpu::Device,
    label: &str,
    bytes: usize,
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes as u64,
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn texture(device: &wgpu::Device, size: [u32; 2], format: wgpu::TextureFormat) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("waterfall"),
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

fn extent([width, height]: [u32; 2]) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    }
}

fn write(queue: &wgpu::Queue, texture: &wgpu::Texture, size: [u32; 2], bytes: &[u8]) {
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(bytes.len() as u32 / size[1].max(1)),
        rows_per_image: None,
    };
    queue.write_texture(texture.as_image_copy(), bytes, layout, extent(size));
}

fn pipeline(
    device: &wgpu::Device,
    layouts: &[Option<&wgpu::BindGroupLayout>],
    target: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let module =
        device.create_shader_module(wgpu::include_wgsl!("../../../shaders/waterfall.wgsl"));
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("waterfall"),
        bind_group_layouts: layouts,
        immediate_size: 0,
    });
    let quad = wgpu::VertexBufferLayout {
        array_stride: size_of::<Quad>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![
            0 => Float32x2, 1 => Float32x2, 2 => Float32x2, 3 => Float32x2, 4 => Float32x2,
            5 => Float32x2, 6 => Float32x2, 7 => Uint32x3
        ],
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("waterfall"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs_main"),
            compilation_options: Default::default(),
            buffers: &[Some(quad)],
        },
        primitive: wgpu::PrimitiveState {
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            ..Default::default()
        },
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fs_main"),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: target,
                blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;
    use wgpu::naga::{TypeInner, front::wgsl};

    #[test]
    fn look_is_laid_out_as_in_the_shader() {
        let source = include_str!("../../../shaders/waterfall.wgsl");
        let module = wgsl::parse_str(source).expect("the shader parses");
        let look = module
            .types
            .iter()
            .find(|(_, kind)| kind.name.as_deref() == Some("EchoStyle"))
            .map(|(_, kind)| &kind.inner);
        let Some(TypeInner::Struct { members, span }) = look else {
            panic!("the shader has no struct EchoStyle");
        };
        let offsets: Vec<usize> = members
            .iter()
            .map(|member| member.offset as usize)
            .collect();
        let expected = [
            offset_of!(EchoStyle, gamma),
            offset_of!(EchoStyle, highlight),
            offset_of!(EchoStyle, black),
            offset_of!(EchoStyle, white),
            offset_of!(EchoStyle, time_is_down),
            offset_of!(EchoStyle, linear_target),
            offset_of!(EchoStyle, geometry),
            offset_of!(EchoStyle, filters),
            offset_of!(EchoStyle, spreading),
            offset_of!(EchoStyle, absorption),
            offset_of!(EchoStyle, middle_m),
            offset_of!(EchoStyle, port),
            offset_of!(EchoStyle, starboard),
            offset_of!(EchoStyle, curve_far_m),
            offset_of!(EchoStyle, curve_factor),
            offset_of!(EchoStyle, padding),
        ];
        assert_eq!(offsets, expected);
        assert_eq!(*span as usize, size_of::<EchoStyle>());
    }
}
