"""Measures a network on held-out chips and, where given, on real tiles.

    python evaluate.py --weights weights.npz --data DIR [--real real.npz] [--score S] --out OUT

With `--score` the data need no validation split.
Writes `metrics.json`, `errors.json` and `errors.png` (a sheet of the errors, worst first).
"""

import argparse
import json
from pathlib import Path

import numpy as np
import torch
from PIL import Image, ImageDraw

import metrics
import real
from data import Chips, read_manifest, read_split
from detect import judged, look_twice, suppress, truths
from network import build
from weights import load_weights

SHEET_COLUMNS, SHEET_ROWS, CROP_PX = 8, 6, 144
CHIP_HECTARE = 1e-4


def best_score(found: list, truth: list) -> float:
    """The confidence of the best F1, on the data that may be looked at (validation)."""
    rows = metrics.sweep(found, truth)
    top = max(row["f1"] for row in rows)
    level = [row["score"] for row in rows if row["f1"] > top - 0.002]
    return round(float(np.median(level)), 2)


def measure(network, meta: dict, chips: Chips, score: float | None) -> tuple[dict, list, list]:
    """The full report of one split. Precision is over class-wise suppression, counts over suppression across classes.

    Without a `score` the best one on these chips is used. Returns the report, what was found and what was there.
    """
    raw, truth = look_twice(network, meta["anchors"], chips), truths(chips)
    by_class = judged([suppress(rows, agnostic=False) for rows in raw], chips)
    found = judged([suppress(rows, agnostic=True) for rows in raw], chips)
    score = best_score(found, truth) if score is None else score
    hectares = len(chips) * (chips.side * meta["pixel_m"]) ** 2 * CHIP_HECTARE
    at_score = metrics.counts(found, truth, score)
    report = {
        "chips": len(chips),
        "empty_chips": sum(len(t) == 0 for t in truth),
        "hectares": hectares,
        "precision": metrics.precision_table(by_class, truth, meta["names"]),
        "at_score": at_score | {"false_alarms_per_hectare": at_score["fp"] / hectares},
        "recall_by_size": metrics.recall_by_size(found, truth, score, meta["pixel_m"]),
        "confusion_found_by_there": metrics.confusion(found, truth, score, len(meta["names"])),
        "sweep": metrics.sweep(found, truth),
    }
    return report, found, truth


def crop(chips: Chips, error: dict) -> Image.Image:
    """The surroundings of one error, its box drawn: red for a false alarm, yellow for a miss."""
    pixels = chips.images[chips.names.index(error["chip"])].cpu().numpy()
    x1, y1, x2, y2 = error["box_px"]
    half = max(48.0, 0.75 * max(x2 - x1, y2 - y1))
    cx, cy, zoom = (x1 + x2) / 2, (y1 + y2) / 2, CROP_PX / (2 * half)
    window = (int(cx - half), int(cy - half), int(cx + half), int(cy + half))
    picture = Image.fromarray(pixels).crop(window).resize((CROP_PX, CROP_PX)).convert("RGB")
    draw = ImageDraw.Draw(picture)
    box = [(x1 - window[0]) * zoom, (y1 - window[1]) * zoom, (x2 - window[0]) * zoom, (y2 - window[1]) * zoom]
    draw.rectangle(box, outline=(255, 60, 60) if error["error"] == "false alarm" else (255, 220, 0))
    draw.text((3, 3), f"{error['class']} {error.get('score', 'missed')}", fill=(120, 220, 255))
    return picture


def sheet(chips: Chips, rows: list[dict]) -> Image.Image:
    """The first errors side by side: misses, then false alarms of falling score."""
    picture = Image.new("RGB", (SHEET_COLUMNS * CROP_PX, SHEET_ROWS * CROP_PX))
    misses = [row for row in rows if row["error"] == "miss"][: SHEET_COLUMNS * SHEET_ROWS // 2]
    alarms = sorted((row for row in rows if row["error"] != "miss"), key=lambda row: -row["score"])
    for slot, row in enumerate((misses + alarms)[: SHEET_COLUMNS * SHEET_ROWS]):
        picture.paste(crop(chips, row), (slot % SHEET_COLUMNS * CROP_PX, slot // SHEET_COLUMNS * CROP_PX))
    return picture


def evaluate(network, meta: dict, val: Chips | None, test: Chips, tiles: "real.Tiles | None", out: Path, score=None) -> dict:
    """Chooses the confidence on `val` unless it is given, measures `test` and the real tiles with it, writes all files."""
    report = {}
    if val is not None:
        report["val"], _, _ = measure(network, meta, val, score)
        score = report["val"]["at_score"]["score"]
    report["test"], found, truth = measure(network, meta, test, score)
    report["score"] = score
    rows = metrics.errors(found, truth, test.names, meta["names"], score)
    sheet(test, rows).save(out / "errors.png")
    if tiles is not None:
        report["real"] = {split: measure_real(network, meta, tiles, split, score) for split in ("val", "test") if split in tiles.split}
        report["real"]["plain"] = measure_plain(network, meta, tiles, score)
    (out / "errors.json").write_text(json.dumps(rows, indent=0) + "\n")
    (out / "metrics.json").write_text(json.dumps(report, indent=1) + "\n")
    return report


def find(network, meta: dict, chips: Chips) -> list:
    """What remains in each chip after suppression across classes."""
    return [suppress(rows, agnostic=True) for rows in look_twice(network, meta["anchors"], chips)]


def measure_real(network, meta: dict, tiles: "real.Tiles", split: str, score: float) -> dict:
    """Effigies in real tiles, against boxes with and without the shadow, with and without effigies that a tile's edge cuts."""
    report, whole, found = {}, tiles.whole()[tiles.split == split], None
    for name, extended in (("echo_and_shadow", True), ("echo_only", False)):
        chips = real.single_chips(tiles, split, extended, meta)
        found = found or find(network, meta, chips)
        report[name] = measure_effigies(found, truths(chips), chips.names, meta, score)
        kept = [[rows for rows, keep in zip(each, whole) if keep] for each in (found, truths(chips), chips.names)]
        report[name + "_whole"] = measure_effigies(*kept, meta, score)
    return report


def measure_effigies(found: list, truth: list, chips: list[str], meta: dict, score: float) -> dict:
    """Precision and counts of the one class that the real tiles label; `any_class` asks only whether the object was seen."""
    kind = meta["names"].index(real.CLASS)
    only = [rows[rows[:, 5] == kind] for rows in found]
    any_class = [np.concatenate([rows[:, :5], np.full((len(rows), 1), kind)], 1) for rows in found]
    report = {"chips": len(chips), "truths": sum(len(t) for t in truth)}
    for name, rows in (("", only), ("_any_class", any_class)):
        for limit in (0.5, 0.3):
            report[f"ap{limit * 100:.0f}{name}"] = metrics.class_precision(rows, truth, kind, limit)["all_points"]
        report[f"at_score{name}"] = metrics.counts(rows, truth, score)
    return report | {"sweep": metrics.sweep(only, truth), "errors": metrics.errors(only, truth, chips, meta["names"], score)}


def measure_plain(network, meta: dict, tiles: "real.Tiles", score: float) -> dict:
    """What is found in real tiles that hold no effigy; other objects lie there, unlabelled, so only effigies are false."""
    chips = real.single_chips(tiles, "plain", True, meta)
    found = find(network, meta, chips)
    kinds = np.concatenate([rows[rows[:, 4] >= score, 5] for rows in found])
    return {"chips": len(chips), "found": {name: int((kinds == kind).sum()) for kind, name in enumerate(meta["names"])}}


def main() -> None:
    """Reads the arguments and measures a stored network."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--weights", required=True)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--real", type=Path)
    parser.add_argument("--score", type=float, help="confidence of the counts (default: the best F1 on validation chips)")
    parser.add_argument("--out", type=Path, required=True)
    args = parser.parse_args()
    network, meta = load_weights(args.weights, build)
    device = "cuda" if torch.cuda.is_available() else "cpu"
    args.out.mkdir(parents=True, exist_ok=True)
    meta["pixel_m"] = read_manifest(args.data).get("pixel_m", meta["pixel_m"])
    tiles = real.read_tiles(args.real) if args.real else None
    val = None if args.score else read_split(args.data, "val")
    report = evaluate(network.to(device), meta, val, read_split(args.data, "test"), tiles, args.out, args.score)
    print(json.dumps(report["test"]["at_score"], indent=1))


if __name__ == "__main__":
    main()
