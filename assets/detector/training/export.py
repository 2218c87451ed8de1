"""Writes a trained network as an ONNX file for Bathyscope, with its sidecar, and checks it against onnxruntime.

The graph is static (one chip), opset 13, decodes its heads itself (`boxes`, `confs`), and stores large weights as float16
followed by a `Cast`, which halves the file. To export a stored network again:

    python export.py weights.npz OUT_DIR
"""

import hashlib
import json
import sys
import warnings
from pathlib import Path

import numpy as np
import onnx
import torch
from onnx import TensorProto, helper, numpy_helper

from network import Decoded, build
from weights import load_weights

# Smaller arrays (biases, shapes, anchors) gain nothing from being halved.
SMALLEST_HALVED = 256
OPSET = 13


def write_graph(decoded: Decoded, side: int, path: Path) -> None:
    """Traces the network in float32 for one grey chip."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        torch.onnx.export(
            decoded,
            (torch.zeros(1, 1, side, side),),
            str(path),
            input_names=["input"],
            output_names=["boxes", "confs"],
            opset_version=OPSET,
            do_constant_folding=True,
            dynamo=False,
        )


def halve_weights(model: onnx.ModelProto) -> onnx.ModelProto:
    """Stores large float32 weights as float16 and casts them back at the start of the graph."""
    casts, kept = [], []
    for tensor in model.graph.initializer:
        values = numpy_helper.to_array(tensor)
        if values.dtype != np.float32 or values.size < SMALLEST_HALVED:
            kept.append(tensor)
            continue
        half = tensor.name + ".half"
        kept.append(numpy_helper.from_array(values.astype(np.float16), half))
        casts.append(helper.make_node("Cast", [half], [tensor.name], to=TensorProto.FLOAT))
    nodes = casts + list(model.graph.node)
    del model.graph.initializer[:], model.graph.node[:]
    model.graph.initializer.extend(kept)
    model.graph.node.extend(nodes)
    onnx.checker.check_model(model, full_check=True)
    return model


def largest_difference(path: Path, decoded: Decoded, chips: np.ndarray) -> float:
    """Largest difference between onnxruntime and torch over `chips [n, 1, side, side]`, beyond 1 relative to the value."""
    import onnxruntime

    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    worst = 0.0
    for chip in chips:
        found = session.run(["boxes", "confs"], {"input": chip[None]})
        with torch.no_grad():
            wanted = [value.numpy() for value in decoded(torch.from_numpy(chip[None]))]
        for a, b in zip(found, wanted):
            worst = max(worst, float((np.abs(a - b) / np.maximum(1.0, np.abs(b))).max()))
    return worst


def sidecar(meta: dict, network: torch.nn.Module, model: bytes) -> dict:
    """What a program must know to use the model, as JSON."""
    heads = [
        {"stride": stride, "scale_x_y": network.reach[stride], "anchors": anchors}
        for stride, anchors in zip(network.strides, meta["anchors"])
    ]
    return {
        "format": 1,
        "name": meta.get("name", meta["network"]),
        "family": "yolov4",
        "network": meta["network"],
        "width": meta["width"],
        "names": meta["names"],
        "input": {
            "name": "input",
            "channels": 1,
            "width": meta["side"],
            "height": meta["side"],
            "scale": 1 / 255,
            "resize": "stretch",
        },
        "outputs": {"boxes": "boxes", "confs": "confs", "coordinates": "x1 y1 x2 y2, fractions of the chip"},
        "chip": {"pixel_m": meta["pixel_m"], "rows": "along track", "columns": "slant range, outward"},
        "pixel_m": meta["pixel_m"],
        "level": "auto",
        "test_time_augmentation": "mirrored",
        "heads": heads,
        "thresholds": meta.get("thresholds", {"score": 0.25, "iou": 0.45, "nms": "plain", "class_agnostic": True, "vote": 0.65}),
        "sha256": hashlib.sha256(model).hexdigest(),
        "training": meta.get("training", {}),
    }


def export(network: torch.nn.Module, meta: dict, out: Path, chips: np.ndarray) -> dict:
    """Writes `OUT/NAME.onnx` and `OUT/NAME.json`; returns the differences from torch, measured on `chips`.

    `meta` holds `network`, `width`, `names`, `anchors`, `side`, `pixel_m` and, where known, `name`, `thresholds`, `training`.
    """
    decoded = Decoded(network.cpu().float().eval(), torch.tensor(meta["anchors"]), meta["side"]).eval()
    name = meta.get("name", meta["network"])
    path, full = out / f"{name}.onnx", out / f"{name}.f32.onnx"
    write_graph(decoded, meta["side"], full)
    onnx.save(halve_weights(onnx.load(full)), path)
    differences = {
        "onnx_f32_against_torch": largest_difference(full, decoded, chips),
        "onnx_f16_weights_against_torch": largest_difference(path, decoded, chips),
        "bytes": path.stat().st_size,
    }
    full.unlink()
    (out / f"{name}.json").write_text(json.dumps(sidecar(meta, network, path.read_bytes()), indent=1) + "\n")
    return differences


def main(weights: str, out: str) -> None:
    """Exports a stored network again and checks it on noise."""
    arrays_network, meta = load_weights(weights, build)
    Path(out).mkdir(parents=True, exist_ok=True)
    chips = np.random.default_rng(0).random((2, 1, meta["side"], meta["side"]), dtype=np.float32)
    print(json.dumps(export(arrays_network, meta, Path(out), chips), indent=1))


if __name__ == "__main__":
    main(*sys.argv[1:3])
