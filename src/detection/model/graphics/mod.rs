//! The layers of a network on a graphics card.
//!
//! In: a network's graph. Out: the same graph with one layer in the place of all that the card computes, as far as it knows them from the
//! input on. What follows, some thousand numbers, is computed by the processor.
//!
//! `layers` reads the graph into a `program` of steps, which `device` runs by `wgpu` (`shaders/network.wgsl`).

mod device;
mod layers;
mod program;
#[cfg(test)]
mod tests;

use super::cost::multiplications_of;
use super::tract::Network;
use super::{Inference, Output, Unusable};
use crate::support::catch_panic::catch_panic;
use device::{Card, Runner};
use layers::Layers;
use std::fmt;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};
use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::cnn::Conv;
use tract_onnx::tract_core::optim::Optimizer;

/// Share of the multiplications that makes a card worth its way there and back.
const WORTH: f64 = 0.9;

/// With `on` in it, a card is used: its speed is not known yet, and to look for one takes memory and time where there is none.
const SWITCH: &str = "BATHYSCOPE_GRAPHICS_CARD";

/// Whether a fast card is chosen, or the first adapter of any kind, for tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    Fast,
    #[cfg(test)]
    Any,
}

/// The card, or that there is none; `None` where none is asked for.
fn card(choice: Choice) -> Option<Option<Arc<Card>>> {
    // Opened once: a driver takes a tenth of a second.
    static FAST: LazyLock<Option<Arc<Card>>> = LazyLock::new(|| {
        let card = catch_panic(|| Card::open(Card::is_fast));
        card.flatten().map(Arc::new)
    });
    match choice {
        Choice::Fast => {
            let is_on = std::env::var_os(SWITCH).is_some_and(|value| value == "on");
            is_on.then(|| FAST.clone())
        }
        #[cfg(test)]
        Choice::Any => Some(Card::open(|_| true).map(Arc::new)),
    }
}

/// Rounds of simplifications of a graph, at most.
const MOST_ROUNDS: usize = 8;
/// By how much of an output's greatest number what the card computes may differ from what the processor does. Sizes of boxes are exponentials:
/// on noise, those of the shipped network differ by 0.2 %.
const AGREES: f32 = 1e-2;

/// The network with its layers on the card, where the computer has one that knows them and computes the same as the processor.
pub(super) fn placed(processor: Network, graph: TypedModel, choice: Choice) -> Box<dyn Inference> {
    let Some(card) = card(choice) else {
        return Box::new(processor);
    };
    let name = card
        .as_ref()
        .map_or("a graphics card", |card| card.name())
        .to_owned();
    let tried = match card {
        Some(card) => tried(&processor, graph, card),
        None => Err("none with memory of its own was found".to_owned()),
    };
    let (by_card, fault) = match tried {
        Ok(network) => (Some(network), None),
        Err(fault) => (None, Some(fault)),
    };
    Box::new(Placed {
        processor,
        by_card,
        name,
        fault: Mutex::new(fault),
    })
}

/// The network on a card; else why not, whatever goes wrong.
fn tried(processor: &Network, graph: TypedModel, card: Arc<Card>) -> Result<Network, String> {
    catch_panic(|| on_card(processor, graph, card))
        .ok_or_else(|| "its driver failed".to_owned())?
        .map_err(|error| format!("{error:#}"))?
}

/// The network on a card that computes what the processor does; else why not.
fn on_card(
    processor: &Network,
    mut graph: TypedModel,
    card: Arc<Card>,
) -> TractResult<Result<Network, String>> {
    if let Err(fault) = replace_layers(&mut graph, card)? {
        return Ok(Err(fault));
    }
    let network = processor.with(graph)?;
    let trial: Vec<f32> = (0..processor.count()).map(trial_number).collect();
    let outputs = processor.run(trial.clone()).and_then(|expected| {
        let found = network.run(trial)?;
        Ok((expected, found))
    });
    Ok(match outputs {
        Ok((expected, found)) => match difference(&expected, &found) {
            share if share <= AGREES => Ok(network),
            share => Err(format!("its numbers differ by {:.2} %", 100.0 * share)),
        },
        Err(error) => Err(error.to_string()),
    })
}

/// Numbers of a picture that shows something everywhere.
fn trial_number(at: usize) -> f32 {
    (at.wrapping_mul(2_654_435_761) >> 16 & 255) as f32 / 255.0
}

/// By how much of an output's greatest number others differ from it, at most; infinity where one is no number.
fn difference(expected: &[Output], found: &[Output]) -> f32 {
    let greatest = |most: f32, number: f32| match number.is_nan() {
        true => f32::INFINITY,
        false => most.max(number.abs()),
    };
    let of_output = |(one, other): (&Output, &Output)| {
        let pairs = one.values.iter().zip(&other.values);
        let differ = pairs.map(|(a, b)| a - b).fold(0.0, greatest);
        let most = one.values.iter().copied().fold(f32::MIN_POSITIVE, greatest);
        differ / most
    };
    expected
        .iter()
        .zip(found)
        .map(of_output)
        .fold(0.0, greatest)
}

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

/// A network on the card, or on the processor once the card has given a picture up.
struct Placed {
    processor: Network,
    by_card: Option<Network>,
    name: String,
    /// Why the card is not used.
    fault: Mutex<Option<String>>,
}

impl Placed {
    fn fault(&self) -> MutexGuard<'_, Option<String>> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inference for Placed {
    fn run(&self, input: Vec<f32>) -> Result<Vec<Output>, Unusable> {
        let by_card = self.by_card.as_ref();
        let Some(network) = by_card.filter(|_| self.fault().is_none()) else {
            return self.processor.run(input);
        };
        network.run(input.clone()).or_else(|error| {
            *self.fault() = Some(error.to_string());
            self.processor.run(input)
        })
    }

    fn runs_on(&self) -> String {
        match &*self.fault() {
            Some(fault) => format!(", run by the processor, not by {}: {fault}", self.name),
            None => format!(", run by {}", self.name),
        }
    }
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
