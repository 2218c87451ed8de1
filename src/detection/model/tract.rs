//! Networks run by tract, in pure Rust. The only file that names it beside `screen`, which reads the same protobuf.

use super::screen::Declared;
use super::{Inference, Output, Unusable};
use crate::contained::contained;
use std::path::Path;
use std::sync::Arc;
use tract_onnx::pb::ModelProto;
use tract_onnx::prelude::*;
use tract_onnx::tract_core::ops::Cost;
use tract_onnx::tract_core::transform::get_transform;

/// Multiplications that one picture may cost: three times what YOLOv4 takes at 608 pixels, some ten seconds of one core.
const MOST_MULTIPLICATIONS: u64 = 200_000_000_000;
/// Elements of one tensor: 512 MiB of f32.
const MOST_ELEMENTS: u64 = 1 << 27;
/// Elements of all tensors together; most live only for a moment.
const MOST_ELEMENTS_IN_ALL: u64 = 1 << 31;

/// A network that tract has compiled.
pub struct Network {
    plan: Arc<TypedRunnableModel>,
    names: Vec<String>,
    shape: [usize; 4],
}

/// Reads the protobuf.
pub fn parse(bytes: &[u8]) -> Result<ModelProto, Unusable> {
    let mut bytes = bytes;
    tract_onnx::onnx()
        .proto_model_for_read(&mut bytes)
        .map_err(|_| Unusable::NotOnnx)
}

/// Compiles a screened graph for one picture of `shape`. `folder` is where weights outside the file lie.
pub fn compile(
    proto: &ModelProto,
    declared: &Declared,
    shape: [usize; 4],
    folder: Option<&Path>,
) -> Result<Network, Unusable> {
    // The chain of reasons: the topmost alone tells nothing.
    let told = |error: TractError| Unusable::Compile(format!("{error:#}"));
    let model = typed(proto, declared, shape, folder).map_err(told)?;
    check_cost(&model)?;
    let names = output_names(proto);
    let plan = model
        .into_optimized()
        .and_then(|model| model.into_runnable())
        .map_err(told)?;
    Ok(Network { plan, names, shape })
}

fn typed(
    proto: &ModelProto,
    declared: &Declared,
    shape: [usize; 4],
    folder: Option<&Path>,
) -> TractResult<TypedModel> {
    // Exporters write shapes of a batch of unknown size beside every layer, which contradict the batch of one.
    let onnx = tract_onnx::onnx().with_ignore_value_info(true);
    let folder = folder.map(|folder| folder.to_string_lossy());
    let parsed = onnx.parse(proto, folder.as_deref())?;
    if !parsed.unresolved_inputs.is_empty() {
        let names = parsed.unresolved_inputs.join(", ");
        return Err(TractError::msg(format!("nothing makes {names}")));
    }
    let element = if declared.element == FLOAT16 {
        f16::datum_type()
    } else {
        f32::datum_type()
    };
    let mut model = parsed
        .model
        .with_input_fact(0, InferenceFact::dt_shape(element, shape))?
        .into_typed()?;
    // Arithmetic in f16 is emulated: hundreds of times slower, and less exact.
    if let Some(widen) = get_transform("f16_to_f32")? {
        widen.transform(&mut model)?;
    }
    Ok(model)
}

/// ONNX's number of f16.
pub const FLOAT16: i32 = 10;
/// ONNX's number of f32.
pub const FLOAT32: i32 = 1;

fn output_names(proto: &ModelProto) -> Vec<String> {
    let outputs = proto.graph.iter().flat_map(|graph| &graph.output);
    outputs.map(|output| output.name.clone()).collect()
}

/// Refuses a network that asks for more memory or work than a detector needs, before it is run.
fn check_cost(model: &TypedModel) -> Result<(), Unusable> {
    let (mut in_all, mut multiplications) = (0_u64, 0_u64);
    for node in model.nodes() {
        for output in &node.outputs {
            let elements = output.fact.shape.volume().as_i64().map(i64::unsigned_abs);
            let Some(elements) = elements.filter(|&count| count <= MOST_ELEMENTS) else {
                return Err(Unusable::TooBig(format!(
                    "its layer {} holds {:?} numbers",
                    node.name, output.fact.shape
                )));
            };
            in_all = in_all.saturating_add(elements);
        }
        let inputs = model.node_input_facts(node.id).unwrap_or_default();
        let costs = node.op.cost(&inputs).unwrap_or_default();
        for (_, count) in costs
            .iter()
            .filter(|(cost, _)| matches!(cost, Cost::FMA(_)))
        {
            let count = count.as_i64().map_or(u64::MAX, i64::unsigned_abs);
            multiplications = multiplications.saturating_add(count);
        }
    }
    if in_all > MOST_ELEMENTS_IN_ALL {
        return Err(Unusable::TooBig(format!(
            "one picture becomes {} billion numbers on its way",
            in_all / 1_000_000_000
        )));
    }
    if multiplications > MOST_MULTIPLICATIONS {
        return Err(Unusable::TooBig(format!(
            "one picture takes {} billion multiplications",
            multiplications / 1_000_000_000
        )));
    }
    Ok(())
}

impl Inference for Network {
    fn run(&self, input: Vec<f32>) -> Result<Vec<Output>, Unusable> {
        contained(|| self.run_trusting(&input))
            .ok_or(Unusable::Damaged("a run"))?
            .map_err(|error| Unusable::Run(format!("{error:#}")))
    }
}

impl Network {
    fn run_trusting(&self, input: &[f32]) -> TractResult<Vec<Output>> {
        let input = Tensor::from_shape(&self.shape, input)?;
        let outputs = self.plan.run(tvec!(input.into()))?;
        let named = self.names.iter().zip(outputs);
        named
            .map(|(name, output)| {
                let numbers = output.cast_to::<f32>()?;
                Ok(Output {
                    name: name.clone(),
                    shape: numbers.shape().to_vec(),
                    values: numbers.try_as_plain_ram()?.as_slice::<f32>()?.to_vec(),
                })
            })
            .collect()
    }
}
