"""Anchor sizes from our own boxes: k-means with 1 - IoU as the distance, as YOLOv2 and Darknet's `calc_anchors` do."""

import numpy as np


def size_iou(sizes: np.ndarray, anchors: np.ndarray) -> np.ndarray:
    """IoU of boxes that share a corner: `[n, 2]` and `[k, 2]` give `[n, k]`."""
    shared = np.minimum(sizes[:, None], anchors[None]).prod(2)
    return shared / (sizes.prod(1)[:, None] + anchors.prod(1)[None] - shared)


def cluster(sizes: np.ndarray, count: int, seed: int = 0, rounds: int = 100) -> np.ndarray:
    """`count` anchors `[count, 2]` for box sizes `[n, 2]` in pixels, from small to large area."""
    sizes = sizes[(sizes > 1.0).all(1)].astype(float)
    if len(sizes) < count:
        raise SystemExit(f"too few boxes to choose {count} anchors: {len(sizes)}")
    rng = np.random.default_rng(seed)
    # Seeds along the sorted areas: every scale starts with an anchor.
    order = np.argsort(sizes.prod(1))
    anchors = sizes[order[((np.arange(count) + 0.5) / count * len(sizes)).astype(int)]] * rng.uniform(0.98, 1.02, (count, 2))
    for _ in range(rounds):
        nearest = size_iou(sizes, anchors).argmax(1)
        moved = np.stack([np.median(sizes[nearest == k], 0) if (nearest == k).any() else anchors[k] for k in range(count)])
        if np.allclose(moved, anchors):
            break
        anchors = moved
    return anchors[np.argsort(anchors.prod(1))]


def per_head(sizes: np.ndarray, heads: int, seed: int = 0) -> list[list[list[float]]]:
    """Three anchors for each head, the finest head first."""
    return cluster(sizes, 3 * heads, seed).round(1).reshape(heads, 3, 2).tolist()
