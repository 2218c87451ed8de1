//! The graphics card itself: what runs a [`Program`].

use super::program::{Kernel, Numbers, Other, Place, Program, Step};
use crate::support::block_on::block_on;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use wgpu::{Adapter, AdapterInfo, BufferUsages, DeviceType};

/// How long one picture may take before the card is given up.
const PATIENCE: Duration = Duration::from_secs(10);
const SHADER: &str = include_str!("../../../../shaders/network.wgsl");

/// A card that is open.
pub(super) struct Card {
    device: wgpu::Device,
    queue: wgpu::Queue,
    layout: wgpu::BindGroupLayout,
    pipelines: [wgpu::ComputePipeline; Kernel::ALL.len()],
    /// What it said was wrong.
    fault: Arc<Mutex<Option<String>>>,
    name: String,
}

impl Card {
    /// The first of the computer's adapters that is wanted and opens, one with memory of its own before others.
    pub(super) fn open(is_wanted: impl Fn(&AdapterInfo) -> bool) -> Option<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let mut adapters = block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
        adapters.retain(|adapter| is_wanted(&adapter.get_info()));
        adapters.sort_by_key(|adapter| adapter.get_info().device_type != DeviceType::DiscreteGpu);
        adapters.iter().find_map(Self::of)
    }

    /// Whether the computer may have a card. Where Linux shows none, drivers that draw in software are all there is to load: 100 MB.
    pub(super) fn may_be_there() -> bool {
        const SHOWN: [&str; 3] = ["/dev/dri", "/dev/nvidiactl", "/dev/dxg"];
        !cfg!(target_os = "linux") || SHOWN.iter().any(|path| Path::new(path).exists())
    }

    /// Whether an adapter is more than a driver that runs on the processor.
    pub(super) fn is_hardware(info: &AdapterInfo) -> bool {
        info.device_type != DeviceType::Cpu
    }

    fn of(adapter: &Adapter) -> Option<Self> {
        let request = block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()));
        let (device, queue) = request.ok()?;
        let fault = Arc::new(Mutex::new(None));
        let said = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let mut said = said.lock().unwrap_or_else(PoisonError::into_inner);
            said.get_or_insert_with(|| error.to_string());
        }));
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("layer"),
            entries: &[0, 1, 2, 3, 4].map(entry),
        });
        let pipelines = pipelines(&device, &layout);
        let info = adapter.get_info();
        Some(Self {
            device,
            queue,
            layout,
            pipelines,
            fault,
            name: format!("{} ({})", info.name, info.backend),
        })
    }

    /// Its name and by what it is driven.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    fn check(&self) -> Result<(), String> {
        let fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        fault.clone().map_or(Ok(()), Err)
    }

    fn buffer(&self, numbers: usize, usage: BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes(numbers),
            usage: usage | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// A buffer that holds this.
    fn filled<T: bytemuck::Pod>(&self, numbers: &[T], usage: BufferUsages) -> wgpu::Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(numbers);
        let buffer = self.buffer(bytes.len() / 4, usage);
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }
}

/// Bytes of numbers of four bytes.
fn bytes(numbers: usize) -> u64 {
    4 * numbers as u64
}

/// The uniform block, two inputs, the output, and what lies under a window.
fn entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    let ty = match binding {
        0 => wgpu::BufferBindingType::Uniform,
        of => wgpu::BufferBindingType::Storage { read_only: of != 3 },
    };
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

fn pipelines(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
) -> [wgpu::ComputePipeline; Kernel::ALL.len()] {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("network"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("network"),
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    Kernel::ALL.map(|(_, entry)| {
        device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            cache: None,
        })
    })
}

/// A step with all that it is bound to.
enum Bound {
    Compute {
        pipeline: usize,
        group: wgpu::BindGroup,
        groups: [u32; 2],
    },
    Copy {
        input: Place,
        into: usize,
        at: usize,
    },
}

/// A program on a card, for several pictures at once: while one is computed, others are on their way there and back.
pub(super) struct Runner {
    card: Arc<Card>,
    buffers: Vec<wgpu::Buffer>,
    steps: Vec<Bound>,
    outputs: Vec<Place>,
    /// Locked while a picture is handed over: its numbers are written before they are computed, and before the next one's.
    handover: Mutex<()>,
    /// What outputs are read from, those that no picture uses.
    free: Mutex<Vec<wgpu::Buffer>>,
}

impl Runner {
    /// Puts the program and its weights on the card.
    ///
    /// # Errors
    /// What the card says is wrong.
    pub(super) fn new(card: Arc<Card>, program: &Program) -> Result<Self, String> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let buffers: Vec<wgpu::Buffer> = program
            .buffers
            .iter()
            .map(|numbers| card.buffer(*numbers, usage))
            .collect();
        let nothing = card.buffer(2, usage);
        let steps = program
            .steps
            .iter()
            .map(|step| bound(&card, &buffers, &nothing, step))
            .collect();
        card.check()?;
        Ok(Self {
            card,
            buffers,
            steps,
            outputs: program.outputs.clone(),
            handover: Mutex::default(),
            free: Mutex::default(),
        })
    }

    pub(super) fn card(&self) -> &Card {
        &self.card
    }

    fn free(&self) -> MutexGuard<'_, Vec<wgpu::Buffer>> {
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The outputs of one picture, in the order of the program's.
    ///
    /// # Errors
    /// What the card says is wrong.
    pub(super) fn run(&self, input: &[f32]) -> Result<Vec<Vec<f32>>, String> {
        let numbers = self.outputs.iter().map(|place| place.count).sum();
        let free = self.free().pop();
        let read_back = free.unwrap_or_else(|| self.card.buffer(numbers, BufferUsages::MAP_READ));
        self.compute(input, &read_back)?;
        let outputs = self.read(&read_back)?;
        self.free().push(read_back);
        Ok(outputs)
    }

    /// Computes a picture and maps its outputs.
    fn compute(&self, input: &[f32], read_back: &wgpu::Buffer) -> Result<(), String> {
        let Card { device, queue, .. } = &*self.card;
        let commands = self.commands(read_back);
        let submitted = {
            let handover = self.handover.lock();
            let _handover = handover.unwrap_or_else(PoisonError::into_inner);
            queue.write_buffer(&self.buffers[0], 0, bytemuck::cast_slice(input));
            queue.submit([commands])
        };
        let (sender, mapped) = std::sync::mpsc::channel();
        read_back.map_async(wgpu::MapMode::Read, .., move |result| {
            sender.send(result).ok();
        });
        let wait = wgpu::PollType::Wait {
            submission_index: Some(submitted),
            timeout: Some(PATIENCE),
        };
        device.poll(wait).map_err(|error| error.to_string())?;
        // The poll of another picture's thread may be about to send it.
        let result = mapped.recv_timeout(PATIENCE);
        self.card.check()?;
        match result {
            Ok(result) => result.map_err(|error| error.to_string()),
            Err(_) => Err("it does not answer".to_owned()),
        }
    }

    /// All steps, and the way of the outputs into a buffer.
    fn commands(&self, read_back: &wgpu::Buffer) -> wgpu::CommandBuffer {
        let mut encoder = self.card.device.create_command_encoder(&Default::default());
        for steps in self
            .steps
            .chunk_by(|one, other| one.is_computed() && other.is_computed())
        {
            self.encode(steps, &mut encoder);
        }
        let mut at = 0;
        for place in &self.outputs {
            let from = &self.buffers[place.buffer];
            encoder.copy_buffer_to_buffer(
                from,
                bytes(place.first),
                read_back,
                bytes(at),
                bytes(place.count),
            );
            at += place.count;
        }
        encoder.finish()
    }

    /// The outputs in a buffer that is mapped, and is so no more.
    fn read(&self, read_back: &wgpu::Buffer) -> Result<Vec<Vec<f32>>, String> {
        let outputs = {
            let view = read_back
                .get_mapped_range(..)
                .map_err(|error| error.to_string())?;
            let mut numbers: &[f32] =
                bytemuck::try_cast_slice(&view).map_err(|error| error.to_string())?;
            let mut outputs = Vec::with_capacity(self.outputs.len());
            for place in &self.outputs {
                let (these, others) = numbers.split_at(place.count);
                outputs.push(these.to_vec());
                numbers = others;
            }
            outputs
        };
        read_back.unmap();
        Ok(outputs)
    }

    /// Steps that are all computed, or one that copies.
    fn encode(&self, steps: &[Bound], encoder: &mut wgpu::CommandEncoder) {
        if let [Bound::Copy { input, into, at }] = steps {
            let [from, to] = [input.buffer, *into].map(|buffer| &self.buffers[buffer]);
            encoder.copy_buffer_to_buffer(
                from,
                bytes(input.first),
                to,
                bytes(*at),
                bytes(input.count),
            );
            return;
        }
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for step in steps {
            if let Bound::Compute {
                pipeline,
                group,
                groups,
            } = step
            {
                pass.set_pipeline(&self.card.pipelines[*pipeline]);
                pass.set_bind_group(0, group, &[]);
                pass.dispatch_workgroups(groups[0], groups[1], 1);
            }
        }
    }
}

impl Bound {
    fn is_computed(&self) -> bool {
        matches!(self, Bound::Compute { .. })
    }
}

fn bound(card: &Card, buffers: &[wgpu::Buffer], nothing: &wgpu::Buffer, step: &Step) -> Bound {
    let (kernel, input, other, into, numbers) = match step {
        &Step::Copy { input, into, at } => return Bound::Copy { input, into, at },
        Step::Compute {
            kernel,
            input,
            other,
            into,
            numbers,
        } => (*kernel, *input, other, *into, *numbers),
    };
    let constants;
    let (other, under) = match other {
        Other::Nothing => (nothing, nothing),
        Other::Place(place) => (&buffers[place.buffer], nothing),
        Other::Weights(weights) => {
            constants = (
                card.filled(&weights.numbers, BufferUsages::STORAGE),
                card.filled(&weights.under, BufferUsages::STORAGE),
            );
            (&constants.0, &constants.1)
        }
    };
    let uniform = card.filled::<Numbers>(&[numbers], BufferUsages::UNIFORM);
    let resources = [
        &uniform,
        &buffers[input.buffer],
        other,
        &buffers[into],
        under,
    ];
    let mut binding = 0;
    let entries = resources.map(|buffer| {
        binding += 1;
        wgpu::BindGroupEntry {
            binding: binding - 1,
            resource: buffer.as_entire_binding(),
        }
    });
    Bound::Compute {
        pipeline: kernel as usize,
        group: card.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &card.layout,
            entries: &entries,
        }),
        groups: kernel.groups(&numbers),
    }
}
