"""Fits what a network's confidences come to: the share of its boxes that lie on an object.

    python calibrate.py MODEL CHIPS_DIR [--split val] [--draws 2] [--out points.json] [--into MODEL.json]

The chips (never trained on) are shown as they are and as other recorders would show them (`augment.py`), so that the map is of no
one law. A box is right when it lies on an object of any class at an IoU of 0.3. Confidences are sorted into groups of equal size,
their shares made rising (pool adjacent violators), and a few points kept; a share is never 0 or 1, as Laplace has it. `--into`
writes them into a sidecar as `calibration`, which `src/objects/model/sidecar.rs` reads.
"""

import argparse
import json
from pathlib import Path

import numpy as np
import torch

from augment import Augmenter, Strength
from data import Chips, read_split
from recall import FALSE_IOU, blind, load, look, ranked

GROUPS, LEAST_RISE = 12, 0.01


def shown_by_others(chips: Chips, seed: int) -> Chips:
    """The chips with the marks of other recorders; places and boxes stay."""
    generator = torch.Generator().manual_seed(seed)
    augmenter = Augmenter(chips, Strength().calm().of_other_recorders(), generator)
    images = []
    for at in range(0, len(chips), 32):
        pictures = chips.images[at : at + 32].unsqueeze(1).float() / 255
        images.append((augmenter.recorded(pictures).clamp(0, 1) * 255).round().byte()[:, 0])
    return Chips(torch.cat(images), chips.boxes, chips.names, chips.edges)


def rising(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The nearest sequence that does not fall (pool adjacent violators)."""
    pools = []
    for value, weight in zip(values, weights):
        pools.append([value, weight, 1])
        while len(pools) > 1 and pools[-2][0] >= pools[-1][0]:
            (a, wa, na), (b, wb, nb) = pools[-2], pools.pop()
            pools[-1] = [(a * wa + b * wb) / (wa + wb), wa + wb, na + nb]
    return np.concatenate([np.full(count, value) for value, _, count in pools])


def points(scores: np.ndarray, right: np.ndarray) -> list[list[float]]:
    """Rising points of confidence and share, ending at a confidence of 1."""
    order = np.argsort(scores)
    groups = np.array_split(order, GROUPS)
    middle = np.array([scores[group].mean() for group in groups])
    count = np.array([len(group) for group in groups])
    share = rising(np.array([(right[group].sum() + 1) / (len(group) + 2) for group in groups]), count)
    kept: list[list[float]] = []
    for confidence, value in zip(middle, share):
        if not kept or (confidence > kept[-1][0] + 0.005 and value > kept[-1][1] + LEAST_RISE):
            kept.append([round(float(confidence), 4), round(float(value), 4)])
    last = min(max(kept[-1][1] + LEAST_RISE, share[-1]), 0.995)
    return [*kept, [1.0, round(float(last), 4)]] if kept[-1][0] < 1 else kept


def main() -> None:
    """Reads the arguments, fits, prints, writes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("chips", type=Path)
    parser.add_argument("--split", default="val")
    parser.add_argument("--draws", type=int, default=1)
    parser.add_argument("--limit", type=int)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--into", type=Path)
    args = parser.parse_args()
    network, meta = load(args.model)
    chips = read_split(args.chips, args.split, args.limit)
    all_scores, all_right = [], []
    for draw in range(args.draws + 1):
        shown = shown_by_others(chips, draw) if draw else chips
        scores, right = ranked(look(network, meta, shown)[1], blind(shown), FALSE_IOU)
        all_scores.append(scores[scores >= 0.03])
        all_right.append(right[scores >= 0.03])
    fitted = points(np.concatenate(all_scores), np.concatenate(all_right))
    print(json.dumps(fitted))
    if args.out:
        args.out.write_text(json.dumps(fitted) + "\n")
    if args.into:
        sidecar = json.loads(args.into.read_text())
        sidecar["calibration"] = fitted
        args.into.write_text(json.dumps(sidecar, indent=1) + "\n")


if __name__ == "__main__":
    main()
