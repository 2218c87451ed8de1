//! Checks the sizes of the tensors that a graph computes from its own constants, before they are
//! computed.
//!
//! While it compiles, tract computes all values that follow from constants alone, and a file of a
//! few hundred bytes can require terabytes for this: one column times one row is enough. This
//! module goes through the layers in their order, and computes first only the size of each layer's
//! outputs, and then their numbers.

use super::Unusable;
use super::screen::check_axes;
use tract_onnx::prelude::{InferenceFact, InferenceModel, OutletId, TractResult};
use tract_onnx::tract_hir::infer::{Factoid, InferenceOp};

/// Greatest number of elements of one tensor that follows from constants; the largest grid of a
/// detector has some hundred thousand.
const MOST_ELEMENTS: u64 = 1 << 24;
/// Greatest number of elements of all such tensors together.
const MOST_ELEMENTS_IN_ALL: u64 = 1 << 26;
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
            in_all = in_all.saturating_add(elements_of(&name, &outputs, unsized_output)?);
            Unusable::unless(in_all <= MOST_ELEMENTS_IN_ALL, || {
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
fn elements_of(
    name: &str,
    outputs: &[InferenceFact],
    unsized_output: bool,
) -> Result<u64, Unusable> {
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
        Unusable::unless(elements <= MOST_ELEMENTS, || {
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
