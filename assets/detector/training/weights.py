"""Stores a network with what is needed to build it again, small enough to carry: convolutions as float16."""

import json
from pathlib import Path

import numpy as np
import torch

META = "meta.json"


def save_weights(network: torch.nn.Module, meta: dict, path: str) -> None:
    """Writes every array of `network` (4-D ones as float16, the rest as they are) and `meta` into one `.npz`, aside at first."""
    arrays = {}
    for name, tensor in network.state_dict().items():
        values = tensor.detach().cpu().float().numpy() if tensor.is_floating_point() else tensor.cpu().numpy()
        arrays[name] = values.astype(np.float16) if values.ndim == 4 else values
    arrays[META] = np.frombuffer(json.dumps(meta).encode(), dtype=np.uint8)
    aside = Path(path).with_suffix(".part.npz")
    np.savez(aside, **arrays)
    aside.replace(path)


def read_meta(path: str) -> dict:
    """What was stored beside the weights; empty for a file of bare arrays."""
    with np.load(path) as arrays:
        return json.loads(arrays[META].tobytes()) if META in arrays else {}


def load_weights(path: str, build) -> tuple[torch.nn.Module, dict]:
    """The stored network, built by `build(name, classes, width)`, and its meta data."""
    meta = read_meta(path)
    network = build(meta["network"], len(meta["names"]), meta["width"])
    fill(network, path)
    return network.eval(), meta


def fill(network: torch.nn.Module, path: str) -> list[str]:
    """Copies every array whose name and shape fit, as when other classes are to be learnt; returns the names that did not."""
    state, missed = network.state_dict(), []
    with np.load(path) as arrays:
        for name, tensor in state.items():
            if name in arrays and tuple(arrays[name].shape) == tuple(tensor.shape):
                tensor.copy_(torch.from_numpy(arrays[name].astype(np.float32) if tensor.is_floating_point() else arrays[name]))
            else:
                missed.append(name)
    return missed
