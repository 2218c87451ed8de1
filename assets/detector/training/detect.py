"""Runs a network over chips and keeps the boxes that survive suppression, moved by vote, as Bathyscope does at inference.

`look_twice` is what the program does with the shipped detector; `detect` is one look, enough to follow a training.
"""

from pathlib import Path

import numpy as np
import torch

from data import IGNORE, Chips
from network import Decoded

LOWEST_SCORE = 0.01
NMS_IOU = 0.45
VOTE_IOU = 0.65
MOST_CANDIDATES = 300
# A chip is worth a second look from this confidence on; two looks see the same from this overlap on.
WORTH_A_LOOK, SAME_IOU = 0.1, 0.6


def box_iou(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """IoU of corner boxes: `[n, 4]` and `[m, 4]` give `[n, m]`."""
    shared = np.minimum(a[:, None, 2:], b[None, :, 2:]) - np.maximum(a[:, None, :2], b[None, :, :2])
    shared = shared.clip(0).prod(2)
    areas = (a[:, 2:] - a[:, :2]).prod(1)[:, None] + (b[:, 2:] - b[:, :2]).prod(1)[None]
    return shared / np.maximum(areas - shared, 1e-9)


def suppress(detections: np.ndarray, agnostic: bool, limit: float = NMS_IOU) -> np.ndarray:
    """Plain greedy suppression of rows `x1 y1 x2 y2 score class`, within a class or, `agnostic`, across classes; then the vote."""
    detections = detections[np.argsort(-detections[:, 4], kind="stable")]
    overlap = box_iou(detections[:, :4], detections[:, :4]) > limit
    if not agnostic:
        overlap &= detections[:, 5][:, None] == detections[:, 5][None]
    keep = np.ones(len(detections), bool)
    for row in range(len(detections)):
        if keep[row]:
            keep[row + 1 :] &= ~overlap[row, row + 1 :]
    return vote(detections[keep], detections)


def vote(kept: np.ndarray, voters: np.ndarray) -> np.ndarray:
    """Moves each box to the mean of those of its class that it overlaps by more than VOTE_IOU, weighted by squared score."""
    has = (box_iou(kept[:, :4], voters[:, :4]) > VOTE_IOU) & (kept[:, 5][:, None] == voters[:, 5][None])
    weight = has * voters[:, 4].astype(float) ** 2
    mean = weight @ voters[:, :4] / np.maximum(weight.sum(1, keepdims=True), 1e-12)
    return np.concatenate([np.where(has.any(1, keepdims=True), mean, kept[:, :4]), kept[:, 4:]], 1).astype(kept.dtype)


class Exported:
    """An exported model in place of a network: the same boxes and confidences, by onnxruntime."""

    def __init__(self, path: Path):
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = torch.get_num_threads()
        self.session = onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
        self.side = self.session.get_inputs()[0].shape[-1]

    def __call__(self, pictures: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        each = [self.session.run(["boxes", "confs"], {"input": picture[None].numpy()}) for picture in pictures]
        return tuple(torch.from_numpy(np.concatenate(part)) for part in zip(*each))


@torch.no_grad()
def candidates(decoded: "Decoded | Exported", images: torch.Tensor) -> list[np.ndarray]:
    """Before suppression: per chip rows `x1 y1 x2 y2 score class` in pixels, every class above the lowest score."""
    boxes, confs = decoded(images.unsqueeze(1).float() / 255)
    count = min(MOST_CANDIDATES, confs[0].numel())
    score, flat = confs.flatten(1).topk(count, dim=1)
    box, kind = flat // confs.shape[2], flat % confs.shape[2]
    picked = boxes.squeeze(2).gather(1, box[..., None].expand(-1, -1, 4)) * decoded.side
    rows = torch.cat([picked, score[..., None], kind[..., None].float()], 2).float().cpu().numpy()
    return [chip[chip[:, 4] >= LOWEST_SCORE] for chip in rows]


def detect(network: "torch.nn.Module | Exported", anchors: list, chips: Chips, batch: int = 64) -> list[np.ndarray]:
    """Candidates of every chip, by a network in evaluation mode on its own device, or by an exported one."""
    if isinstance(network, Exported):
        device, decoded = torch.device("cpu"), network
    else:
        device = next(network.parameters()).device
        decoded = Decoded(network, torch.tensor(anchors), chips.side).to(device).eval()
    found = []
    for at in range(0, len(chips), batch):
        found += candidates(decoded, chips.images[at : at + batch].to(device))
    return found


def look_twice(network: torch.nn.Module, anchors: list, chips: Chips) -> list[np.ndarray]:
    """Candidates of every chip; where a first look sees something, of that and of a second one, mirrored along the track."""
    found = detect(network, anchors, chips)
    worth = [index for index, rows in enumerate(found) if (rows[:, 4] >= WORTH_A_LOOK).any()]
    again = detect(network, anchors, Chips(chips.images[worth].flip(1), chips.boxes[worth], [chips.names[i] for i in worth]))
    for index, rows in zip(worth, again):
        rows[:, [1, 3]] = chips.side - rows[:, [3, 1]]
        found[index] = np.concatenate([agreed(found[index], rows), agreed(rows, found[index])])
    return found


def agreed(own: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Candidates of one look, each as sure as the mean of itself and the surest of its class that the other look has there."""
    same = (box_iou(own[:, :4], other[:, :4]) > SAME_IOU) & (own[:, 5][:, None] == other[:, 5][None])
    there = (same * other[:, 4]).max(1, initial=0)
    return np.concatenate([own[:, :4], ((own[:, 4] + there) / 2)[:, None], own[:, 5:]], 1)


def judged(found: list[np.ndarray], chips: Chips) -> list[np.ndarray]:
    """What was found, without that which lies mostly (half of it) in an ignored box and on no truth of its class."""
    kept = []
    for rows, truth, boxes in zip(found, truths(chips), chips.boxes.cpu().numpy()):
        ignored = boxes[boxes[:, 0] == IGNORE, 1:]
        if len(rows) and len(ignored):
            shared = np.minimum(rows[:, None, 2:4], ignored[None, :, 2:]) - np.maximum(rows[:, None, :2], ignored[None, :, :2])
            share = shared.clip(0).prod(2) / np.maximum((rows[:, 2:4] - rows[:, :2]).prod(1)[:, None], 1e-9)
            right = (box_iou(rows[:, :4], truth[:, :4]) >= 0.5) & (rows[:, 5][:, None] == truth[:, 4][None])
            rows = rows[(share < 0.5).all(1) | right.any(1)]
        kept.append(rows)
    return kept


def truths(chips: Chips) -> list[np.ndarray]:
    """Truth boxes per chip, rows `x1 y1 x2 y2 class` in pixels."""
    boxes = chips.boxes.cpu().numpy()
    return [np.concatenate([b[b[:, 0] >= 0, 1:], b[b[:, 0] >= 0, :1]], 1) for b in boxes]
