//! Which layers of a network a graphics card computes: from the input on, as far as all are of the kinds that it knows.

use super::convolution::Weights;
use super::program::{Function, Kernel, Numbers, Other, Place, Program};
use std::collections::HashMap;
use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::array::{Slice, TypedConcat};
use tract_onnx::tract_core::ops::binary::TypedBinOp;
use tract_onnx::tract_core::ops::cnn::{Conv, KernelFormat, MaxPool, PoolSpec};
use tract_onnx::tract_core::ops::element_wise::ElementWiseOp;
use tract_onnx::tract_core::ops::math::{Add, Mul};
use tract_onnx::tract_core::ops::nn::{DataFormat, LeakyRelu, NearestUpsample, Sigmoid, Silu};

/// The layers, and where they meet the others.
pub(super) struct Layers {
    pub(super) program: Program,
    /// What the first of them reads.
    pub(super) input: OutletId,
    /// What others read of them, in the order of the program's outputs, with its shape.
    pub(super) outlets: Vec<(OutletId, TVec<usize>)>,
}

impl Layers {
    /// Of a network with one input; `None` where it begins with another layer.
    ///
    /// # Errors
    /// When the graph is not whole.
    pub(super) fn of(model: &TypedModel) -> TractResult<Option<Self>> {
        let &[input] = model.input_outlets()? else {
            return Ok(None);
        };
        let Some(count) = numbers_of(model, input) else {
            return Ok(None);
        };
        let mut walk = Walk {
            model,
            program: Program::default(),
            places: HashMap::new(),
        };
        let place = walk.program.make(count);
        walk.places.insert(input, place);
        for id in model.eval_order()? {
            let node = model.node(id);
            if let Some(place) = walk.layer(node)? {
                walk.places.insert(OutletId::new(id, 0), place);
            }
        }
        Ok(walk.finish(input))
    }
}

struct Walk<'a> {
    model: &'a TypedModel,
    program: Program,
    places: HashMap<OutletId, Place>,
}

impl Walk<'_> {
    /// Where the output of a layer lies; `None` of a layer that the card does not know, or that reads such a one.
    fn layer(&mut self, node: &TypedNode) -> TractResult<Option<Place>> {
        let is_f32 = |outlet: &Outlet<TypedFact>| outlet.fact.datum_type == f32::datum_type();
        if node.inputs.is_empty() || node.outputs.len() != 1 || !node.outputs.iter().all(is_f32) {
            return Ok(None);
        }
        let Some(&input) = self.places.get(&node.inputs[0]) else {
            return Ok(None);
        };
        if let Some(conv) = node.op_as::<Conv>() {
            return self.convolution(node, conv, input);
        }
        if let Some(pool) = node.op_as::<MaxPool>() {
            return Ok(self.pool(node, pool, input));
        }
        if let Some(function) = node.op_as::<ElementWiseOp>() {
            let readers = self.model.outlet_successors(node.inputs[0]).len();
            let is_output = self.model.output_outlets()?.contains(&node.inputs[0]);
            let function = function_of(function);
            return Ok(function.map(|function| {
                self.program
                    .apply(input, readers > 1 || is_output, function)
            }));
        }
        if let Some(concat) = node.op_as::<TypedConcat>() {
            return Ok(self.concat(node, concat.axis));
        }
        if let Some(slice) = node.op_as::<Slice>() {
            return Ok(self.slice(node, slice, input));
        }
        if let Some(combination) = node.op_as::<TypedBinOp>() {
            return Ok(self.combination(node, combination, input));
        }
        if let Some(larger) = node.op_as::<NearestUpsample>() {
            return Ok(self.enlargement(node, larger, input));
        }
        Ok(None)
    }

    fn convolution(
        &mut self,
        node: &TypedNode,
        conv: &Conv,
        input: Place,
    ) -> TractResult<Option<Place>> {
        let facts = self.model.node_input_facts(node.id)?;
        let is_of_the_kind =
            conv.group == 1 && conv.q_params.is_none() && conv.kernel_fmt == KernelFormat::OIHW;
        let [read, weights, bias] = facts[..] else {
            return Ok(None);
        };
        let (Some(weights), Some(bias), true) = (&weights.konst, &bias.konst, is_of_the_kind)
        else {
            return Ok(None);
        };
        let are_f32 = [weights, bias]
            .iter()
            .all(|constant| constant.datum_type() == f32::datum_type());
        let Some(numbers) = windows(&conv.pool_spec, read, node).filter(|_| are_f32) else {
            return Ok(None);
        };
        let weights = weights.try_as_plain_ram()?.as_slice::<f32>()?;
        let biases = bias.try_as_plain_ram()?.as_slice::<f32>()?;
        let channels = conv.pool_spec.output_channels;
        // Before they are filled up: a file from anywhere may ask for any number of channels.
        if !(self.program).has_room(Weights::count(numbers.input, numbers.window, channels)) {
            return Ok(None);
        }
        let weights = Weights::new((weights, biases), numbers.input, numbers.window, channels);
        let Some(weights) = weights else {
            return Ok(None);
        };
        Ok(Some(self.program.compute(
            Kernel::Convolve,
            input,
            Other::Weights(weights),
            numbers,
        )))
    }

    fn pool(&mut self, node: &TypedNode, pool: &MaxPool, input: Place) -> Option<Place> {
        let read = self.model.outlet_fact(node.inputs[0]).ok()?;
        let numbers = windows(&pool.pool_spec, read, node)?;
        let is_plain = pool.with_index_outputs.is_none();
        is_plain.then(|| {
            self.program
                .compute(Kernel::Pool, input, Other::Nothing, numbers)
        })
    }

    /// Along the first axis that is longer than one, places lie one after the other.
    fn concat(&mut self, node: &TypedNode, axis: usize) -> Option<Place> {
        let places: Option<Vec<Place>> = node
            .inputs
            .iter()
            .map(|input| self.places.get(input).copied())
            .collect();
        let places = places?;
        is_outermost(shape_of(self.model, OutletId::new(node.id, 0))?, axis)
            .then(|| self.program.join(&places))
    }

    fn slice(&self, node: &TypedNode, slice: &Slice, input: Place) -> Option<Place> {
        let shape = shape_of(self.model, node.inputs[0])?;
        let (start, end) = (slice.start.to_usize().ok()?, slice.end.to_usize().ok()?);
        let each: usize = shape.get(slice.axis + 1..)?.iter().product();
        let is_within = start < end && end <= shape[slice.axis];
        (is_within && is_outermost(shape, slice.axis)).then(|| Place {
            first: input.first + start * each,
            count: (end - start) * each,
            ..input
        })
    }

    fn combination(
        &mut self,
        node: &TypedNode,
        combination: &TypedBinOp,
        input: Place,
    ) -> Option<Place> {
        let &[one, another] = &node.inputs[..] else {
            return None;
        };
        let other = *self.places.get(&another)?;
        let is_sum = combination.0.is::<Add>();
        let is_known = is_sum || combination.0.is::<Mul>();
        let are_alike = shape_of(self.model, one)? == shape_of(self.model, another)?;
        (is_known && are_alike).then(|| self.program.combine(input, other, is_sum))
    }

    fn enlargement(
        &mut self,
        node: &TypedNode,
        larger: &NearestUpsample,
        input: Place,
    ) -> Option<Place> {
        let sizes = |outlet| match *shape_of(self.model, outlet)? {
            [1, channels, height, width] => Some([channels, height, width].map(|side| side as u32)),
            _ => None,
        };
        let [1, 1, down, across] = larger.scales[..] else {
            return None;
        };
        let numbers = Numbers {
            input: sizes(node.inputs[0])?,
            output: sizes(OutletId::new(node.id, 0))?,
            step: [down as u32, across as u32],
            ..Numbers::default()
        };
        Some(
            self.program
                .compute(Kernel::Enlarge, input, Other::Nothing, numbers),
        )
    }

    /// What layers beyond read becomes the outputs.
    fn finish(self, input: OutletId) -> Option<Layers> {
        let Self {
            model,
            mut program,
            places,
        } = self;
        let wanted = model.output_outlets().ok()?;
        let mut outlets = Vec::new();
        for id in model.eval_order().ok()? {
            let outlet = OutletId::new(id, 0);
            let Some(&place) = places.get(&outlet).filter(|_| outlet != input) else {
                continue;
            };
            let is_beyond = |reader: &InletId| !places.contains_key(&OutletId::new(reader.node, 0));
            let readers = model.outlet_successors(outlet);
            if readers.iter().any(is_beyond) || wanted.contains(&outlet) {
                outlets.push((outlet, shape_of(model, outlet)?.into()));
                program.outputs.push(place);
            }
        }
        let fits = program.fits() && !outlets.is_empty();
        fits.then(|| Layers {
            program: program.packed(),
            input,
            outlets,
        })
    }
}

fn function_of(op: &ElementWiseOp) -> Option<Function> {
    match op.0.downcast_ref::<LeakyRelu>() {
        Some(leaky) => Some(Function::Leaky(leaky.alpha)),
        None if op.0.is::<Sigmoid>() => Some(Function::Sigmoid),
        None if op.0.is::<Silu>() => Some(Function::Silu),
        None => None,
    }
}

fn shape_of(model: &TypedModel, outlet: OutletId) -> Option<&[usize]> {
    model.outlet_fact(outlet).ok()?.shape.as_concrete()
}

fn numbers_of(model: &TypedModel, outlet: OutletId) -> Option<usize> {
    let is_f32 = model.outlet_fact(outlet).ok()?.datum_type == f32::datum_type();
    let count = shape_of(model, outlet)?.iter().product();
    is_f32.then_some(count)
}

/// Whether what lies along an axis is one run of numbers after the other.
fn is_outermost(shape: &[usize], axis: usize) -> bool {
    shape.iter().take(axis).all(|side| *side == 1)
}

/// What a layer with windows over a picture is over; `None` of anything else.
fn windows(spec: &PoolSpec, input: &TypedFact, node: &TypedNode) -> Option<Numbers> {
    let picture = |fact: &TypedFact| match (spec.data_format, fact.shape.as_concrete()?) {
        (DataFormat::NCHW, &[1, channels, height, width])
        | (DataFormat::CHW, &[channels, height, width]) => Some([channels, height, width]),
        _ => None,
    };
    let (read, made) = (picture(input)?, picture(&node.outputs[0].fact)?);
    if spec.kernel_shape.len() != 2 || spec.dilations().iter().any(|step| *step != 1) {
        return None;
    }
    let padding = spec.computed_padding(&read[1..]);
    Some(Numbers {
        input: read.map(|side| side as u32),
        output: made.map(|side| side as u32),
        window: [0, 1].map(|axis| spec.kernel_shape[axis] as u32),
        step: [0, 1].map(|axis| spec.stride(axis) as u32),
        before: [0, 1].map(|axis| padding[axis].pad_before as u32),
        ..Numbers::default()
    })
}
