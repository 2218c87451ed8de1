//! The layers of a network on a graphics card.
//!
//! In: a network's graph. Out: the same graph with one layer in the place of all that the card computes, as far as it knows them from the
//! input on. What follows, some thousand numbers, is computed by the processor.
//!
//! `choice` looks for a card and decides whether it is worth it. `layers` reads the graph into a `program` of steps, with the constants of each
//! `convolution`; `device` runs it by `wgpu` (`shaders/network.wgsl`).

mod choice;
mod convolution;
mod device;
mod layers;
mod program;
#[cfg(test)]
mod tests;

pub(super) use choice::placed;

use super::cost::multiplications_of;
use device::{Card, Runner};
use layers::Layers;
use std::fmt;
use std::sync::Arc;
use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::cnn::Conv;
use tract_onnx::tract_core::optim::Optimizer;

/// Share of the multiplications that makes a card worth its way there and back.
const WORTH: f64 = 0.9;
/// Rounds of simplifications of a graph, at most.
const MOST_ROUNDS: usize = 8;

/// Puts the layer of the card into a graph; else why it is not worth it.
fn replace_layers(model: &mut TypedModel, card: Arc<Card>) -> TractResult<Result<(), String>> {
    let cost = |model: &TypedModel| -> u64 {
        let nodes = model.nodes().iter();
        nodes.map(|node| multiplications_of(model, node)).sum()
    };
    let all = cost(model);
    simplify(model)?;
    let Some(layers) = Layers::of(model)? else {
        return Ok(Err(
            "it does not know the first layers, or has no room for them".to_owned(),
        ));
    };
    let runner = match Runner::new(card, &layers.program) {
        Ok(runner) => Arc::new(runner),
        Err(fault) => return Ok(Err(fault)),
    };
    let shapes = layers.outlets.iter().map(|(_, shape)| shape.clone());
    let shapes = shapes.collect();
    let mut patch = TypedModelPatch::default();
    let input = patch.tap_model(model, layers.input)?;
    let outputs = patch.wire_node("graphics", GraphicsLayers { runner, shapes }, &[input])?;
    for ((outlet, _), output) in layers.outlets.iter().zip(outputs) {
        patch.shunt_outside(model, *outlet, output)?;
    }
    patch.apply(model)?;
    // Without the layers that nothing reads any more.
    model.compact()?;
    let share = 1.0 - cost(model) as f64 / all.max(1) as f64;
    Ok(match share >= WORTH {
        true => Ok(()),
        false => Err(format!("it knows {:.0} % of the network", 100.0 * share)),
    })
}

/// Has each layer say itself more simply, but for convolutions: tract makes sums of products of some, which the card has no use for.
fn simplify(model: &mut TypedModel) -> TractResult<()> {
    Optimizer::prop_consts().optimize(model)?;
    for _ in 0..MOST_ROUNDS {
        let mut changes = false;
        for id in model.eval_order()? {
            let node = model.node(id);
            if node.op_is::<Conv>() {
                continue;
            }
            if let Some(patch) = node.op.declutter(model, node)? {
                patch.apply(model)?;
                changes = true;
            }
        }
        if !changes {
            break;
        }
        model.compact()?;
        Optimizer::prop_consts().optimize(model)?;
    }
    Ok(())
}

/// The layer in tract's graph.
#[derive(Clone)]
struct GraphicsLayers {
    runner: Arc<Runner>,
    shapes: Vec<TVec<usize>>,
}

impl fmt::Debug for GraphicsLayers {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_tuple("GraphicsLayers")
            .field(&self.runner.card().name())
            .field(&self.shapes)
            .finish()
    }
}

impl PartialEq for GraphicsLayers {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.runner, &other.runner)
    }
}

impl Eq for GraphicsLayers {}

impl Op for GraphicsLayers {
    fn name(&self) -> StaticName {
        "GraphicsLayers".into()
    }

    op_as_typed_op!();
}

impl EvalOp for GraphicsLayers {
    op_out_of_plan!();

    fn eval(&self, _ctx: &EvalContext, inputs: TVec<TValue>) -> TractResult<TVec<TValue>> {
        let input = args_1!(inputs);
        let input = input.try_as_plain_ram()?.as_slice::<f32>()?;
        let outputs = self.runner.run(input).map_err(TractError::msg)?;
        let shaped = self.shapes.iter().zip(outputs);
        shaped
            .map(|(shape, output)| {
                let output = tract_ndarray::ArrayD::from_shape_vec(&shape[..], output)?;
                Ok(output.into_tensor().into())
            })
            .collect()
    }
}

impl TypedOp for GraphicsLayers {
    as_op!();

    fn output_facts(&self, _inputs: &[&TypedFact]) -> TractResult<TVec<TypedFact>> {
        Ok(self.shapes.iter().map(f32::fact).collect())
    }
}
