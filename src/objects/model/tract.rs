//! Compiles and runs neural networks in the format ONNX with the crate `tract`. Only this module,
//! `screen` and `cost` (which check the same graph before it is compiled or run) and `fast_layers`
//! (which replaces some of its layers) use tract.

use super::Unusable;
use super::cost::{check_constants, check_cost};
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
    /// Name of the output in the file.
    pub name: String,
    /// Sizes of the axes, the batch first.
    pub shape: Vec<usize>,
    /// The numbers; the index of the last axis varies fastest.
    pub values: Vec<f32>,
}

/// A network of fixed input size that tract has compiled. It is run from several threads at once,
/// one picture a run: for small networks this is faster than batches, or several threads for one
/// picture.
pub(super) struct Network {
    plan: Arc<TypedRunnableModel>,
    names: Vec<String>,
    shape: [usize; 4],
}

/// Reads the protobuf of an ONNX file.
///
/// # Errors
/// When the bytes are no ONNX file.
pub(super) fn parse(mut bytes: &[u8]) -> Result<ModelProto, Unusable> {
    // tract's table of layers is filled only once.
    static ONNX: LazyLock<Onnx> = LazyLock::new(tract_onnx::onnx);
    ONNX.proto_model_for_read(&mut bytes).map_err(|_| Unusable::NotOnnx)
}

/// Creates an error with the whole chain of reasons: the first one alone is not enough.
fn compile_error(error: TractError) -> Unusable {
    Unusable::Compile(format!("{error:#}"))
}

fn parsed(
    proto: &ModelProto,
    declared: &Declared,
    shape: [usize; 4],
    folder: Option<&Path>,
) -> TractResult<InferenceModel> {
    // Exporters state the shape of every layer's output for a batch of unknown size, which
    // contradicts the batch of one.
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

/// Converts weights that are stored as f16 to f32, once. tract leaves the conversion of weights
/// above 4 MiB to every run, which then converts and packs them again; this costs a ninth of the
/// time of YOLOv4-tiny.
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

/// Number of the type f16 in ONNX.
pub(super) const FLOAT16: i32 = 10;
/// Number of the type f32 in ONNX.
pub(super) const FLOAT32: i32 = 1;

impl Network {
    /// Compiles the graph of a screened file for one picture of `shape`, and checks its cost.
    /// Weights outside the file are read from `folder`.
    ///
    /// # Errors
    /// When tract refuses the graph, or the graph would take too much memory or time.
    pub(super) fn compile(
        proto: &ModelProto,
        declared: &Declared,
        shape: [usize; 4],
        folder: Option<&Path>,
    ) -> Result<Self, Unusable> {
        let mut graph = parsed(proto, declared, shape, folder).map_err(compile_error)?;
        check_constants(&mut graph)?;
        let graph = typed(graph).map_err(compile_error)?;
        check_cost(&graph)?;
        let plan = || {
            let mut graph = graph.into_decluttered()?;
            replace_layers(&mut graph)?;
            graph.into_optimized()?.into_runnable()
        };
        let plan = plan().map_err(compile_error)?;
        let outputs = proto.graph.iter().flat_map(|graph| &graph.output);
        let names = outputs.map(|output| output.name.clone()).collect();
        Ok(Self { plan, names, shape })
    }

    /// Runs the network on one picture; `input` must hold as many numbers as the input shape.
    ///
    /// # Errors
    /// When tract fails or panics.
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
