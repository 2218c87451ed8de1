//! Networks run by tract, in pure Rust. Beside it only `screen`, `constants` and `cost` name it,
//! which look at the same graph before it is compiled or run, and `fast_layers`, which replaces
//! layers of it.

use super::Unusable;
use super::constants::check_constants;
use super::cost::check_cost;
use super::fast_layers::replace_layers;
use super::screen::Declared;
use bathyscope_log::support::catch_panic::catch_panic;
use std::path::Path;
use std::sync::{Arc, LazyLock};
use tract_onnx::Onnx;
use tract_onnx::pb::ModelProto;
use tract_onnx::prelude::*;
use tract_onnx::tract_core::ops::{cast::Cast, konst::Const};
use tract_onnx::tract_core::transform::get_transform;

/// Output of a network for one picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Output {
    /// Name in the file.
    pub name: String,
    /// Sizes, the batch's first.
    pub shape: Vec<usize>,
    /// The numbers, the last size's the fastest.
    pub values: Vec<f32>,
}

/// A network that tract has compiled, of fixed input size. It is run from several threads at once,
/// one picture a run: for small networks that is faster than batches and than threads within a run.
pub(super) struct Network {
    plan: Arc<TypedRunnableModel>,
    names: Vec<String>,
    shape: [usize; 4],
}

/// Reads the protobuf.
///
/// # Errors
/// Why the model cannot be used.
pub(super) fn parse(bytes: &[u8]) -> Result<ModelProto, Unusable> {
    // Its table of layers is filled once.
    static ONNX: LazyLock<Onnx> = LazyLock::new(tract_onnx::onnx);
    let mut bytes = bytes;
    ONNX.proto_model_for_read(&mut bytes).map_err(|_| Unusable::NotOnnx)
}

/// A screened graph for one picture of `shape`, whose cost is bounded. `folder` is where weights
/// outside the file lie.
///
/// # Errors
/// Why the model cannot be used.
pub(super) fn graph(
    proto: &ModelProto,
    declared: &Declared,
    shape: [usize; 4],
    folder: Option<&Path>,
) -> Result<TypedModel, Unusable> {
    let mut model = parsed(proto, declared, shape, folder).map_err(compile_error)?;
    check_constants(&mut model)?;
    let model = typed(model).map_err(compile_error)?;
    check_cost(&model)?;
    Ok(model)
}

/// The chain of reasons: the topmost alone is not enough.
fn compile_error(error: TractError) -> Unusable {
    Unusable::Compile(format!("{error:#}"))
}

fn parsed(
    proto: &ModelProto,
    declared: &Declared,
    shape: [usize; 4],
    folder: Option<&Path>,
) -> TractResult<InferenceModel> {
    // Exporters write shapes of a batch of unknown size beside every layer, which contradict the
    // batch of one.
    let onnx = tract_onnx::onnx().with_ignore_value_info(true);
    let folder = folder.map(|folder| folder.to_string_lossy());
    let parsed = onnx.parse(proto, folder.as_deref())?;
    if !parsed.unresolved_inputs.is_empty() {
        let names = parsed.unresolved_inputs.join(", ");
        return Err(TractError::msg(format!("nothing makes {names}")));
    }
    let element = if declared.element == FLOAT16 { f16::datum_type() } else { f32::datum_type() };
    parsed.model.with_input_fact(0, InferenceFact::dt_shape(element, shape))
}

fn typed(model: InferenceModel) -> TractResult<TypedModel> {
    let mut model = model.into_typed()?;
    // Arithmetic in f16 is emulated: hundreds of times slower, and less exact.
    if let Some(widen) = get_transform("f16_to_f32")? {
        widen.transform(&mut model)?;
    }
    widen_weights(&mut model)?;
    Ok(model)
}

/// Makes f32 of weights that are stored as f16, once. tract leaves those above 4 MiB to every run,
/// which then widens and packs them anew: a ninth of the time of YOLOv4-tiny.
fn widen_weights(model: &mut TypedModel) -> TractResult<()> {
    for node in model.eval_order()? {
        let node = model.node(node);
        let Some(&Cast { to }) = node.op_as::<Cast>() else {
            continue;
        };
        let stored = model.node_input_facts(node.id)?[0].konst.clone();
        let (Some(stored), true) = (stored, to == f32::datum_type()) else {
            continue;
        };
        let widened = stored.cast_to::<f32>()?.into_owned().into_arc_tensor();
        let constant = Const::new(widened)?;
        TypedModelPatch::replace_single_op(model, node, &[], constant)?.apply(model)?;
    }
    Ok(())
}

/// ONNX's number of f16.
pub(super) const FLOAT16: i32 = 10;
/// ONNX's number of f32.
pub(super) const FLOAT32: i32 = 1;

fn output_names(proto: &ModelProto) -> Vec<String> {
    let outputs = proto.graph.iter().flat_map(|graph| &graph.output);
    outputs.map(|output| output.name.clone()).collect()
}

impl Network {
    /// Compiles a graph of the file that it is from.
    ///
    /// # Errors
    /// Why the model cannot be used.
    pub(super) fn compile(
        graph: TypedModel,
        proto: &ModelProto,
        shape: [usize; 4],
    ) -> Result<Self, Unusable> {
        let plan = || {
            let mut graph = graph.into_decluttered()?;
            replace_layers(&mut graph)?;
            graph.into_optimized()?.into_runnable()
        };
        let plan = plan().map_err(compile_error)?;
        Ok(Self { plan, names: output_names(proto), shape })
    }

    /// Runs one picture through; `input` holds as many numbers as the input has.
    ///
    /// # Errors
    /// Why the model cannot be used.
    pub(super) fn run(&self, input: &[f32]) -> Result<Vec<Output>, Unusable> {
        catch_panic(|| self.run_trusting(input))
            .ok_or(Unusable::Damaged("a run"))?
            .map_err(|error| Unusable::Run(format!("{error:#}")))
    }

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
