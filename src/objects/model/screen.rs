//! Checks the graph as the file describes it, before anything is computed from it.

use super::Unusable;
use super::sidecar::Metadata;
use std::collections::{HashMap, HashSet};
use tract_onnx::pb::tensor_proto::DataLocation;
use tract_onnx::pb::tensor_shape_proto::dimension::Value as Size;
use tract_onnx::pb::type_proto::{Tensor as TensorType, Value as Kind};
use tract_onnx::pb::{GraphProto, ModelProto, NodeProto, TensorProto, ValueInfoProto};

/// Greatest number of layers. The largest detectors have about a thousand.
const MOST_LAYERS: usize = 20_000;
/// Greatest number of elements of a shape that the file states.
const MOST_ELEMENTS: i64 = 1 << 27;
/// Greatest number of weights of a network: 512 MiB in f16, the largest file that is read.
const MOST_WEIGHTS: i64 = 1 << 28;
/// Greatest number of axes of a tensor. Detectors have six at most; the compilation takes time in
/// proportion to the square of the number of axes, or more.
const MOST_AXES: usize = 32;
/// Greatest number of pixels that a layer may gather into one.
const MOST_GATHERED: i64 = 1 << 16;
/// Layers whose output size depends on numbers in the file.
const GROWING: [&str; 18] = [
    "AveragePool",
    "BlackmanWindow",
    "ConstantLike",
    "ConstantOfShape",
    "ConvTranspose",
    "Expand",
    "EyeLike",
    "HammingWindow",
    "HannWindow",
    "MaxPool",
    "OneHot",
    "Pad",
    "RandomNormal",
    "RandomUniform",
    "Range",
    "Resize",
    "Tile",
    "Upsample",
];
/// Layers that are refused, each with the reason and the remedy.
const REFUSED: [(&str, &str); 6] = [
    ("If", "which holds two networks in one; export a plain detector, without what follows it"),
    (
        "NonMaxSuppression",
        "which drops overlapping boxes inside the network; export it again without (nms=False, no --end2end): overlapping \
         boxes are dropped here",
    ),
    ("Upsample", "which ONNX has given up; export it again with opset 11 or later"),
    ("Loop", "which may never end; export a plain detector, without what follows it"),
    ("Scan", "which may never end; export a plain detector, without what follows it"),
    ("SequenceMap", "which may never end; export a plain detector, without what follows it"),
];

/// The input as the file declares it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Declared {
    /// The input's name.
    pub name: String,
    /// Sizes of the input; `None` where the file leaves a size open.
    pub shape: [Option<usize>; 4],
    /// ONNX's number of the element type.
    pub element: i32,
}

/// Checks the graph. Returns its input.
///
/// # Errors
/// When the graph is none, is too large, or has a layer or an input that cannot be used.
pub(super) fn screen(proto: &ModelProto) -> Result<Declared, Unusable> {
    let graph = proto.graph.as_ref().ok_or(Unusable::NotOnnx)?;
    if graph.node.is_empty() || graph.output.is_empty() {
        return Err(Unusable::NotOnnx);
    }
    screen_graph(graph, &mut 0)?;
    declared_input(graph)
}

/// Returns the key-value pairs of the file.
pub(super) fn metadata(proto: &ModelProto) -> Metadata {
    let pairs = proto.metadata_props.iter();
    Metadata(pairs.map(|pair| (pair.key.clone(), pair.value.clone())).collect())
}

/// Returns the names of the files that hold weights outside the model file, sorted.
pub(super) fn outside_files(proto: &ModelProto) -> Vec<String> {
    let mut names: Vec<String> = (proto.graph.iter().flat_map(tensors))
        .filter(|tensor| tensor.data_location == Some(DataLocation::External as i32))
        .flat_map(|tensor| &tensor.external_data)
        .filter(|entry| entry.key == "location")
        .map(|entry| entry.value.clone())
        .collect();
    names.sort();
    names.dedup();
    names
}

fn tensors(graph: &GraphProto) -> impl Iterator<Item = &TensorProto> {
    let constants = graph.node.iter().flat_map(|node| &node.attribute);
    graph.initializer.iter().chain(constants.filter_map(|attribute| attribute.t.as_ref()))
}

fn screen_graph(graph: &GraphProto, layers: &mut usize) -> Result<(), Unusable> {
    *layers += graph.node.len();
    Unusable::unless(*layers <= MOST_LAYERS, || format!("it has more than {MOST_LAYERS} layers"))?;
    screen_weights(graph)?;
    let listed = graph.input.iter().chain(&graph.output);
    for declared in listed.chain(&graph.value_info) {
        let shape = tensor_type(declared).and_then(|tensor| tensor.shape.as_ref());
        check_axes(&declared.name, shape.map_or(0, |shape| shape.dim.len()))?;
    }
    let (sizes, lists) = (written_sizes(graph), list_lengths(graph));
    for node in &graph.node {
        if let Some((layer, why)) = REFUSED.iter().find(|(layer, _)| *layer == node.op_type) {
            return Err(Unusable::Layer { layer: (*layer).to_owned(), why });
        }
        screen_reshaping(node, &lists)?;
        if GROWING.contains(&node.op_type.as_str()) {
            screen_growth(node, &sizes)?;
        }
        for attribute in &node.attribute {
            let inner = attribute.g.iter().chain(&attribute.graphs);
            inner.into_iter().try_for_each(|inner| screen_graph(inner, layers))?;
        }
    }
    Ok(())
}

/// Refuses a graph with more weights than the largest file could hold. Several weights may share
/// the same bytes of a file beside the model, and each is unpacked on its own.
fn screen_weights(graph: &GraphProto) -> Result<(), Unusable> {
    let mut in_all = 0_i64;
    for weight in tensors(graph) {
        check_axes(&weight.name, weight.dims.len())?;
        let mut sizes = weight.dims.iter();
        let elements = sizes.try_fold(1_i64, |product, &size| product.checked_mul(size.max(0)));
        in_all = in_all.saturating_add(elements.unwrap_or(i64::MAX));
        Unusable::unless(in_all <= MOST_WEIGHTS, || {
            format!("with `{}` it has more than {MOST_WEIGHTS} weights", weight.name)
        })?;
    }
    Ok(())
}

fn tensor_type(declared: &ValueInfoProto) -> Option<&TensorType> {
    let Kind::TensorType(tensor) = declared.r#type.as_ref()?.value.as_ref()?;
    Some(tensor)
}

/// Refuses a tensor with more axes than any tensor of a detector.
pub(super) fn check_axes(name: &str, axes: usize) -> Result<(), Unusable> {
    Unusable::unless(axes <= MOST_AXES, || format!("its tensor `{name}` has {axes} axes"))
}

/// Refuses a layer that makes a tensor of too many axes: the shape of the tensor is a list in the
/// file, with one number for each axis.
fn screen_reshaping(node: &NodeProto, lists: &HashMap<&str, usize>) -> Result<(), Unusable> {
    let shape = match node.op_type.as_str() {
        "ConstantOfShape" => 0,
        "Expand" | "Reshape" | "Squeeze" | "Tile" | "Unsqueeze" => 1,
        _ => usize::MAX,
    };
    let given = node.input.get(shape);
    let given = given.and_then(|name| lists.get(name.as_str()).copied());
    let written = node.attribute.iter().map(|attribute| match attribute.name.as_str() {
        "axes" | "perm" | "shape" => attribute.ints.len(),
        _ => 0,
    });
    let axes = written.chain(given).max().unwrap_or(0);
    check_axes(node.output.first().map_or("", String::as_str), axes)
}

/// Returns the lengths of the lists that the graph holds, by name.
fn list_lengths(graph: &GraphProto) -> HashMap<&str, usize> {
    let weights = graph.initializer.iter();
    let weights = weights.map(|held| (held.name.as_str(), list_length(held)));
    let constants = graph.node.iter().filter_map(|node| {
        let lengths = node.attribute.iter().map(|attribute| match &attribute.t {
            Some(tensor) => list_length(tensor),
            None => attribute.ints.len(),
        });
        Some((node.output.first()?.as_str(), lengths.max()?))
    });
    weights.chain(constants).collect()
}

/// Returns the length of a tensor of one axis; 0 for any other tensor.
fn list_length(tensor: &TensorProto) -> usize {
    match tensor.dims.as_slice() {
        [length] => usize::try_from(*length).unwrap_or(0),
        _ => 0,
    }
}

/// Refuses sizes in the file that are too large. Sizes that are computed from other values are
/// checked once they are known.
fn screen_growth(node: &NodeProto, sizes: &HashMap<&str, Vec<i64>>) -> Result<(), Unusable> {
    let attributes = node.attribute.iter().map(|attribute| {
        let gathers = attribute.name == "kernel_shape";
        let most = if gathers { MOST_GATHERED } else { MOST_ELEMENTS };
        (&attribute.ints, most)
    });
    let inputs = node.input.iter().filter_map(|name| sizes.get(name.as_str()));
    for (sizes, most) in attributes.chain(inputs.map(|sizes| (sizes, MOST_ELEMENTS))) {
        let elements = sizes
            .iter()
            .filter(|&&size| size > 0)
            .try_fold(1_i64, |product, &size| product.checked_mul(size));
        Unusable::unless(elements.is_some_and(|elements| elements <= most), || {
            format!("its layer {} asks for a size of {sizes:?}", node.op_type)
        })?;
    }
    Ok(())
}

/// Returns the small whole-number tensors that the graph holds, by name; its shapes are among them.
fn written_sizes(graph: &GraphProto) -> HashMap<&str, Vec<i64>> {
    let weights = graph.initializer.iter().map(|held| (held.name.as_str(), held));
    let constants = graph.node.iter().filter_map(|node| {
        let tensor = node.attribute.iter().find_map(|attribute| attribute.t.as_ref())?;
        Some((node.output.first()?.as_str(), tensor))
    });
    weights
        .chain(constants)
        .map(|(name, tensor)| (name, whole_numbers(tensor)))
        .filter(|(_, numbers)| !numbers.is_empty())
        .collect()
}

/// Returns the whole numbers of a small tensor, from either of the fields that can hold them; none
/// of a large tensor, which is data and no shape.
fn whole_numbers(tensor: &TensorProto) -> Vec<i64> {
    const INT64: i32 = 7;
    const LONGEST: usize = 8;
    let count = tensor.int64_data.len() + tensor.raw_data.len() / 8;
    if tensor.data_type != INT64 || count > LONGEST {
        return Vec::new();
    }
    let (raw, _) = tensor.raw_data.as_chunks::<8>();
    let raw = raw.iter().map(|bytes| i64::from_le_bytes(*bytes));
    raw.chain(tensor.int64_data.iter().copied()).collect()
}

/// Returns the only input that is no weight.
///
/// # Errors
/// When there is no such input or several, or it is not a tensor of four axes.
fn declared_input(graph: &GraphProto) -> Result<Declared, Unusable> {
    let weights: HashSet<&str> =
        graph.initializer.iter().map(|tensor| tensor.name.as_str()).collect();
    let open = |input: &&ValueInfoProto| !weights.contains(input.name.as_str());
    let inputs: Vec<&ValueInfoProto> = graph.input.iter().filter(open).collect();
    let [input] = inputs[..] else {
        return Err(Unusable::Input(format!("is {} inputs", inputs.len())));
    };
    let tensor = tensor_type(input).ok_or_else(|| Unusable::Input("is no tensor".to_owned()))?;
    let sizes: Vec<Option<usize>> = tensor
        .shape
        .iter()
        .flat_map(|shape| &shape.dim)
        .map(|size| match size.value {
            Some(Size::DimValue(size)) if size > 0 => Some(usize::try_from(size).unwrap_or(0)),
            _ => None,
        })
        .collect();
    let text = || {
        let words = sizes.iter().map(|size| size.map_or("?".to_owned(), |size| size.to_string()));
        format!("is [{}]", words.collect::<Vec<_>>().join(", "))
    };
    let shape =
        <[Option<usize>; 4]>::try_from(sizes.clone()).map_err(|_| Unusable::Input(text()))?;
    Ok(Declared { name: input.name.clone(), shape, element: tensor.elem_type })
}
