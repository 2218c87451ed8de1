"""The YOLOv4 loss: complete IoU for boxes, binary cross-entropy for objectness and classes.

Assignment as in AlexeyAB/darknet: a truth belongs to the cell of its centre, with the anchor of the best shape and every
other anchor whose shape IoU exceeds 0.213. Predictions that lie well on a truth (IoU above 0.7) without being assigned to it
are not punished for their objectness, nor are those centred in an ignored box.
"""

import math

import torch
import torch.nn.functional as F

from data import IGNORE
from network import decode_level

ANCHOR_IOU = 0.213
IGNORE_IOU = 0.7
BOX_WEIGHT, OBJECT_WEIGHT, CLASS_WEIGHT = 3.0, 1.0, 1.0


def corners(boxes: torch.Tensor) -> torch.Tensor:
    """Centre and size to x1, y1, x2, y2."""
    half = boxes[..., 2:] / 2
    return torch.cat([boxes[..., :2] - half, boxes[..., :2] + half], -1)


def iou(a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
    """IoU of boxes given by corners, over broadcast leading dimensions."""
    shared = (torch.minimum(a[..., 2:], b[..., 2:]) - torch.maximum(a[..., :2], b[..., :2])).clamp(min=0).prod(-1)
    areas = (a[..., 2:] - a[..., :2]).prod(-1) + (b[..., 2:] - b[..., :2]).prod(-1)
    return shared / (areas - shared).clamp(min=1e-9)


def complete_iou(predicted: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """CIoU (Zheng and others, 2020) of boxes given by centre and size: IoU - d^2/c^2 - alpha * v.

    d is the distance of the centres, c the diagonal of the smallest box around both, v the difference of the aspect angles.
    """
    a, b = corners(predicted), corners(truth)
    overlap = iou(a, b)
    around = torch.maximum(a[..., 2:], b[..., 2:]) - torch.minimum(a[..., :2], b[..., :2])
    diagonal2 = around.pow(2).sum(-1).clamp(min=1e-9)
    distance2 = (predicted[..., :2] - truth[..., :2]).pow(2).sum(-1)
    angle = torch.atan2(truth[..., 2], truth[..., 3]) - torch.atan2(predicted[..., 2], predicted[..., 3])
    v = (4 / math.pi**2) * angle.pow(2)
    with torch.no_grad():
        alpha = v / (1 - overlap + v).clamp(min=1e-9)
    return overlap - distance2 / diagonal2 - alpha * v


def weighted(terms: dict[str, torch.Tensor]) -> torch.Tensor:
    """The three terms as one."""
    return BOX_WEIGHT * terms["box"] + OBJECT_WEIGHT * terms["object"] + CLASS_WEIGHT * terms["class"]


class Yolov4Loss:
    """The loss of one network's heads against padded boxes."""

    def __init__(self, anchors: list[torch.Tensor], strides: tuple[int, ...], reach: dict[int, float]):
        self.anchors, self.strides, self.reach = anchors, strides, reach
        self.all_anchors = torch.cat(anchors)

    def assign(self, truth: torch.Tensor) -> list[torch.Tensor]:
        """Which truths `[n, 2]` (sizes) each head's anchors answer for: a mask `[n, anchors]` per head."""
        shared = torch.minimum(truth[:, None], self.all_anchors[None]).prod(2)
        shape_iou = shared / (truth.prod(1)[:, None] + self.all_anchors.prod(1)[None] - shared)
        mask = (shape_iou > ANCHOR_IOU) | F.one_hot(shape_iou.argmax(1), len(self.all_anchors)).bool()
        return list(mask.split([len(a) for a in self.anchors], 1))

    def __call__(self, heads: list[torch.Tensor], boxes: torch.Tensor) -> dict[str, torch.Tensor]:
        """`boxes [batch, slots, 5]` as in `Chips`. Returns `box`, `object`, `class`, their weighted `total`, and `each`: that
        total picture by picture, `[batch]`, without a gradient."""
        image, slot = torch.nonzero(boxes[..., 0] >= 0, as_tuple=True)
        truth = boxes[image, slot]
        kind = truth[:, 0].long()
        middle, size = (truth[:, 1:3] + truth[:, 3:5]) / 2, truth[:, 3:5] - truth[:, 1:3]
        truth = torch.cat([middle, size], 1)
        masks = self.assign(size)
        # A batch of empty chips still has an objectness loss: never divide by less than half an object per chip.
        answers = torch.stack([mask.sum(1) for mask in masks]).sum(0).float()
        positives = answers.sum().clamp(min=len(boxes) / 2)
        sums = {"box": 0.0, "object": 0.0, "class": 0.0}
        for level, head in enumerate(heads):
            terms = self.level(level, head.float(), boxes, image, kind, truth, masks[level])
            sums = {name: sums[name] + terms[name] for name in sums}
        each = torch.zeros_like(boxes[:, 0, 0])
        own = each.index_add(0, image, answers).clamp(min=1)
        losses = {name: value.sum() / positives for name, value in sums.items()}
        losses["total"] = weighted(losses)
        losses["each"] = weighted({name: value.detach() for name, value in sums.items()}) / own
        return losses

    def level(self, level, head, boxes, image, kind, truth, mask) -> dict[str, torch.Tensor]:
        """The summed terms of one head, picture by picture."""
        stride = self.strides[level]
        predicted, logits = decode_level(head, self.anchors[level], stride, self.reach[stride])
        index, anchor = torch.nonzero(mask, as_tuple=True)
        rows, columns = head.shape[-2:]
        column = (truth[index, 0] / stride).long().clamp(0, columns - 1)
        row = (truth[index, 1] / stride).long().clamp(0, rows - 1)
        at = (image[index], anchor, row, column)
        wanted = torch.zeros_like(logits[..., 0])
        wanted[at] = 1.0
        weight = torch.maximum(wanted, self.unpunished(predicted.detach(), boxes).logical_not().float())
        classes = F.one_hot(kind[index], logits.shape[-1] - 1).to(logits.dtype)

        def by_picture(values: torch.Tensor) -> torch.Tensor:
            return torch.zeros_like(boxes[:, 0, 0]).index_add(0, image[index], values)

        objectness = F.binary_cross_entropy_with_logits(logits[..., 0], wanted, weight, reduction="none")
        kinds = F.binary_cross_entropy_with_logits(logits[at][:, 1:], classes, reduction="none")
        return {
            "box": by_picture(1 - complete_iou(predicted[at], truth[index])),
            "object": objectness.flatten(1).sum(1),
            "class": by_picture(kinds.sum(1)),
        }

    @staticmethod
    def unpunished(predicted: torch.Tensor, boxes: torch.Tensor) -> torch.Tensor:
        """Predictions whose objectness is left alone: well on a truth, or centred in an ignored box."""
        flat = predicted.reshape(predicted.shape[0], -1, 1, 4)
        around, kind = boxes[:, None, :, 1:], boxes[:, None, :, 0]
        on_truth = (iou(corners(flat), around) > IGNORE_IOU) & (kind >= 0)
        centre = flat[..., :2]
        inside = ((centre > around[..., :2]) & (centre < around[..., 2:])).all(-1) & (kind == IGNORE)
        return (on_truth | inside).any(-1).view(predicted.shape[:-1])
