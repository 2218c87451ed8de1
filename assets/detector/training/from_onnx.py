"""Makes trainable weights of an exported network again, to go on from the shipped detector with labels of your own.

    python from_onnx.py ../default.onnx CHIPS_DIR weights.npz
    python train.py --data CHIPS_DIR REVIEWED_DIR --init weights.npz --network tiny ...

The sidecar must lie beside the model. An export holds each batch normalisation folded into its convolution. In training the
normalisation divides by what a batch shows, so that has to be known again: chips of the folder are shown to the network, and
each normalisation is set to undo exactly what it will do. The result equals the export, but for its rounding to float16.
"""

import json
import sys
from pathlib import Path

import numpy as np
import onnx
import torch
from onnx import numpy_helper
from torch import nn

from data import Chips, read_split
from network import Decoded, build
from weights import save_weights

CHIPS, BATCH = 192, 24


def convolutions(model: onnx.ModelProto) -> list[tuple[np.ndarray, np.ndarray | None]]:
    """Weights and bias of every convolution, in the order of the graph."""
    arrays = {tensor.name: numpy_helper.to_array(tensor) for tensor in model.graph.initializer}
    for node in model.graph.node:
        if node.op_type == "Cast" and node.input[0] in arrays:
            arrays[node.output[0]] = arrays[node.input[0]].astype(np.float32)
    convs = [node for node in model.graph.node if node.op_type == "Conv"]
    return [(arrays[conv.input[1]], arrays[conv.input[2]] if len(conv.input) > 2 else None) for conv in convs]


@torch.no_grad()
def in_order(network: nn.Module, kind: type, side: int) -> list[nn.Module]:
    """The modules of a kind as the network calls them."""
    called, hooks = [], []
    for module in network.modules():
        if isinstance(module, kind):
            hooks.append(module.register_forward_hook(lambda module, *_: called.append(module)))
    network.eval()(torch.zeros(1, 1, side, side))
    for hook in hooks:
        hook.remove()
    return called


@torch.no_grad()
def fill_folded(network: nn.Module, model: onnx.ModelProto, side: int) -> None:
    """Copies the convolutions and lets every normalisation pass values on, its bias added."""
    followed = dict(zip(in_order(network, nn.Conv2d, side), in_order_after(network, side)))
    stored = convolutions(model)
    if len(stored) != len(followed):
        raise SystemExit(f"the model has {len(stored)} convolutions, its sidecar's network {len(followed)}")
    for (conv, norm), (weight, bias) in zip(followed.items(), stored):
        conv.weight.copy_(torch.from_numpy(weight.copy()))
        bias = torch.zeros(len(weight)) if bias is None else torch.from_numpy(bias.copy())
        if norm is None:
            conv.bias.copy_(bias)
        else:
            norm.running_mean.zero_()
            norm.running_var.fill_(1 - norm.eps)
            norm.weight.fill_(1)
            norm.bias.copy_(bias)


def in_order_after(network: nn.Module, side: int) -> list[nn.BatchNorm2d | None]:
    """The normalisation behind each convolution, None behind those of the heads."""
    pairs = {part[0]: part[1] for part in network.modules() if isinstance(part, nn.Sequential) and is_pair(part)}
    return [pairs.get(conv) for conv in in_order(network, nn.Conv2d, side)]


def is_pair(part: nn.Sequential) -> bool:
    """Whether a sequence is a convolution with its normalisation."""
    return len(part) > 1 and isinstance(part[0], nn.Conv2d) and isinstance(part[1], nn.BatchNorm2d)


@torch.no_grad()
def unfold(network: nn.Module, chips: Chips) -> None:
    """Gives every normalisation the mean and variance that chips show, and a gain and bias that undo them."""
    norms = [module for module in network.modules() if isinstance(module, nn.BatchNorm2d)]
    sums = {norm: [0.0, 0.0, 0] for norm in norms}

    def note(norm, inputs):
        values = inputs[0].double()
        sums[norm][0] += values.sum((0, 2, 3))
        sums[norm][1] += values.pow(2).sum((0, 2, 3))
        sums[norm][2] += values.numel() // values.shape[1]

    hooks = [norm.register_forward_pre_hook(note) for norm in norms]
    for at in range(0, len(chips), BATCH):
        network(chips.images[at : at + BATCH].unsqueeze(1).float() / 255)
    for hook in hooks:
        hook.remove()
    for norm, (total, squares, count) in sums.items():
        mean = total / count
        variance = (squares / count - mean**2).clamp(min=1e-6)
        norm.running_mean.copy_(mean)
        norm.running_var.copy_(variance)
        norm.weight.copy_((variance + norm.eps).sqrt())
        norm.bias.add_(mean.float())


def difference(network: nn.Module, meta: dict, path: Path, chips: Chips) -> float:
    """Largest difference of confidences between the export and the weights, over some chips."""
    import onnxruntime

    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    decoded, worst = Decoded(network, torch.tensor(meta["anchors"]), meta["side"]).eval(), 0.0
    for image in chips.images[:8]:
        chip = image[None, None].float() / 255
        found = session.run(["confs"], {"input": chip.numpy()})[0]
        with torch.no_grad():
            worst = max(worst, float(np.abs(found - decoded(chip)[1].numpy()).max()))
    return worst


def main(model: str, folder: str, out: str) -> None:
    """Reads model and sidecar, shows the chips, writes the weights."""
    path = Path(model)
    sidecar = json.loads(path.with_suffix(".json").read_text())
    meta = {key: sidecar[key] for key in ("name", "network", "width", "names", "pixel_m", "thresholds", "training")}
    meta |= {"anchors": [head["anchors"] for head in sidecar["heads"]], "side": sidecar["input"]["width"]}
    network = build(meta["network"], len(meta["names"]), meta["width"])
    chips = read_split(Path(folder), "train").first(CHIPS)
    fill_folded(network, onnx.load(path), meta["side"])
    unfold(network.eval(), chips)
    print(f"confidences differ from the export by {difference(network, meta, path, chips):.1e} at most")
    save_weights(network, meta, out)


if __name__ == "__main__":
    main(*sys.argv[1:4])
