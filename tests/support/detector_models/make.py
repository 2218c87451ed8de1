"""Makes the small ONNX files beside this script, and expected.json: what each finds in one picture.

Every network pools the picture over the cells of its grids and mixes the colours once, which is enough to give each cell
its own numbers; what counts is that its outputs are laid out as that family's exporter lays them out. The expected boxes
come from onnxruntime, OpenCV's resize and the decoding below, which is written from each project's own code and shares
nothing with the program's.

    pip install onnx==1.23.2 onnxruntime==1.31.1 numpy opencv-python-headless
    python make.py
"""

import json
import pathlib

import cv2
import numpy as np
import onnx
import onnxruntime
from onnx import TensorProto, helper, numpy_helper

HERE = pathlib.Path(__file__).parent
SIZE = 64
STRIDES = (8, 16, 32)
NAMES = ["rock", "tyre", "log"]
ANCHORS = {8: [(6, 8), (10, 7), (8, 14)], 16: [(16, 20), (24, 14), (18, 30)], 32: [(30, 40), (44, 28), (50, 50)]}
SCALE_XY = {8: 1.2, 16: 1.1, 32: 1.05}
SCORE, IOU = 0.35, 0.45
random = np.random.default_rng(7)


def picture():
    """96 x 80 pixels in colour; the test draws the same."""
    y, x, c = np.mgrid[0:80, 0:96, 0:3]
    return ((x * x // 9 + y * (5 + c) * 3 + c * 40 + (x * y) // 7) % 256).astype(np.uint8)


# ---- graphs -------------------------------------------------------------------------------------------------------------


class Graph:
    def __init__(self):
        self.nodes, self.weights, self.count = [], [], 0

    def add(self, op, *inputs, outputs=1, **attributes):
        self.count += 1
        names = [f"t{self.count}_{i}" for i in range(outputs)]
        self.nodes.append(helper.make_node(op, list(inputs), names, **attributes))
        return names[0] if outputs == 1 else names

    def const(self, value, dtype=np.float32):
        self.count += 1
        name = f"w{self.count}"
        self.weights.append(numpy_helper.from_array(np.asarray(value, dtype), name))
        return name

    def ints(self, *values):
        return self.const(values, np.int64)

    def head(self, source, stride, channels, gain=20.0, mid=0.5):
        """Pools over the cells of a grid and mixes three colours into `channels`."""
        pooled = self.add("AveragePool", source, kernel_shape=[stride, stride], strides=[stride, stride])
        # Centred on mid grey, so that both signs occur.
        weight = self.const(random.normal(0, gain, (channels, 3, 1, 1)))
        bias = self.const(-mid * np.asarray(numpy_helper.to_array(self.weights[-1])).sum((1, 2, 3)))
        return self.add("Conv", pooled, weight, bias)

    def save(self, name, outputs, input_shape=(1, 3, SIZE, SIZE), input_name="images", opset=13, metadata=None,
             value_info=(), element=TensorProto.FLOAT, source=None):
        for node in self.nodes:
            node.output[:] = [dict((a, b) for a, b, _ in outputs).get(o, o) for o in node.output]
            node.input[:] = [dict((a, b) for a, b, _ in outputs).get(o, o) for o in node.input]
        graph = helper.make_graph(
            self.nodes, name,
            [helper.make_tensor_value_info(input_name, element, input_shape)],
            [helper.make_tensor_value_info(new, element, shape) for _, new, shape in outputs],
            self.weights, value_info=list(value_info))
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", opset)], producer_name="handmade")
        model.ir_version = 8
        for key, value in (metadata or {}).items():
            model.metadata_props.add(key=key, value=value)
        onnx.save(model, HERE / f"{name}.onnx")
        return model


def cells(stride):
    """Column and row of each cell, row by row."""
    n = SIZE // stride
    rows, columns = np.mgrid[0:n, 0:n]
    return columns.ravel(), rows.ravel()


def flat(graph, tensor, rows, channels):
    """[1, A * K, h, w] to [1, A * h * w, K], the anchors outermost."""
    anchors = rows
    split = graph.add("Reshape", tensor, graph.ints(1, anchors, channels, -1))
    turned = graph.add("Transpose", split, perm=[0, 1, 3, 2])
    return graph.add("Reshape", turned, graph.ints(1, -1, channels))


def yolov4_outputs(graph, source, mish=False):
    """Tianxiaomo's and Darknet's decoding in the graph."""
    all_boxes, all_confs = [], []
    for stride in STRIDES:
        n = SIZE // stride
        raw = graph.head(source, stride, 3 * 8)
        if mish:
            raw = graph.add("Add", graph.add("Mish", raw), graph.const(-1.0))
        rows = flat(graph, raw, 3, 8)
        xy, wh, obj, cls = graph.add("Split", rows, graph.ints(2, 2, 1, 3), outputs=4, axis=2)
        columns, lines = cells(stride)
        grid = np.tile(np.stack([columns, lines], 1), (3, 1))[None]
        s = SCALE_XY[stride]
        xy = graph.add("Mul", graph.add("Sigmoid", xy), graph.const(s))
        xy = graph.add("Mul", graph.add("Add", xy, graph.const(grid - (s - 1) / 2)), graph.const(1 / n))
        anchors = np.repeat(np.array(ANCHORS[stride]), n * n, 0)[None] / SIZE
        wh = graph.add("Mul", graph.add("Exp", graph.add("Mul", wh, graph.const(0.3))), graph.const(anchors))
        half = graph.add("Mul", wh, graph.const(0.5))
        low, high = graph.add("Sub", xy, half), graph.add("Add", xy, half)
        all_boxes.append(graph.add("Concat", low, high, axis=2))
        all_confs.append(graph.add("Mul", graph.add("Sigmoid", obj), graph.add("Sigmoid", cls)))
    boxes = graph.add("Unsqueeze", graph.add("Concat", *all_boxes, axis=1), graph.ints(2))
    return boxes, graph.add("Concat", *all_confs, axis=1)


def yolov5_rows(graph, source, classes):
    """(2 s - 0.5 + cell) stride, (2 s)^2 anchor."""
    parts = []
    for stride in STRIDES:
        n = SIZE // stride
        rows = graph.add("Sigmoid", flat(graph, graph.head(source, stride, 3 * (5 + classes)), 3, 5 + classes))
        xy, wh, rest = graph.add("Split", rows, graph.ints(2, 2, 1 + classes), outputs=3, axis=2)
        columns, lines = cells(stride)
        grid = np.tile(np.stack([columns, lines], 1), (3, 1))[None]
        xy = graph.add("Mul", graph.add("Add", graph.add("Mul", xy, graph.const(2.0)), graph.const(grid - 0.5)),
                       graph.const(float(stride)))
        twice = graph.add("Mul", wh, graph.const(2.0))
        anchors = np.repeat(np.array(ANCHORS[stride]), n * n, 0)[None]
        wh = graph.add("Mul", graph.add("Mul", twice, twice), graph.const(anchors))
        parts.append(graph.add("Concat", xy, wh, rest, axis=2))
    return graph.add("Concat", *parts, axis=1)


def yolov8_columns(graph, source, classes, dtype=np.float32):
    """Centre, size in pixels, then scores, a column a cell."""
    parts = []
    for stride in STRIDES:
        n = SIZE // stride
        raw = graph.add("Reshape", graph.head(source, stride, 4 + classes), graph.ints(1, 4 + classes, -1))
        xy, wh, cls = graph.add("Split", raw, graph.ints(2, 2, classes), outputs=3, axis=1)
        columns, lines = cells(stride)
        grid = np.stack([columns, lines], 0)[None] + 0.5
        xy = graph.add("Mul", graph.add("Add", graph.add("Tanh", xy), graph.const(grid)), graph.const(float(stride)))
        wh = graph.add("Mul", graph.add("Sigmoid", wh), graph.const(4.0 * stride))
        parts.append(graph.add("Concat", xy, wh, graph.add("Sigmoid", cls), axis=1))
    return graph.add("Concat", *parts, axis=2)


def yolox_rows(graph, source, classes):
    parts = []
    for stride in STRIDES:
        rows = flat(graph, graph.head(source, stride, 5 + classes, gain=10.0 / 255, mid=127.5), 1, 5 + classes)
        box, rest = graph.add("Split", rows, graph.ints(4, 1 + classes), outputs=2, axis=2)
        parts.append(graph.add("Concat", box, graph.add("Sigmoid", rest), axis=2))
    return graph.add("Concat", *parts, axis=1)


# ---- what they find -----------------------------------------------------------------------------------------------------


def resized(image, way):
    """The input's pixels as float32, and how to get back: (gain x, gain y, pad x, pad y)."""
    image = image.astype(np.float32)
    h, w = image.shape[:2]
    if way == "stretch":
        return cv2.resize(image, (SIZE, SIZE), interpolation=cv2.INTER_LINEAR), (SIZE / w, SIZE / h, 0, 0)
    gain = min(SIZE / w, SIZE / h)
    new = (round(w * gain), round(h * gain))
    small = cv2.resize(image, new, interpolation=cv2.INTER_LINEAR)
    dw, dh = SIZE - new[0], SIZE - new[1]
    left, top = (0, 0) if way == "top left" else (round(dw / 2 - 0.1), round(dh / 2 - 0.1))
    full = cv2.copyMakeBorder(small, top, dh - top, left, dw - left, cv2.BORDER_CONSTANT, value=(114, 114, 114))
    return full, (new[0] / w, new[1] / h, left, top)


def run(name, way, colour="rgb", scale=1 / 255, half=False):
    image, back = resized(picture(), way)
    if colour == "bgr":
        image = image[..., ::-1]
    tensor = np.ascontiguousarray((image * np.float32(scale)).transpose(2, 0, 1)[None], np.float32)
    session = onnxruntime.InferenceSession(str(HERE / f"{name}.onnx"), providers=["CPUExecutionProvider"])
    given = session.get_inputs()[0]
    if half:
        tensor = tensor.astype(np.float16)
    outputs = session.run(None, {given.name: tensor})
    return {o.name: v.astype(np.float32) for o, v in zip(session.get_outputs(), outputs)}, back


def sigma(x):
    return 1 / (1 + np.exp(-x))


def from_centres(centres):
    x, y, w, h = centres.T
    return np.stack([x - w / 2, y - h / 2, x + w / 2, y + h / 2], 1)


def kept(edges, scores, back, suppress=True):
    """Best class of each candidate, threshold, back to the picture, greedy suppression within classes."""
    gx, gy, px, py = back
    edges = (edges.astype(np.float64) - [px, py, px, py]) / [gx, gy, gx, gy]
    edges = np.clip(edges, 0, [96, 80, 96, 80])
    classes, best = scores.argmax(1), scores.max(1)
    assert np.abs(best - SCORE).min() > 1e-5, "a score on the threshold"
    area = (edges[:, 2] - edges[:, 0]) * (edges[:, 3] - edges[:, 1])
    order = [i for i in np.argsort(-best, kind="stable") if best[i] >= SCORE and area[i] > 0]
    found = []
    for i in order:
        hidden = False
        for j in found if suppress else []:
            if classes[i] != classes[j]:
                continue
            low, high = np.maximum(edges[i, :2], edges[j, :2]), np.minimum(edges[i, 2:], edges[j, 2:])
            shared = np.prod(np.maximum(high - low, 0))
            iou = shared / (area[i] + area[j] - shared)
            assert abs(iou - IOU) > 1e-5, "an overlap on the threshold"
            hidden |= iou > IOU
        if not hidden:
            found.append(i)
    return [[int(classes[i]), round(float(best[i]), 7), *[round(float(e), 5) for e in edges[i]]] for i in found]


def from_rows(values, back):
    return kept(from_centres(values[:, :4]), values[:, 4:5] * values[:, 5:], back)


def from_yolov4(outputs, back):
    return kept(outputs["boxes"][0, :, 0] * SIZE, outputs["confs"][0], back)


def from_columns(values, back):
    return kept(from_centres(values[:4].T), values[4:].T, back)


def from_raw_heads(outputs, back):
    edges, scores = [], []
    for stride, raw in zip(STRIDES, outputs.values()):
        n = SIZE // stride
        raw = raw.reshape(3, 8, n, n)
        s = SCALE_XY[stride]
        for a, (aw, ah) in enumerate(ANCHORS[stride]):
            for row in range(n):
                for column in range(n):
                    t = raw[a, :, row, column].astype(np.float64)
                    x = (column + s * sigma(t[0]) - (s - 1) / 2) * stride
                    y = (row + s * sigma(t[1]) - (s - 1) / 2) * stride
                    edges.append([x, y, np.exp(t[2]) * aw, np.exp(t[3]) * ah])
                    scores.append(sigma(t[4]) * sigma(t[5:]))
    return kept(from_centres(np.array(edges)), np.array(scores), back)


def from_yolox(values, back):
    grids, strides = [], []
    for stride in STRIDES:
        columns, rows = cells(stride)
        grids.append(np.stack([columns, rows], 1))
        strides.append(np.full((len(columns), 1), stride))
    grid, stride = np.concatenate(grids), np.concatenate(strides)
    centres = np.concatenate([(values[:, :2] + grid) * stride, np.exp(values[:, 2:4]) * stride], 1)
    return kept(from_centres(centres), values[:, 4:5] * values[:, 5:], back)


# ---- the files ----------------------------------------------------------------------------------------------------------


def usable():
    expected = {}
    names = str(dict(enumerate(NAMES)))

    g = Graph()
    boxes, confs = yolov4_outputs(g, "input")
    g.save("tianxiaomo", [(boxes, "boxes", (1, 252, 1, 4)), (confs, "confs", (1, 252, 3))], input_name="input")
    expected["tianxiaomo"] = from_yolov4(*run("tianxiaomo", "stretch"))

    # Darknet's own exporter: scores before boxes, Mish of opset 18.
    g = Graph()
    boxes, confs = yolov4_outputs(g, "frame", mish=True)
    g.save("darknet", [(confs, "confs", (1, 252, 3)), (boxes, "boxes", (1, 252, 1, 4))], input_name="frame", opset=18)
    expected["darknet"] = from_yolov4(*run("darknet", "stretch"))

    g = Graph()
    heads = [(g.head("input", s, 24, gain=10.0), f"yolo_{i}", (1, 24, SIZE // s, SIZE // s)) for i, s in enumerate(STRIDES)]
    g.save("raw_heads", heads, input_name="input")
    sidecar = {"family": "raw_heads", "names": NAMES, "heads": [
        {"stride": s, "anchors": ANCHORS[s], "scale_x_y": SCALE_XY[s]} for s in reversed(STRIDES)]}
    (HERE / "raw_heads.json").write_text(json.dumps(sidecar, indent=1) + "\n")
    expected["raw_heads"] = from_raw_heads(*run("raw_heads", "stretch"))

    g = Graph()
    out = yolov5_rows(g, "images", 3)
    g.save("yolov5", [(out, "output0", ("batch", "boxes", 8))], input_shape=("batch", 3, "height", "width"),
           metadata={"stride": "32", "names": names, "imgsz": "[64, 64]"})
    outputs, back = run("yolov5", "letterbox")
    expected["yolov5"] = from_rows(outputs["output0"][0], back)

    # One class: rows of six, which are no end-to-end boxes.
    g = Graph()
    g.save("yolov5_one_class", [(yolov5_rows(g, "images", 1), "output0", (1, 252, 6))])
    outputs, back = run("yolov5_one_class", "letterbox")
    expected["yolov5_one_class"] = from_rows(outputs["output0"][0], back)

    # What Ultralytics' dynamic export is like: shapes of an open batch beside the layers.
    g = Graph()
    out = yolov8_columns(g, "images", 3)
    info = [helper.make_tensor_value_info(n.output[0], TensorProto.FLOAT, ("batch", f"c{i}", f"h{i}", f"w{i}"))
            for i, n in enumerate(g.nodes) if n.op_type == "Conv"]
    meta = {"names": names, "task": "detect", "imgsz": "[64, 64]", "stride": "32", "license": "none"}
    g.save("yolov8", [(out, "output0", ("batch", 7, "anchors"))], input_shape=("batch", 3, "height", "width"),
           metadata=meta, value_info=info)
    outputs, back = run("yolov8", "letterbox")
    expected["yolov8"] = from_columns(outputs["output0"][0], back)

    half()
    outputs, back = run("half", "letterbox", half=True)
    expected["half"] = from_columns(outputs["output0"][0], back)

    g = Graph()
    columns = yolov8_columns(g, "images", 3)
    edges, scores = g.add("Split", g.add("Transpose", columns, perm=[0, 2, 1]), g.ints(4, 3), outputs=2, axis=2)
    centre, size = g.add("Split", edges, g.ints(2, 2), outputs=2, axis=2)
    half_size = g.add("Mul", size, g.const(0.5))
    edges = g.add("Concat", g.add("Sub", centre, half_size), g.add("Add", centre, half_size), axis=2)
    best = g.add("ReduceMax", scores, axes=[2], keepdims=1)
    kind = g.add("Cast", g.add("ArgMax", scores, axis=2, keepdims=1), to=TensorProto.FLOAT)
    rows = g.add("Concat", edges, best, kind, axis=2)
    _, index = g.add("TopK", g.add("Squeeze", best, g.ints(2)), g.ints(30), outputs=2, axis=1)
    index = g.add("Expand", g.add("Unsqueeze", index, g.ints(2)), g.ints(1, 30, 6))
    out = g.add("GatherElements", rows, index, axis=1)
    g.save("end_to_end", [(out, "output0", (1, 30, 6))], metadata={"names": names, "end2end": "True"})
    outputs, back = run("end_to_end", "letterbox")
    rows = outputs["output0"][0]
    scores = np.zeros((30, 3), np.float32)
    scores[np.arange(30), rows[:, 5].astype(int)] = rows[:, 4]
    expected["end_to_end"] = kept(rows[:, :4], scores, back, suppress=False)

    g = Graph()
    g.save("yolox", [(yolox_rows(g, "images", 3), "output", (1, 84, 8))])
    outputs, back = run("yolox", "top left", "bgr", 1.0)
    expected["yolox"] = from_yolox(outputs["output"][0], back)

    # Weights beside the file, as torch's newer exporter writes them.
    model = onnx.load(HERE / "tianxiaomo.onnx")
    (HERE / "outside.onnx.data").unlink(missing_ok=True)
    onnx.save(model, HERE / "outside.onnx", save_as_external_data=True, location="outside.onnx.data", size_threshold=100)
    expected["outside"] = from_yolov4(*run("outside", "stretch"))
    return expected


def half():
    """YOLOv8 in f16 throughout."""
    g = Graph()
    out = yolov8_columns(g, "images", 3)
    for i, weight in enumerate(g.weights):
        values = numpy_helper.to_array(weight)
        if values.dtype == np.float32:
            g.weights[i] = numpy_helper.from_array(values.astype(np.float16), weight.name)
    g.save("half", [(out, "output0", (1, 7, 84))], element=TensorProto.FLOAT16,
           metadata={"names": str(dict(enumerate(NAMES)))})


def refused():
    g = Graph()
    up = g.add("Upsample", g.head("images", 16, 7), g.const([1, 1, 2, 2]), mode="nearest")
    out = g.add("Reshape", up, g.ints(1, 7, -1))
    g.save("upsample", [(out, "output0", (1, 7, 64))], opset=9)

    g = Graph()
    columns = yolov8_columns(g, "images", 1)
    boxes, scores = g.add("Split", columns, g.ints(4, 1), outputs=2, axis=1)
    picked = g.add("NonMaxSuppression", g.add("Transpose", boxes, perm=[0, 2, 1]), scores, g.ints(10))
    g.save("nms_inside", [(g.add("Cast", picked, to=TensorProto.FLOAT), "output0", ("boxes", 3))])

    g = Graph()
    pooled = g.add("GlobalAveragePool", g.head("images", 8, 10))
    g.save("classifier", [(g.add("Flatten", pooled), "logits", (1, 10))])

    # A loop of 2^62 rounds.
    i, go, state = (helper.make_tensor_value_info(n, t, s) for n, t, s in
                    (("i", TensorProto.INT64, ()), ("go", TensorProto.BOOL, ()), ("state", TensorProto.FLOAT, (1, 7, 84))))
    body = helper.make_graph(
        [helper.make_node("Identity", ["go"], ["go_on"]), helper.make_node("Add", ["state", "state"], ["next"])],
        "body", [i, go, state],
        [helper.make_tensor_value_info("go_on", TensorProto.BOOL, ()),
         helper.make_tensor_value_info("next", TensorProto.FLOAT, (1, 7, 84))])
    g = Graph()
    columns = yolov8_columns(g, "images", 3)
    out = g.add("Loop", g.const(2**62, np.int64), g.const(True, np.bool_), columns, body=body)
    g.save("loop", [(out, "output0", (1, 7, 84))])

    # A tensor of a million times a million.
    g = Graph()
    huge = g.add("ConstantOfShape", g.ints(1, 1, 1_000_000, 1_000_000))
    columns = yolov8_columns(g, "images", 3)
    out = g.add("Add", columns, g.add("ReduceMax", huge, axes=[1, 2, 3], keepdims=0))
    g.save("huge", [(out, "output0", (1, 7, 84))])

    g = Graph()
    out = yolov8_columns(g, "images", 3)
    g.save("huge_input", [(out, "output0", (1, 7, 84))], input_shape=(1, 3, 2**40, 2**40))

    # A hundred layers of one shared weight on a large input: few bytes, much work.
    g = Graph()
    weight = g.const(random.normal(0, 0.1, (16, 16, 3, 3)))
    t = g.add("Conv", "images", g.const(random.normal(0, 1, (16, 3, 1, 1))))
    for _ in range(100):
        t = g.add("Conv", t, weight, pads=[1, 1, 1, 1])
    out = g.add("Reshape", g.add("MaxPool", t, kernel_shape=[64, 64], strides=[64, 64]), g.ints(1, 16, -1))
    g.save("costly", [(out, "output0", (1, 16, 256))], input_shape=(1, 3, 1024, 1024))


def hostile():
    """Files of a few kilobytes that ask for gigabytes, of which nothing is written in them as a size."""
    one = helper.make_tensor("one", TensorProto.FLOAT, [1], [1.0])

    # A column times a row, of constants: a million times a million.
    g = Graph()
    columns = yolov8_columns(g, "images", 3)
    column, row = (g.add("ConstantOfShape", g.ints(*shape), value=one) for shape in ((1, 1 << 20, 1), (1, 1, 1 << 20)))
    out = g.add("Add", columns, g.add("ReduceMax", g.add("Mul", column, row), axes=[1, 2], keepdims=1))
    g.save("outer_product", [(out, "output0", (1, 7, 84))])

    # A size worked out from the picture's.
    g = Graph()
    columns = yolov8_columns(g, "images", 3)
    size = g.add("Mul", g.add("Shape", "images"), g.ints(1, 1, 300, 300))
    largest = g.add("ReduceMax", g.add("ConstantOfShape", size, value=one), axes=[2, 3], keepdims=0)
    out = g.add("Add", columns, g.add("ReduceMax", largest, axes=[1], keepdims=1))
    g.save("worked_out", [(out, "output0", (1, 7, 84))])

    # Constants that are small enough to be kept, each of them.
    g = Graph()
    total, size = yolov8_columns(g, "images", 3), g.ints(1, 1 << 10, 1 << 10)
    for index in range(80):
        many = g.add("Mul", g.add("ConstantOfShape", size, value=one), g.const(index))
        total = g.add("Add", total, g.add("ReduceMax", g.add("Sin", many), axes=[1, 2], keepdims=1))
    g.save("many_constants", [(total, "output0", (1, 7, 84))])

    # A kernel of 255 x 255 over each pixel of a large picture: little work, but all those pixels side by side.
    g = Graph()
    grey = g.add("ReduceMean", "images", axes=[1], keepdims=1)
    kernel = g.add("ConstantOfShape", g.ints(1, 1, 255, 255), value=one)
    wide = g.add("Conv", grey, kernel, pads=[127, 127, 127, 127])
    pooled = g.add("Concat", *[g.add("MaxPool", wide, kernel_shape=[64, 64], strides=[64, 64])] * 7, axis=1)
    g.save("gathering", [(g.add("Reshape", pooled, g.ints(1, 7, -1)), "output0", (1, 7, 256))], input_shape=(1, 3, 1024, 1024))

    # Ten large layers, each read twice: the first waits until the last has been read once.
    g = Graph()
    wide = g.add("Conv", "images", g.const(np.ones((32, 3, 1, 1))))
    layers = [g.add("Sin", g.add("Mul", wide, g.const(index))) for index in range(10)]
    total = layers[-1]
    for layer in layers[:-1] + layers:
        total = g.add("Mul", g.add("Sin", total), layer)
    pooled = g.add("MaxPool", total, kernel_shape=[64, 64], strides=[64, 64])
    g.save("held", [(g.add("Reshape", pooled, g.ints(1, 32, -1)), "output0", (1, 32, 256))], input_shape=(1, 3, 1024, 1024))


refused()
found = usable()
hostile()
for name, boxes in found.items():
    assert 3 <= len(boxes) <= 200, (name, len(boxes))
    print(name, len(boxes), boxes[0])
lines = [f" {json.dumps(name)}: {json.dumps(boxes)}" for name, boxes in found.items()]
(HERE / "expected.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")
