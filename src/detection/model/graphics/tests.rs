//! What a card computes beside what the processor does, on the driver that draws in software.

use super::choice::{Choice, Found, MANY, Placed, card, difference, trial_number};
use super::*;
use crate::detection::model::tract::{self, Network};
use crate::detection::model::{Inference, Output, screen};
use std::sync::Mutex;
use tract_onnx::prelude::*;
use tract_onnx::tract_core::ops::array::{Slice, TypedConcat};
use tract_onnx::tract_core::ops::cnn::{Conv, KernelFormat, MaxPool, PaddingSpec, PoolSpec};
use tract_onnx::tract_core::ops::math::{add, mul, square};
use tract_onnx::tract_core::ops::nn::{DataFormat, NearestUpsample, leaky_relu, sigmoid};

const SHAPE: [usize; 4] = [1, 3, 17, 22];

/// Numbers between -1 and 1.
fn numbers(shape: &[usize], seed: usize) -> Arc<Tensor> {
    let count = shape.iter().product();
    let numbers = (0..count).map(|at| 2.0 * trial_number(at + 7919 * seed) - 1.0);
    let numbers = tract_ndarray::ArrayD::from_shape_vec(shape, numbers.collect());
    numbers.expect("as many as the shape has").into_arc_tensor()
}

fn spec([inputs, outputs]: [usize; 2], side: usize, step: usize) -> PoolSpec {
    let border = tvec![side / 2; 2];
    PoolSpec {
        data_format: DataFormat::NCHW,
        kernel_shape: tvec![side; 2],
        padding: PaddingSpec::Explicit(border.clone(), border),
        dilations: None,
        strides: Some(tvec![step; 2]),
        input_channels: inputs,
        output_channels: outputs,
    }
}

fn convolution(
    graph: &mut TypedModel,
    input: OutletId,
    [inputs, outputs]: [usize; 2],
    side: usize,
    step: usize,
) -> TractResult<OutletId> {
    let seed = graph.nodes().len();
    let weights = numbers(&[outputs, inputs, side, side], seed);
    let weights = graph.add_const(format!("weights {seed}"), weights)?;
    let bias = graph.add_const(format!("bias {seed}"), numbers(&[outputs], seed + 1))?;
    let conv = Conv {
        pool_spec: spec([inputs, outputs], side, step),
        kernel_fmt: KernelFormat::OIHW,
        group: 1,
        q_params: None,
    };
    let made = graph.wire_node(format!("conv {seed}"), conv, &[input, weights, bias])?;
    Ok(made[0])
}

/// A network with every kind of layer that a card knows. Two outputs; one of them is read by a layer, too.
fn every_layer() -> TractResult<TypedModel> {
    let mut graph = TypedModel::default();
    let input = graph.add_source("input", f32::fact(SHAPE))?;
    let halved = convolution(&mut graph, input, [3, 70], 3, 2)?;
    let halved = graph.wire_node("leaky", leaky_relu(0.1), &[halved])?[0];
    let other = convolution(&mut graph, halved, [70, 70], 1, 1)?;
    let share = graph.wire_node("share", sigmoid(), &[other])?[0];
    let product = graph.wire_node("silu", mul(), &[other, share])?[0];
    let sum = graph.wire_node("sum", add(), &[halved, product])?[0];
    let pool = MaxPool {
        pool_spec: spec([70, 70], 5, 1),
        with_index_outputs: None,
    };
    let pooled = graph.wire_node("pool", pool, &[sum])?[0];
    let bright = graph.wire_node("bright", sigmoid(), &[pooled])?[0];
    let times = graph.wire_node("times", mul(), &[bright, sum])?[0];
    let part = graph.wire_node("part", Slice::new(1, 30, 70), &[times])?[0];
    let both = graph.wire_node("both", TypedConcat { axis: 1 }, &[part, halved])?[0];
    let scales = tvec![1, 1, 2, 3];
    let large = graph.wire_node("large", NearestUpsample { scales }, &[both])?[0];
    let seen = convolution(&mut graph, large, [110, 5], 3, 1)?;
    let gate = graph.wire_node("gate", sigmoid(), &[seen])?[0];
    // The card does not know it.
    let square = graph.wire_node("square", square(), &[gate])?[0];
    graph.select_output_outlets(&[square, pooled])?;
    Ok(graph)
}

fn named(graph: TypedModel) -> Network {
    let names = ["one", "other"].map(str::to_owned).to_vec();
    Network::new(graph, names, SHAPE).expect("a network")
}

fn any_card() -> Arc<Card> {
    let card = card(Choice::Software);
    card.expect("a graphics driver; the tests need one")
}

#[test]
fn every_layer_that_a_card_knows_is_computed_as_by_the_processor() {
    let graph = every_layer().expect("a graph");
    let processor = named(graph.clone());
    let mut on_card = graph.clone();
    replace_layers(&mut on_card, any_card())
        .expect("a whole graph")
        .expect("layers that it knows");
    let left: Vec<_> = on_card.nodes().iter().map(|node| node.op.name()).collect();
    assert_eq!(
        left.len(),
        3,
        "the input, the card and the square: {left:?}"
    );
    let by_card = named(on_card);
    for seed in 0..3 {
        let input = numbers(&SHAPE, seed);
        let input = input.try_as_plain_ram().expect("numbers");
        let input = input.as_slice::<f32>().expect("numbers").to_vec();
        let expected = processor.run(input.clone()).expect("outputs");
        let found = by_card.run(input).expect("outputs");
        assert_ne!(expected[0].values, expected[1].values);
        let share = difference(&expected, &found);
        assert!(share < 1e-4, "picture {seed}: {share}");
    }
}

#[test]
fn what_is_no_number_differs() {
    let output = |values: [f32; 2]| Output {
        name: String::new(),
        shape: vec![2],
        values: values.to_vec(),
    };
    let of = |found: [f32; 2]| difference(&[output([2.0, -4.0])], &[output(found)]);
    assert_eq!([of([2.0, -4.0]), of([2.0, -3.0])], [0.0, 0.25]);
    assert_eq!(of([f32::NAN, -4.0]), f32::INFINITY);
    assert_eq!(of([2.0, f32::INFINITY]), f32::INFINITY);
}

#[test]
fn the_shipped_network_is_computed_by_a_card() {
    const ONNX: &[u8] = include_bytes!("../../../../assets/detector/default.onnx");
    let proto = tract::parse(ONNX).expect("a model");
    let declared = screen::screen(&proto).expect("a harmless model");
    let shape = [1, 1, 416, 416];
    let graph = tract::graph(&proto, &declared, shape, None).expect("a graph");
    let network = Network::of(graph.clone(), &proto, shape).expect("a network");
    let placed = Placed::new(network, || Ok(graph), Choice::Software);
    assert_eq!(placed.runs_on(), None);
    placed.prepare(1);
    let said = placed.runs_on().expect("a card");
    assert!(said.starts_with("run by "), "{said}");
    assert!(!said.contains("processor"), "{said}");
    let outputs = placed.run(vec![0.5; 416 * 416]).expect("outputs");
    assert_eq!(outputs.len(), 2);
}

#[test]
fn a_card_that_knows_none_of_the_layers_or_fails_leaves_them_to_the_processor() {
    let mut graph = TypedModel::default();
    let input = graph
        .add_source("input", f32::fact(SHAPE))
        .expect("an input");
    let squared = graph
        .wire_node("square", square(), &[input])
        .expect("a layer");
    let seen = convolution(&mut graph, squared[0], [3, 4], 3, 1).expect("a layer");
    graph.select_output_outlets(&[seen]).expect("an output");
    let input = vec![0.5; SHAPE.iter().product()];
    let expected = named(graph.clone()).run(input.clone()).expect("outputs");

    let unknown = graph.clone();
    let placed = Placed::new(named(graph.clone()), || Ok(unknown), Choice::Software);
    placed.prepare(1);
    let said = placed.runs_on().expect("a card");
    assert!(said.starts_with("run by the processor, not by "), "{said}");
    assert!(
        said.ends_with("it does not know the first layers, or has no room for them"),
        "{said}"
    );
    assert_eq!(placed.run(input.clone()).expect("outputs"), expected);

    // Of another shape, so that it fails.
    let broken = Network::new(graph.clone(), Vec::new(), [1, 3, 5, 5]).expect("a network");
    let found = Found {
        name: "a card".to_owned(),
        network: Some(broken),
        fault: Mutex::default(),
    };
    let fails = Placed::new(named(graph), || unreachable!(), Choice::Worthwhile).with(found);
    assert_eq!(fails.runs_on().as_deref(), Some("run by a card"));
    assert_eq!(fails.run(input).expect("outputs"), expected);
    let said = fails.runs_on().expect("a card");
    assert!(
        said.starts_with("run by the processor, not by a card: "),
        "{said}"
    );
}

#[test]
fn no_card_is_looked_for_before_few_pictures() {
    let mut graph = TypedModel::default();
    let input = graph
        .add_source("input", f32::fact(SHAPE))
        .expect("an input");
    let seen = convolution(&mut graph, input, [3, 4], 3, 1).expect("a layer");
    graph.select_output_outlets(&[seen]).expect("an output");
    let placed = Placed::new(named(graph), || unreachable!(), Choice::Worthwhile);
    placed.prepare(MANY - 1);
    assert_eq!(placed.runs_on(), None);
    let input = vec![0.5; SHAPE.iter().product()];
    assert_eq!(placed.run(input).expect("outputs").len(), 1);
}

#[test]
fn weights_that_would_be_filled_up_without_end_are_left_to_the_processor() {
    // 2.4 MB of them, 64 times as much for a card.
    const CHANNELS: usize = 600_000;
    let mut graph = TypedModel::default();
    let input = graph
        .add_source("input", f32::fact([1, CHANNELS, 1, 1]))
        .expect("an input");
    let seen = convolution(&mut graph, input, [CHANNELS, 1], 1, 1).expect("a layer");
    graph.select_output_outlets(&[seen]).expect("an output");
    assert!(layers::Layers::of(&graph).expect("a whole graph").is_none());
}

#[test]
fn no_room_is_left_beside_buffers_of_more_numbers_than_can_be_counted() {
    let mut program = program::Program::default();
    assert!(program.has_room(1));
    program.make(usize::MAX);
    program.make(2);
    assert!(!program.has_room(1));
}
