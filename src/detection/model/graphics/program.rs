//! What a graphics card computes of a network: steps over buffers of numbers.

use super::convolution::{SIDE, Weights};
use bytemuck::{Pod, Zeroable};
use std::collections::{BTreeSet, HashMap};

/// Numbers of one buffer at most, 128 MiB: every device that has compute shaders binds as much.
const MOST_IN_BUFFER: usize = 1 << 25;
/// Numbers of all buffers at most, 1 GiB.
const MOST_IN_ALL: usize = 1 << 28;
/// Groups of a dispatch along one axis, at most.
const MOST_GROUPS: usize = 65535;
/// Numbers of the output that a group computes of a layer that is no convolution, once.
const GROUP: usize = 256;

/// Numbers that lie one after the other in a buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) buffer: usize,
    pub(super) first: usize,
    pub(super) count: usize,
}

/// What a step is over, as the shader has it (`Numbers` of `network.wgsl`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct Numbers {
    /// Channels, rows and columns.
    pub(super) input: [u32; 3],
    pub(super) output: [u32; 3],
    /// Rows and columns of the window; from one to the next; how far the first one begins before the picture.
    pub(super) window: [u32; 2],
    pub(super) step: [u32; 2],
    pub(super) before: [u32; 2],
    pub(super) first: u32,
    pub(super) first_other: u32,
    pub(super) function: u32,
    pub(super) slope: f32,
}

/// What becomes of each number, by its name in the shader.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Function {
    /// `slope` times a negative one.
    Leaky(f32),
    Sigmoid,
    /// The number times its sigmoid.
    Silu,
    /// Of two numbers.
    Sum,
    Product,
}

/// What a step computes: an entry of the shader.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kernel {
    Convolve,
    Pool,
    Enlarge,
    Apply,
    Combine,
}

impl Kernel {
    pub(super) const ALL: [(Kernel, &'static str); 5] = [
        (Kernel::Convolve, "convolve"),
        (Kernel::Pool, "pool"),
        (Kernel::Enlarge, "enlarge"),
        (Kernel::Apply, "apply"),
        (Kernel::Combine, "combine"),
    ];
}

/// The second input of a step.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Other {
    Nothing,
    Weights(Weights),
    Place(Place),
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    Compute {
        kernel: Kernel,
        input: Place,
        other: Other,
        into: usize,
        numbers: Numbers,
    },
    Copy {
        input: Place,
        into: usize,
        at: usize,
    },
}

/// Steps in their order, over buffers of so many numbers. Buffer 0 holds the input.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Program {
    pub(super) buffers: Vec<usize>,
    pub(super) steps: Vec<Step>,
    pub(super) outputs: Vec<Place>,
}

impl Program {
    /// A new buffer, as a place.
    pub(super) fn make(&mut self, count: usize) -> Place {
        self.buffers.push(count);
        Place {
            buffer: self.buffers.len() - 1,
            first: 0,
            count,
        }
    }

    /// Adds a step into a buffer of its own.
    pub(super) fn compute(
        &mut self,
        kernel: Kernel,
        input: Place,
        other: Other,
        numbers: Numbers,
    ) -> Place {
        let first_other = match &other {
            Other::Place(place) => place.first,
            _ => 0,
        };
        let numbers = Numbers {
            first: input.first as u32,
            first_other: first_other as u32,
            ..numbers
        };
        let into = self.make(numbers.count_out());
        self.steps.push(Step::Compute {
            kernel,
            input,
            other,
            into: into.buffer,
            numbers,
        });
        into
    }

    /// Adds a function to the step that has just computed a place; where there is none, as a step of its own.
    pub(super) fn apply(
        &mut self,
        input: Place,
        is_read_elsewhere: bool,
        function: Function,
    ) -> Place {
        if let (
            Some(Step::Compute {
                kernel: Kernel::Convolve,
                into,
                numbers,
                ..
            }),
            false,
        ) = (self.steps.last_mut(), is_read_elsewhere)
            && *into == input.buffer
            && numbers.function == 0
        {
            *numbers = numbers.with(function);
            return input;
        }
        let flat = [1, 1, input.count as u32];
        let numbers = Numbers {
            input: flat,
            output: flat,
            ..Numbers::default()
        };
        self.compute(Kernel::Apply, input, Other::Nothing, numbers.with(function))
    }

    /// Adds the sum of two places, or their product.
    pub(super) fn combine(&mut self, one: Place, other: Place, is_sum: bool) -> Place {
        let flat = [1, 1, one.count as u32];
        let numbers = Numbers {
            input: flat,
            output: flat,
            ..Numbers::default()
        };
        let function = if is_sum {
            Function::Sum
        } else {
            Function::Product
        };
        let other = Other::Place(other);
        self.compute(Kernel::Combine, one, other, numbers.with(function))
    }

    /// Puts places one after the other.
    pub(super) fn join(&mut self, places: &[Place]) -> Place {
        let joined = self.make(places.iter().map(|place| place.count).sum());
        let mut at = 0;
        for &input in places {
            self.steps.push(Step::Copy {
                input,
                into: joined.buffer,
                at,
            });
            at += input.count;
        }
        joined
    }

    /// Numbers of each buffer, those of weights too.
    fn sizes(&self) -> impl Iterator<Item = usize> {
        let weights = self.steps.iter().filter_map(|step| match step {
            Step::Compute {
                other: Other::Weights(weights),
                ..
            } => Some(weights.numbers.len()),
            _ => None,
        });
        self.buffers.iter().copied().chain(weights)
    }

    /// Whether every device has room for one more buffer of so many numbers.
    pub(super) fn has_room(&self, more: usize) -> bool {
        more <= MOST_IN_BUFFER && self.sizes().fold(more, usize::saturating_add) <= MOST_IN_ALL
    }

    /// Whether every device has room for it.
    pub(super) fn fits(&self) -> bool {
        let groups = self.steps.iter().all(|step| match step {
            Step::Compute {
                kernel, numbers, ..
            } => kernel
                .groups(numbers)
                .iter()
                .all(|&groups| groups as usize <= MOST_GROUPS),
            Step::Copy { .. } => true,
        });
        let fits = |count: usize| (1..=MOST_IN_BUFFER).contains(&count);
        groups && self.sizes().all(fits) && self.has_room(0)
    }

    /// The same with buffers that are used again once the last step that reads them is done.
    pub(super) fn packed(mut self) -> Self {
        let mut last_read = vec![0; self.buffers.len()];
        for (at, step) in self.steps.iter().enumerate() {
            for buffer in step.reads() {
                last_read[buffer] = at;
            }
        }
        for output in &self.outputs {
            last_read[output.buffer] = usize::MAX;
        }
        let mut packing = Packing {
            counts: self.buffers,
            lies_in: HashMap::new(),
            sizes: Vec::new(),
            free: BTreeSet::new(),
        };
        packing.place(0);
        for (at, step) in self.steps.iter_mut().enumerate() {
            let read: Vec<usize> = step.reads().collect();
            let into = step.written_mut();
            *into = packing.place(*into);
            step.move_reads(|buffer| packing.place(buffer));
            let done = read.into_iter().filter(|&buffer| last_read[buffer] == at);
            let done: Vec<usize> = done.map(|buffer| packing.place(buffer)).collect();
            packing.free.extend(done);
        }
        for output in &mut self.outputs {
            output.buffer = packing.place(output.buffer);
        }
        Self {
            buffers: packing.sizes,
            ..self
        }
    }
}

/// Which buffer of the card each buffer of a program lies in.
struct Packing {
    /// Numbers of the program's buffers.
    counts: Vec<usize>,
    lies_in: HashMap<usize, usize>,
    /// Numbers of the card's.
    sizes: Vec<usize>,
    /// Those of the card whose numbers nothing reads any more.
    free: BTreeSet<usize>,
}

impl Packing {
    /// Where a buffer lies: where it did, else in the least free one that is large enough, else in a new one.
    fn place(&mut self, buffer: usize) -> usize {
        if let Some(&there) = self.lies_in.get(&buffer) {
            return there;
        }
        let count = self.counts[buffer];
        let fitting = self.free.iter().filter(|&&at| self.sizes[at] >= count);
        let place = match fitting.copied().min_by_key(|&at| self.sizes[at]) {
            Some(at) => at,
            None => {
                self.sizes.push(count);
                self.sizes.len() - 1
            }
        };
        self.free.remove(&place);
        self.lies_in.insert(buffer, place);
        place
    }
}

impl Step {
    fn reads(&self) -> impl Iterator<Item = usize> + use<> {
        let (one, other) = match self {
            Step::Compute {
                input,
                other: Other::Place(other),
                ..
            } => (input.buffer, Some(other.buffer)),
            Step::Compute { input, .. } | Step::Copy { input, .. } => (input.buffer, None),
        };
        std::iter::once(one).chain(other)
    }

    fn written_mut(&mut self) -> &mut usize {
        match self {
            Step::Compute { into, .. } | Step::Copy { into, .. } => into,
        }
    }

    fn move_reads(&mut self, mut to: impl FnMut(usize) -> usize) {
        let (Step::Compute { input, .. } | Step::Copy { input, .. }) = self;
        input.buffer = to(input.buffer);
        if let Step::Compute {
            other: Other::Place(other),
            ..
        } = self
        {
            other.buffer = to(other.buffer);
        }
    }
}

impl Kernel {
    /// Groups that are dispatched.
    pub(super) fn groups(self, numbers: &Numbers) -> [u32; 2] {
        let [channels, height, width] = numbers.output;
        match self {
            Kernel::Convolve => [
                (height * width).div_ceil(SIDE as u32),
                channels.div_ceil(SIDE as u32),
            ],
            _ => [
                numbers.count_out().div_ceil(GROUP).min(MOST_GROUPS) as u32,
                1,
            ],
        }
    }
}

impl Numbers {
    fn count_out(&self) -> usize {
        self.output.iter().map(|side| *side as usize).product()
    }

    /// With a function, as the shader numbers them.
    fn with(self, function: Function) -> Self {
        let (function, slope) = match function {
            Function::Leaky(slope) => (1, slope),
            Function::Sigmoid => (2, 0.0),
            Function::Silu => (3, 0.0),
            Function::Sum => (4, 0.0),
            Function::Product => (5, 0.0),
        };
        Self {
            function,
            slope,
            ..self
        }
    }
}
