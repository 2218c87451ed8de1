//! Detectors: what is refused of an ONNX file before anything is computed, and what may lie beside
//! it.

use super::say;
use bathyscope_objects::model;

pub(super) fn model(bytes: &[u8]) {
    if let Err(error) = model::screened(bytes, None) {
        say(&error);
    }
}

pub(super) fn sidecar(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Err(error) = model::screened(&small_model(), Some(&text)) {
        say(&error);
    }
}

/// Field of a protobuf message that holds bytes.
fn field(number: u8, data: &[u8]) -> Vec<u8> {
    let mut bytes = vec![number << 3 | 2];
    let mut length = data.len();
    while length >= 0x80 {
        bytes.push(length as u8 | 0x80);
        length >>= 7;
    }
    bytes.push(length as u8);
    bytes.extend(data);
    bytes
}

/// A number as a field.
fn number(field: u8, value: u8) -> Vec<u8> {
    vec![field << 3, value]
}

/// A model that adds a weight to its picture, reshapes and pools it: graph, input, output, weights,
/// opset and a note.
fn small_model() -> Vec<u8> {
    let shape: Vec<u8> =
        [1, 3, 64, 64].iter().flat_map(|size| field(1, &number(1, *size))).collect();
    let float = |shape: &[u8]| field(2, &field(1, &[number(1, 1), field(2, shape)].concat()));
    let value = |name: &[u8], kind: &[u8]| [field(1, name), kind.to_vec()].concat();
    let node = |inputs: &[&[u8]], output: &[u8], layer: &[u8], attributes: &[Vec<u8>]| {
        let mut bytes: Vec<u8> = inputs.iter().flat_map(|name| field(1, name)).collect();
        bytes.extend([field(2, output), field(4, layer)].concat());
        bytes.extend(attributes.iter().flat_map(|attribute| field(5, attribute)));
        field(1, &bytes)
    };
    let whole_numbers = |name: &[u8], values: &[u8]| {
        let values: Vec<u8> = values.iter().flat_map(|value| number(8, *value)).collect();
        [field(1, name), values, vec![20 << 3 & 0x7F | 0x80, 1, 7]].concat()
    };
    let weight =
        [number(1, 1), number(2, 1), field(4, &1.0_f32.to_le_bytes()), field(8, b"w")].concat();
    let sizes = [number(1, 4), number(2, 7), field(7, &[1, 3, 64, 64]), field(8, b"s")].concat();
    let pool = [whole_numbers(b"kernel_shape", &[2, 2]), whole_numbers(b"strides", &[2, 2])];
    let graph = [
        node(&[b"x", b"w"], b"a", b"Add", &[]),
        node(&[b"a", b"s"], b"b", b"Reshape", &[]),
        node(&[b"b"], b"y", b"MaxPool", &pool),
        field(2, b"g"),
        field(5, &weight),
        field(5, &sizes),
        field(11, &value(b"x", &float(&shape))),
        field(12, &value(b"y", &field(2, &field(1, &number(1, 1))))),
    ];
    let note = [field(1, b"names"), field(2, b"{0: 'rock', 1: 'tyre'}")].concat();
    let opset = field(8, &number(2, 13));
    [number(1, 8), field(7, &graph.concat()), opset, field(14, &note)].concat()
}

pub(super) fn model_seeds() -> Vec<Vec<u8>> {
    vec![small_model()]
}

pub(super) fn sidecar_seeds() -> Vec<Vec<u8>> {
    let text = r#"{"family":"yolov4","names":["rock","tyre"],"input":{"width":64,"height":64,"scale":0.00392,"resize":"letterbox"},
        "thresholds":{"score":0.3,"iou":0.45,"name":0.5},"pixel_m":0.04,"calibration":[[0.1,0.2],[0.9,0.95]],
        "heads":[{"stride":32,"anchors":[[10,14],[23,27]]}]}"#;
    vec![text.as_bytes().to_vec(), b"{}".to_vec()]
}
