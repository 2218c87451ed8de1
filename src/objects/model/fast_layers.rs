//! Replaces layers of a network that tract computes slowly by faster ones of our own: convolutions
//! of 3 x 3 ([`Convolution`]) and maxima over windows ([`max_pool`]).

use super::winograd::Convolution;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;
use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::cnn::{Conv, KernelFormat, MaxPool, PoolSpec};
use tract_onnx::tract_core::ops::nn::DataFormat;

/// Greatest number of weights that all fast layers together keep, 128 MiB: they keep four times the
/// weights of the layers that they replace. Layers beyond this limit are not replaced.
const MOST_WEIGHTS: usize = 1 << 25;

/// Replaces the slow layers of a network, in the order in which they run.
pub(super) fn replace_layers(model: &mut TypedModel) -> TractResult<()> {
    let mut left = MOST_WEIGHTS;
    for node in model.eval_order()? {
        let node = model.node(node);
        let layer = match convolution(model, node, left)? {
            Some(layer) => Some(layer),
            None => pool(model, node)?,
        };
        let Some(layer) = layer else {
            continue;
        };
        left -= layer.weights();
        let input = &node.inputs[..1];
        TypedModelPatch::replace_single_op(model, node, input, layer)?.apply(model)?;
    }
    Ok(())
}

/// Creates the fast layer for a node; `None` if the node is no convolution of 3 x 3 that
/// [`Convolution`] can compute, or the layer would keep more than `most` numbers.
fn convolution(
    model: &TypedModel,
    node: &TypedNode,
    most: usize,
) -> TractResult<Option<FastLayer>> {
    let Some(conv) = node.op_as::<Conv>().filter(|conv| is_of_the_kind(conv)) else {
        return Ok(None);
    };
    let [input, weights, bias] = &model.node_input_facts(node.id)?[..] else {
        return Ok(None);
    };
    let (Some([_, height, width]), Some(weights), Some(bias)) =
        (picture(&conv.pool_spec, input), &weights.konst, &bias.konst)
    else {
        return Ok(None);
    };
    let padding = conv.pool_spec.computed_padding(&[height, width]);
    if !padding.iter().all(|side| (side.pad_before, side.pad_after) == (1, 1)) {
        return Ok(None);
    }
    let channels = [conv.pool_spec.input_channels, conv.pool_spec.output_channels];
    let are_f32 = [weights, bias].iter().all(|constant| constant.datum_type() == f32::datum_type());
    if !are_f32 || Convolution::weights_of(channels) > most {
        return Ok(None);
    }
    let bias = bias.try_as_plain_ram()?.as_slice::<f32>()?;
    let bias = match bias {
        [single] => vec![*single; channels[1]],
        each => each.to_vec(),
    };
    let weights = weights.try_as_plain_ram()?.as_slice::<f32>()?;
    let convolution = Convolution::new(weights, &bias, channels, [height, width]);
    Ok(convolution.map(|convolution| FastLayer {
        shape: shape(&conv.pool_spec, convolution.output_shape()),
        computation: Arc::new(Computation::Convolution(convolution)),
    }))
}

/// Creates the fast layer for a maximum over windows; `None` if the node is none, or is not of two
/// axes without dilation.
fn pool(model: &TypedModel, node: &TypedNode) -> TractResult<Option<FastLayer>> {
    let Some(pool) = node.op_as::<MaxPool>() else {
        return Ok(None);
    };
    let spec = &pool.pool_spec;
    let input = model.node_input_facts(node.id)?[0];
    let is_of_the_kind = pool.with_index_outputs.is_none()
        && spec.kernel_shape.len() == 2
        && spec.dilations().iter().all(|step| *step == 1);
    let (Some([channels, height, width]), true) = (picture(spec, input), is_of_the_kind) else {
        return Ok(None);
    };
    let padding = spec.computed_padding(&[height, width]);
    let axes = [0, 1].map(|axis| PoolAxis {
        from: padding[axis].deconvoluted,
        into: padding[axis].convoluted,
        window: spec.kernel_shape[axis],
        step: spec.stride(axis),
        before: padding[axis].pad_before,
    });
    Ok(Some(FastLayer {
        shape: shape(spec, [channels, axes[0].into, axes[1].into]),
        computation: Arc::new(Computation::MaxPool(channels, axes)),
    }))
}

/// Returns the channels, rows and columns of a picture of f32 that is stored channel by channel;
/// `None` for any other input.
fn picture(spec: &PoolSpec, input: &TypedFact) -> Option<[usize; 3]> {
    if input.datum_type != f32::datum_type() {
        return None;
    }
    match (spec.data_format, input.shape.as_concrete()?) {
        (DataFormat::NCHW, &[1, channels, height, width])
        | (DataFormat::CHW, &[channels, height, width]) => Some([channels, height, width]),
        _ => None,
    }
}

fn shape(spec: &PoolSpec, shape: [usize; 3]) -> TVec<usize> {
    let batch = spec.data_format.has_n().then_some(1);
    batch.into_iter().chain(shape).collect()
}

/// Returns true if a convolution is 3 x 3 with steps of one, without groups, quantisation or
/// dilation.
fn is_of_the_kind(conv: &Conv) -> bool {
    let spec = &conv.pool_spec;
    conv.group == 1
        && conv.q_params.is_none()
        && conv.kernel_fmt == KernelFormat::OIHW
        && spec.kernel_shape[..] == [3, 3]
        && spec.strides().iter().all(|step| *step == 1)
        && spec.dilations().iter().all(|step| *step == 1)
}

enum Computation {
    Convolution(Convolution),
    MaxPool(usize, [PoolAxis; 2]),
}

/// A fast layer in tract's graph.
#[derive(Clone)]
struct FastLayer {
    computation: Arc<Computation>,
    shape: TVec<usize>,
}

impl FastLayer {
    /// Returns the count of numbers that the layer keeps.
    fn weights(&self) -> usize {
        match &*self.computation {
            Computation::Convolution(convolution) => convolution.weights(),
            Computation::MaxPool(..) => 0,
        }
    }
}

impl fmt::Debug for FastLayer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_tuple("FastLayer").field(&self.shape).finish()
    }
}

impl PartialEq for FastLayer {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.computation, &other.computation)
    }
}

impl Eq for FastLayer {}

impl Op for FastLayer {
    fn name(&self) -> StaticName {
        match &*self.computation {
            Computation::Convolution(_) => "FastConvolution".into(),
            Computation::MaxPool(..) => "FastMaxPool".into(),
        }
    }

    op_as_typed_op!();
}

impl EvalOp for FastLayer {
    op_out_of_plan!();

    fn eval(&self, _ctx: &EvalContext, inputs: TVec<TValue>) -> TractResult<TVec<TValue>> {
        let input = args_1!(inputs);
        let input = input.try_as_plain_ram()?.as_slice::<f32>()?;
        let output = match &*self.computation {
            Computation::Convolution(convolution) => convolution.run(input),
            Computation::MaxPool(channels, axes) => max_pool(input, *channels, *axes),
        };
        let output = tract_ndarray::ArrayD::from_shape_vec(&self.shape[..], output)?;
        Ok(tvec!(output.into_tensor().into()))
    }
}

impl TypedOp for FastLayer {
    as_op!();

    fn output_facts(&self, inputs: &[&TypedFact]) -> TractResult<TVec<TypedFact>> {
        Ok(tvec!(inputs[0].datum_type.fact(&self.shape)))
    }
}

/// A window that moves along one axis (rows or columns) of a picture.
#[derive(Clone, Copy, Debug)]
struct PoolAxis {
    /// Length of the input along the axis.
    from: usize,
    /// Length of the output along the axis.
    into: usize,
    /// Length of the window.
    window: usize,
    /// Step from one window to the next.
    step: usize,
    /// Length by which the first window begins before the picture.
    before: usize,
}

impl PoolAxis {
    /// Returns the part of the picture that the window of output number `place` covers.
    fn covered(&self, place: usize) -> Range<usize> {
        let start = place * self.step;
        let end = (start + self.window).saturating_sub(self.before);
        start.saturating_sub(self.before).min(self.from)..end.min(self.from)
    }

    /// Returns true if the windows are pairs, one after the other, all of them within the picture.
    fn is_in_pairs(&self) -> bool {
        (self.window, self.step, self.before) == (2, 2, 0) && self.into == self.from / 2
    }
}

/// Returns the greatest number in each window, channel by channel; minus infinity for a window that
/// covers no part of the picture.
fn max_pool(input: &[f32], channels: usize, [rows, columns]: [PoolAxis; 2]) -> Vec<f32> {
    let mut output = Vec::with_capacity(channels * rows.into * columns.into);
    let mut greatest = vec![0.0; columns.from];
    for picture in input.chunks_exact(rows.from * columns.from) {
        for row in 0..rows.into {
            // The maximum is taken down the columns first, several columns at once, and then along
            // the row.
            greatest.fill(f32::NEG_INFINITY);
            for y in rows.covered(row) {
                let line = &picture[y * columns.from..][..columns.from];
                for (greatest, value) in greatest.iter_mut().zip(line) {
                    *greatest = greatest.max(*value);
                }
            }
            if columns.is_in_pairs() {
                let pairs = greatest.as_chunks::<2>().0.iter();
                output.extend(pairs.map(|[one, other]| one.max(*other)));
                continue;
            }
            output.extend((0..columns.into).map(|column| {
                let covered = greatest[columns.covered(column)].iter();
                covered.copied().fold(f32::NEG_INFINITY, f32::max)
            }));
        }
    }
    output
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_hold_their_greatest_number_whatever_their_size_step_and_border() {
        // The last window of an odd side may be cut: some networks round the output size up.
        let axis = |from: usize, window: usize, step: usize, before: usize, cut: bool| PoolAxis {
            from,
            into: (from + 2 * before - window + usize::from(cut) * (step - 1)) / step + 1,
            window,
            step,
            before,
        };
        let number = |at: usize| ((at * 7919) % 1009) as f32 - 500.0;
        for (window, step, before, cut) in [
            (2, 2, 0, false),
            (2, 2, 0, true),
            (5, 1, 2, false),
            (3, 2, 1, false),
            (1, 1, 0, false),
        ] {
            let (rows, columns) =
                (axis(9, window, step, before, cut), axis(15, window, step, before, cut));
            let input: Vec<f32> = (0..2 * 9 * 15).map(number).collect();
            let output = max_pool(&input, 2, [rows, columns]);
            assert_eq!(output.len(), 2 * rows.into * columns.into);
            for (at, found) in output.iter().enumerate() {
                let (channel, row) =
                    (at / (rows.into * columns.into), at / columns.into % rows.into);
                let column = at % columns.into;
                let mut expected = f32::NEG_INFINITY;
                for (dy, dx) in (0..window).flat_map(|dy| (0..window).map(move |dx| (dy, dx))) {
                    let [y, x] = [row * step + dy, column * step + dx];
                    if (before..before + 9).contains(&y) && (before..before + 15).contains(&x) {
                        let at = (channel * 9 + y - before) * 15 + x - before;
                        expected = expected.max(input[at]);
                    }
                }
                assert_eq!(*found, expected, "{window} {step} {before}: {at}");
            }
        }
    }
}
