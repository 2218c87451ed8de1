//! Estimates the cost of one picture in a compiled network from the sizes of its layers, before the
//! network is run.

use super::Unusable;
use tract_onnx::prelude::{OutletId, TypedModel, TypedNode};
use tract_onnx::tract_core::ops::Cost;
use tract_onnx::tract_core::ops::cnn::{Conv, Deconv};

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
