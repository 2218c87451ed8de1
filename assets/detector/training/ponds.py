"""How many objects a detector finds in whole logs of `pond.py`, a second simulator that Bathyscope shares no code with.

    pond.py p61 --seed 61 --lines 4 --objects 30         # p61.sl2, p61.boxes.csv; seeds 61 to 99 measure, none is trained on
    python ponds.py MODEL p61 p62 ... [--out ponds.json] [--score S ...]
    bathyscope detect p61.sl2 -o p61.found --score 0.05
    python ponds.py p61.found/objects p61 ...            # the program's own boxes: one folder before each prefix

MODEL is an export (`.onnx`) or a `weights.npz`. It searches a log much as the program does: the picture of `raster.py`, tiles that
overlap by a quarter, two looks. Only boxes of neighbouring tiles are merged more simply, and rows differ by parts of a pixel.

A sighting is found where a box of any class reaches one of its two outlines (where levels differ by 1 dB or by 2 dB) at the
IoU. Asked for are those that `pond.py` calls visible; `plain` ones have a signal-to-noise ratio of 12 or more. A box is false when
it lies on nothing: it reaches no sighting, visible or not, at an IoU of 0.3, does not lie mostly on one and holds most of none.
"""

import argparse
import csv
import json
import struct
from pathlib import Path

import numpy as np
import torch

from data import Chips
from detect import box_iou, look_twice, suppress
from raster import PIXEL_M, SIDE, raster
from real import levelled
from recall import load

FEET_M, KNOT_MPS, HEADER, SIDE_SCAN = 0.3048, 0.514444, 144, 5
STEP, EDGE_PX = 312, 2.0
LOOSE_IOU, STRICT_IOU, PLAIN = 0.3, 0.5, 12.0
SCORES = (0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6, 0.7)
SIDES = ("port", "starboard")


class Log:
    """The side-scan of an SL2 of `pond.py`: where each ping lies, and both sides as pictures."""

    def __init__(self, path: Path):
        data, at, pings, times, speeds = path.read_bytes(), 8, [], [], []
        while at + HEADER <= len(data):
            size, _, channel, count, _, _, self.range_m = struct.unpack_from("<HHHHIff", data, at + 28)
            if channel == SIDE_SCAN:
                pings.append(np.frombuffer(data, np.uint8, count, at + HEADER))
                times.append(struct.unpack_from("<i", data, at + 140)[0] / 1000)
                speeds.append(struct.unpack_from("<f", data, at + 100)[0] * KNOT_MPS)
                range_m = self.range_m * FEET_M
            at += size
        self.range_m, pings = range_m, np.array(pings, float)
        pause = np.clip(np.diff(times, prepend=times[0]), 0.001, 2.0)
        self.along_m = np.cumsum(pause * speeds)
        half = pings.shape[1] // 2
        self.per_sample_m = self.range_m / half
        halves = {"port": pings[:, :half][:, ::-1], "starboard": pings[:, half:]}
        drawn = {side: raster(levels, self.along_m, self.per_sample_m, self.range_m) for side, levels in halves.items()}
        self.pictures = {side: np.round(picture).astype(np.uint8) for side, picture in drawn.items()}

    @property
    def hectares(self) -> float:
        """Ground that both sides show."""
        return sum(picture.size for picture in self.pictures.values()) * PIXEL_M**2 / 1e4

    def box(self, pings: tuple[float, float], samples: tuple[float, float]) -> list[float]:
        """Pings and samples as a box in the picture."""
        rows = np.interp(np.array(pings, float) - 0.5, np.arange(len(self.along_m)), self.along_m) / PIXEL_M
        columns = np.array(samples, float) * self.per_sample_m / PIXEL_M
        return [columns[0], rows[0], columns[1], rows[1]]


def starts(length: int) -> list[int]:
    """Where tiles begin."""
    last = max(length - SIDE, 0)
    return sorted({min(at, last) for at in range(0, last + STEP, STEP)})


def search(network, anchors, picture: np.ndarray) -> np.ndarray:
    """Boxes of one side, `x1 y1 x2 y2 score class`."""
    places = [(row, column) for row in starts(picture.shape[0]) for column in starts(picture.shape[1])]
    tiles = np.zeros((len(places), SIDE, SIDE), np.uint8)
    for tile, (row, column) in zip(tiles, places):
        piece = picture[row : row + SIDE, column : column + SIDE]
        tile[: piece.shape[0], : piece.shape[1]] = piece
        tile[:] = levelled(tile)
    chips = Chips(torch.from_numpy(tiles), torch.full((len(tiles), 1, 5), -2.0), [str(place) for place in places])
    whole, cut = [], []
    for rows, (row, column) in zip(look_twice(network, anchors, chips), places):
        rows = suppress(rows, agnostic=True)
        size = np.array([picture.shape[1] - column, picture.shape[0] - row])
        inside = rows.copy()
        inside[:, [0, 2]], inside[:, [1, 3]] = rows[:, [0, 2]].clip(0, size[0]), rows[:, [1, 3]].clip(0, size[1])
        kept = (inside[:, 2:4] - inside[:, :2]).prod(1) >= 0.5 * (rows[:, 2:4] - rows[:, :2]).prod(1)
        near = (inside[:, 0] < EDGE_PX) & (column > 0) | (inside[:, 1] < EDGE_PX) & (row > 0)
        near |= (inside[:, 2] > SIDE - EDGE_PX) & (size[0] > SIDE) | (inside[:, 3] > SIDE - EDGE_PX) & (size[1] > SIDE)
        inside[:, [0, 2]] += column
        inside[:, [1, 3]] += row
        whole.append(inside[kept & ~near])
        cut.append(inside[kept & near])
    whole, cut = np.concatenate(whole), np.concatenate(cut)
    whole = suppress(whole, agnostic=True) if len(whole) else whole
    left = cut[covered(cut, whole).max(1, initial=0) < 0.5]
    return np.concatenate([whole, suppress(left, agnostic=True)]) if len(left) else whole


def covered(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Share of each box that lies in each other box."""
    shared = np.minimum(boxes[:, None, 2:4], others[None, :, 2:4]) - np.maximum(boxes[:, None, :2], others[None, :, :2])
    return shared.clip(0).prod(2) / np.maximum((boxes[:, 2:4] - boxes[:, :2]).prod(1)[:, None], 1e-9)


def ends(row: dict, what: str) -> tuple[float, float]:
    """Two columns of a table."""
    return float(row[what + "_from"]), float(row[what + "_to"])


def program_boxes(folder: Path, log: Log) -> dict[str, np.ndarray]:
    """What `bathyscope detect` found, by side."""
    found = {side: [] for side in SIDES}
    with open(folder / "detections.csv", newline="") as file:
        for row in csv.DictReader(file):
            found[row["side"]].append([*log.box(ends(row, "ping"), ends(row, "sample")), float(row["score"]), 0])
    return {side: np.array(rows).reshape(-1, 6) for side, rows in found.items()}


def sightings(path: Path, log: Log) -> list[dict]:
    """The table of what can be seen, each with its two boxes."""
    rows = []
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            boxes = [log.box(*(ends(row, part + what) for what in ("ping", "sample"))) for part in ("", "core_")]
            one = {"class": row["class"], "side": row["side"], "boxes": boxes, "clear": float(row["clear"])}
            rows.append(one | {"visible": row["visible"] == "1", "score": 0.0, "iou": 0.0})
    return rows


def compare(found: np.ndarray, there: list[dict]) -> np.ndarray:
    """Notes at each sighting the IoU and the confidence of the box it takes; the confidences of false boxes."""
    boxes = np.array([one["boxes"] for one in there]).reshape(-1, 2, 4)
    overlap = np.maximum(box_iou(found[:, :4], boxes[:, 0]), box_iou(found[:, :4], boxes[:, 1]))
    around = boxes[:, 0]
    on_one = (overlap >= LOOSE_IOU) | (covered(found, around) >= 0.5) | (covered(around, found).T >= 0.5)
    while overlap.size and overlap.max() >= LOOSE_IOU:
        row, column = np.unravel_index(overlap.argmax(), overlap.shape)
        there[column] |= {"iou": float(overlap[row, column]), "score": float(found[row, 4])}
        overlap[row], overlap[:, column] = 0, 0
    return found[~on_one.any(1), 4]


def table(there: list[dict], false: np.ndarray, hectares: float, scores) -> list[dict]:
    """Found of those asked for, and false boxes, over confidences."""
    asked, rows = [one for one in there if one["visible"]], []
    for score in scores:
        hit = [one for one in asked if one["score"] >= score and one["iou"] >= LOOSE_IOU]
        row = {"score": score, "visible": len(asked), "found": len(hit)}
        row |= {"found_iou50": sum(one["iou"] >= STRICT_IOU for one in hit)}
        row |= {"plain": sum(one["clear"] >= PLAIN for one in asked), "found_plain": sum(one["clear"] >= PLAIN for one in hit)}
        for kind in ("rock", "block", "bar"):
            row[kind] = [sum(one["class"] == kind for one in some) for some in (hit, asked)]
        row |= {"mean_iou": round(float(np.mean([one["iou"] for one in hit] or [0])), 3), "false": int((false >= score).sum())}
        rows.append(row | {"false_per_hectare": round(int((false >= score).sum()) / hectares, 2)})
    return rows


def main() -> None:
    """Searches, compares, prints."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", type=Path, nargs="+", help="MODEL PREFIX..., or FOLDER PREFIX FOLDER PREFIX ...")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--score", type=float, nargs="*", default=SCORES)
    args = parser.parse_args()
    by_program = args.what[0].is_dir()
    if by_program:
        pairs = list(zip(args.what[::2], args.what[1::2]))
    else:
        pairs = [(args.what[0], prefix) for prefix in args.what[1:]]
        network, meta = load(args.what[0])
    there, false, hectares = [], [], 0.0
    for model, prefix in pairs:
        log = Log(prefix.with_suffix(".sl2"))
        own = sightings(prefix.with_suffix(".boxes.csv"), log)
        if by_program:
            found = program_boxes(model, log)
        else:
            found = {side: search(network, meta["anchors"], log.pictures[side]) for side in SIDES}
        false += [compare(found[side], [one for one in own if one["side"] == side]) for side in SIDES]
        there, hectares = there + own, hectares + log.hectares
    rows = table(there, np.concatenate(false), hectares, args.score)
    surest = np.sort(np.concatenate(false))[::-1][:12]
    print(f"{len(pairs)} ponds, {hectares:.2f} ha; surest false boxes", " ".join(f"{score:.2f}" for score in surest))
    for row in rows:
        print(json.dumps(row))
    if args.out:
        args.out.write_text(json.dumps({"hectares": hectares, "rows": rows, "sightings": there}, indent=1) + "\n")


if __name__ == "__main__":
    main()
