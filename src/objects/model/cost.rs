//! Bounds the cost of a network: of the tensors that follow from its own constants, before they are
//! computed, and of one picture, from the sizes of the layers, before the network is run.
//!
//! While it compiles, tract computes all values that follow from constants alone, and a file of a
//! few hundred bytes can require terabytes for this: one column times one row is enough.
//! [`check_constants`] goes through the layers in their order, and computes first only the size of
//! each layer's outputs, and then their numbers.

use super::Unusable;
use super::screen::check_axes;
use tract_onnx::prelude::{
    InferenceFact, InferenceModel, OutletId, TractResult, TypedModel, TypedNode,
};
use tract_onnx::tract_core::ops::Cost;
use tract_onnx::tract_core::ops::cnn::{Conv, Deconv};
use tract_onnx::tract_hir::infer::{Factoid, InferenceOp};

/// Greatest number of elements of one tensor that follows from constants; the largest grid of a
/// detector has some hundred thousand.
const MOST_MADE: u64 = 1 << 24;
/// Greatest number of elements of all such tensors together.
const MOST_MADE_IN_ALL: u64 = 1 << 26;
/// Layers that do not state their output's size beforehand; it has at most as many elements as the
/// input, times the input's number of axes.
const UNSIZED: [&str; 2] = ["Compress", "NonZero"];

/// Refuses a graph whose constants become too large. The computed facts are stored in the graph.
/// Layers whose facts cannot be inferred here are left to the compilation, and so are errors in the
/// graph.
///
/// # Errors
/// When a tensor of constants, or all of them together, are too large, or a tensor has too many
/// axes.
pub(super) fn check_constants(model: &mut InferenceModel) -> Result<(), Unusable> {
    let mut in_all = 0_u64;
    for node in model.eval_order().unwrap_or_default() {
        // The node is a source, or a weight from the file.
        if model.node(node).inputs.is_empty() {
            continue;
        }
        let Ok(around) = Around::of(model, node) else {
            continue;
        };
        let name = model.node(node).name.clone();
        let Ok(mut outputs) = around.sizes(model.node_mut(node).op.as_mut()) else {
            continue;
        };
        if around.known() {
            let unsized_output = UNSIZED.contains(&&*model.node(node).op.name());
            in_all = in_all.saturating_add(made_of(&name, &outputs, unsized_output)?);
            Unusable::unless(in_all <= MOST_MADE_IN_ALL, || {
                format!("up to its layer {name} it makes {in_all} numbers of its constants")
            })?;
            let Ok(made) = around.numbers(model.node_mut(node).op.as_mut()) else {
                continue;
            };
            outputs = made;
        }
        for (slot, fact) in outputs.into_iter().enumerate() {
            // A chain of layers may add one axis with each layer.
            check_axes(&name, fact.shape.rank().concretize().map_or(0, |axes| axes as usize))?;
            // A missing slot is reported by the compilation.
            model.set_outlet_fact(OutletId::new(node, slot), fact).ok();
        }
    }
    Ok(())
}

/// Returns the number of elements that a layer computes from constants.
///
/// # Errors
/// When a tensor is too large, or its size is unknown and `unsized_output` is false.
fn made_of(name: &str, outputs: &[InferenceFact], unsized_output: bool) -> Result<u64, Unusable> {
    let mut sum = 0;
    for fact in outputs {
        let elements = match fact.shape.concretize() {
            Some(sizes) => {
                let mut sizes = sizes.iter().map(|size| u64::try_from(size.to_i64().ok()?).ok());
                sizes.try_fold(1_u64, |product, size| product.checked_mul(size?))
            }
            None => unsized_output.then_some(0),
        };
        let elements = elements.unwrap_or(u64::MAX);
        Unusable::unless(elements <= MOST_MADE, || {
            format!("its layer {name} makes {:?} numbers of constants", fact.shape)
        })?;
        sum += elements;
    }
    Ok(sum)
}

/// Facts about a layer's inputs, its outputs and the tensors that it observes, in this order.
struct Around([Vec<InferenceFact>; 3]);

impl Around {
    fn of(model: &InferenceModel, node: usize) -> TractResult<Self> {
        let (inputs, outputs) = model.node_facts(node)?;
        let node = model.node(node);
        let observed = node.op.observe_outlets(model, node)?;
        let observed = observed.iter().map(|outlet| model.outlet_fact(*outlet));
        let observed: Vec<&InferenceFact> = observed.collect::<TractResult<_>>()?;
        let own = |facts: &[&InferenceFact]| facts.iter().map(|&fact| fact.clone()).collect();
        Ok(Self([own(&inputs), own(&outputs), own(&observed)]))
    }

    /// Returns true if all inputs are constants.
    fn known(&self) -> bool {
        self.0[0].iter().all(|fact| fact.value.is_concrete())
    }

    /// Infers the outputs by the rules of the layer, which compute sizes but no other numbers.
    fn sizes(&self, op: &mut dyn InferenceOp) -> TractResult<Vec<InferenceFact>> {
        let [inputs, outputs, observed] = self.0.each_ref().map(|facts| facts.iter().collect());
        Ok(op.infer_facts(inputs, outputs, observed)?.1.into_vec())
    }

    /// Infers the outputs with their numbers, if these follow from the inputs.
    fn numbers(&self, op: &mut dyn InferenceOp) -> TractResult<Vec<InferenceFact>> {
        let [inputs, outputs, observed] = self.0.each_ref().map(|facts| facts.iter().collect());
        Ok(op.infer(inputs, outputs, observed)?.1.into_vec())
    }
}

/// Greatest number of multiplications of one picture: three times the number of YOLOv4 at 608
/// pixels; they take some ten seconds on one core.
const MOST_MULTIPLICATIONS: u64 = 200_000_000_000;
/// Greatest number of elements of one tensor: 512 MiB of f32.
const MOST_ELEMENTS: u64 = 1 << 27;
/// Greatest number of elements of the tensors that are held at one time: 1 GiB of f32. YOLOv4 at
/// 608 pixels holds a twentieth of this.
const MOST_ELEMENTS_AT_ONCE: u64 = 1 << 28;
/// Greatest number of elements of all tensors together, most of which are held only for a moment.
const MOST_ELEMENTS_IN_ALL: u64 = 1 << 31;

const BILLION: u64 = 1_000_000_000;

/// Refuses a network that needs more memory or work than a detector should.
///
/// # Errors
/// When one of the limits of this module is exceeded.
pub(super) fn check_cost(model: &TypedModel) -> Result<(), Unusable> {
    let (mut in_all, mut multiplications) = (0_u64, 0_u64);
    for node in model.nodes() {
        in_all = in_all.saturating_add(elements_of(node)?);
        let work = multiplications_of(model, node);
        multiplications = multiplications.saturating_add(work);
        check_gathered(node, work)?;
    }
    Unusable::unless(in_all <= MOST_ELEMENTS_IN_ALL, || {
        format!("one picture becomes {} billion numbers on its way", in_all / BILLION)
    })?;
    Unusable::unless(multiplications <= MOST_MULTIPLICATIONS, || {
        format!("one picture takes {} billion multiplications", multiplications / BILLION)
    })?;
    check_held(model)
}

/// Returns the number of elements of a layer's outputs.
///
/// # Errors
/// When an output is too large, or its size is unknown.
fn elements_of(node: &TypedNode) -> Result<u64, Unusable> {
    let mut sum = 0;
    for output in &node.outputs {
        let shape = &output.fact.shape;
        let elements = shape.volume().as_i64().map_or(u64::MAX, i64::unsigned_abs);
        Unusable::unless(elements <= MOST_ELEMENTS, || {
            format!("its layer {} holds {shape:?} numbers", node.name)
        })?;
        sum += elements;
    }
    Ok(sum)
}

/// Returns the number of multiplications of a layer.
fn multiplications_of(model: &TypedModel, node: &TypedNode) -> u64 {
    let inputs = model.node_input_facts(node.id).unwrap_or_default();
    let costs = node.op.cost(&inputs).unwrap_or_default();
    let counts = costs
        .iter()
        .filter(|(cost, _)| matches!(cost, Cost::FMA(_)))
        .map(|(_, count)| count.as_i64().map_or(u64::MAX, i64::unsigned_abs));
    counts.fold(0, u64::saturating_add)
}

/// Refuses a convolution that gathers too many numbers. A convolution copies the pixels under its
/// kernel side by side, a transposed one the products that it adds up: as many numbers as it makes
/// multiplications for one channel of the other side.
fn check_gathered(node: &TypedNode, multiplications: u64) -> Result<(), Unusable> {
    let shared = match (node.op_as::<Conv>(), node.op_as::<Deconv>()) {
        (Some(conv), _) => conv.pool_spec.output_channels / conv.group.max(1),
        (_, Some(conv)) => conv.pool_spec.input_channels / conv.group.max(1),
        _ => return Ok(()),
    };
    let gathered = multiplications / (shared as u64).max(1);
    Unusable::unless(gathered <= MOST_ELEMENTS_AT_ONCE, || {
        format!("its layer {} gathers {gathered} numbers under its kernel", node.name)
    })
}

/// Refuses a network that holds too many elements at one time. Each output is held until the last
/// layer that reads it has run.
fn check_held(model: &TypedModel) -> Result<(), Unusable> {
    let order = model.eval_order().unwrap_or_default();
    let mut step_of = vec![0; model.nodes().len()];
    for (step, &node) in order.iter().enumerate() {
        step_of[node] = step;
    }
    let last_read = |outlet: OutletId| {
        let readers = model.outlet_successors(outlet).iter();
        readers.map(|reader| step_of[reader.node]).max()
    };
    let mut freed = vec![0_u64; order.len()];
    let mut held = 0_u64;
    for (step, &node) in order.iter().enumerate() {
        for slot in 0..model.node(node).outputs.len() {
            let outlet = OutletId::new(node, slot);
            let elements =
                model.outlet_fact(outlet).ok().and_then(|fact| fact.shape.volume().as_i64());
            let elements = elements.unwrap_or(0).unsigned_abs();
            held = held.saturating_add(elements);
            freed[last_read(outlet).unwrap_or(order.len() - 1)] += elements;
        }
        Unusable::unless(held <= MOST_ELEMENTS_AT_ONCE, || {
            let name = &model.node(node).name;
            format!("at its layer {name} one picture holds {held} numbers at a time")
        })?;
        held -= freed[step];
    }
    Ok(())
}
