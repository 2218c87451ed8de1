//! Puts [`Convolution`] in the place of those layers of a network that it can compute.

use super::winograd::Convolution;
use std::fmt;
use std::sync::Arc;
use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::cnn::{Conv, KernelFormat, PaddingSpec};
use tract_onnx::tract_core::ops::nn::DataFormat;

/// Numbers that all of them keep at most, 128 MiB: they are four times the weights. Layers over that stay as they are.
const MOST_WEIGHTS: usize = 1 << 25;

/// Replaces layers in the order of the network.
pub(super) fn replace_convolutions(model: &mut TypedModel) -> TractResult<()> {
    let mut left = MOST_WEIGHTS;
    for node in model.eval_order()? {
        let node = model.node(node);
        let Some(layer) = fast(model, node, left)? else {
            continue;
        };
        left -= layer.weights;
        let input = &node.inputs[..1];
        TypedModelPatch::replace_single_op(model, node, input, layer)?.apply(model)?;
    }
    Ok(())
}

/// The fast layer for a node; `None` where the node is no convolution of the kind, or the layer would keep more than `most` numbers.
fn fast(model: &TypedModel, node: &TypedNode, most: usize) -> TractResult<Option<FastConvolution>> {
    let Some(conv) = node.op_as::<Conv>().filter(|conv| is_of_the_kind(conv)) else {
        return Ok(None);
    };
    let [input, weights, bias] = &model.node_input_facts(node.id)?[..] else {
        return Ok(None);
    };
    let shape = input.shape.as_concrete();
    let (Some(&[1, _, height, width]), Some(weights), Some(bias)) =
        (shape, &weights.konst, &bias.konst)
    else {
        return Ok(None);
    };
    let channels = [
        conv.pool_spec.input_channels,
        conv.pool_spec.output_channels,
    ];
    let kept = Convolution::weights_of(channels);
    let is_f32 = [input.datum_type, weights.datum_type(), bias.datum_type()]
        .iter()
        .all(|datum| *datum == f32::datum_type());
    if !is_f32 || kept > most {
        return Ok(None);
    }
    let bias = bias.try_as_plain_ram()?.as_slice::<f32>()?;
    let bias = match bias {
        [one] => vec![*one; channels[1]],
        each => each.to_vec(),
    };
    let weights = weights.try_as_plain_ram()?.as_slice::<f32>()?;
    let convolution = Convolution::new(weights, &bias, channels, [height, width]);
    Ok(convolution.map(|convolution| FastConvolution {
        convolution: Arc::new(convolution),
        weights: kept,
    }))
}

/// Whether a layer is 3 x 3 with steps of one and a border of one zero.
fn is_of_the_kind(conv: &Conv) -> bool {
    let spec = &conv.pool_spec;
    let are_ones = |steps: &Option<TVec<usize>>| {
        (steps.as_ref()).is_none_or(|steps| steps.iter().all(|step| *step == 1))
    };
    let is_padded = match &spec.padding {
        PaddingSpec::SameUpper | PaddingSpec::SameLower => true,
        PaddingSpec::Explicit(before, after) => before[..] == [1, 1] && after[..] == [1, 1],
        _ => false,
    };
    conv.group == 1
        && conv.q_params.is_none()
        && conv.kernel_fmt == KernelFormat::OIHW
        && spec.data_format == DataFormat::NCHW
        && spec.kernel_shape[..] == [3, 3]
        && are_ones(&spec.strides)
        && are_ones(&spec.dilations)
        && is_padded
}

/// The layer in tract's graph.
#[derive(Clone)]
struct FastConvolution {
    convolution: Arc<Convolution>,
    weights: usize,
}

impl fmt::Debug for FastConvolution {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shape = self.convolution.output_shape();
        formatter
            .debug_tuple("FastConvolution")
            .field(&shape)
            .finish()
    }
}

impl PartialEq for FastConvolution {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.convolution, &other.convolution)
    }
}

impl Eq for FastConvolution {}

impl FastConvolution {
    fn shape(&self) -> [usize; 4] {
        let [channels, height, width] = self.convolution.output_shape();
        [1, channels, height, width]
    }
}

impl Op for FastConvolution {
    fn name(&self) -> StaticName {
        "FastConvolution".into()
    }

    op_as_typed_op!();
}

impl EvalOp for FastConvolution {
    op_out_of_plan!();

    fn eval(&self, _ctx: &EvalContext, inputs: TVec<TValue>) -> TractResult<TVec<TValue>> {
        let input = args_1!(inputs);
        let output = self
            .convolution
            .run(input.try_as_plain_ram()?.as_slice::<f32>()?);
        Ok(tvec!(Tensor::from_shape(&self.shape(), &output)?.into()))
    }
}

impl TypedOp for FastConvolution {
    as_op!();

    fn output_facts(&self, inputs: &[&TypedFact]) -> TractResult<TVec<TypedFact>> {
        Ok(tvec!(inputs[0].datum_type.fact(self.shape())))
    }
}
