//! Fills buffers on the GPU a piece at a time, so that nothing needs all vertices in memory at
//! once.

use bytemuck::Pod;

/// Bytes on their way at once. The graphics library holds a copy of what it is given until the GPU
/// has it.
const PIECE: usize = 1 << 20;

/// A device and the queue that fills its buffers. Can be used from a worker.
#[derive(Clone)]
pub struct Uploader {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Uploader {
    /// Uploads to this device.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self { device: device.clone(), queue: queue.clone() }
    }

    /// A buffer with the first `count` of the vertices, or of numbers of vertices. Those that are
    /// missing are zeros.
    pub(super) fn buffer<T: Pod>(
        &self,
        label: &str,
        usage: wgpu::BufferUsages,
        count: usize,
        vertices: impl Iterator<Item = T>,
    ) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: (count * size_of::<T>()) as u64,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut vertices = vertices.take(count);
        let mut piece = Vec::with_capacity(count.min(PIECE / size_of::<T>()));
        let mut offset = 0;
        loop {
            piece.clear();
            piece.extend(vertices.by_ref().take(piece.capacity()));
            if piece.is_empty() {
                return buffer;
            }
            let bytes = bytemuck::cast_slice(&piece);
            self.queue.write_buffer(&buffer, offset, bytes);
            // Sends the piece on its way; without it all of them would wait for the next frame.
            self.queue.submit([]);
            offset += bytes.len() as u64;
        }
    }

    /// The size of the largest buffer that the device can hold, bytes.
    pub(super) fn most_bytes(&self) -> u64 {
        self.device.limits().max_buffer_size
    }
}
