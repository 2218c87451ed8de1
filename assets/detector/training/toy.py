"""Writes a toy data set in the layout of `bathyscope simulate --dataset`: speckle, bright blobs and their shadows.

Only for checking that training works, on any machine: `python toy.py DIR [TRAIN VAL TEST]`.
"""

import json
import sys
from pathlib import Path

import numpy as np
from PIL import Image

NAMES = ["rock", "block", "cylinder", "tyre", "boat", "log", "effigy"]
SIDE = 416


def chip(rng: np.random.Generator) -> tuple[np.ndarray, list]:
    """One picture and its label rows; a third of the chips are empty."""
    level = np.full((SIDE, SIDE), rng.uniform(0.15, 0.4))
    rows = []
    for _ in range(rng.choice([0, 1, 2, 3], p=[0.34, 0.33, 0.22, 0.11])):
        kind = int(rng.integers(0, 3))
        height, width = [(24, 24), (16, 60), (70, 20)][kind]
        shadow = int(rng.integers(20, 70))
        x, y = int(rng.integers(0, SIDE - width - shadow)), int(rng.integers(0, SIDE - height))
        level[y : y + height, x : x + width] = rng.uniform(0.7, 0.95)
        level[y : y + height, x + width : x + width + shadow] = 0.03
        w, h = width + shadow, height
        rows.append((kind, (x + w / 2) / SIDE, (y + h / 2) / SIDE, w / SIDE, h / SIDE))
    speckle = rng.rayleigh(0.8, level.shape)
    return (np.clip(level * speckle, 0, 1) * 255).astype(np.uint8), rows


def main(root: str, train: str = "64", val: str = "16", test: str = "16") -> None:
    """Writes the three splits."""
    rng, base = np.random.default_rng(0), Path(root)
    for split, count in (("train", train), ("val", val), ("test", test)):
        for kind in ("images", "labels"):
            (base / kind / split).mkdir(parents=True, exist_ok=True)
        for index in range(int(count)):
            pixels, rows = chip(rng)
            Image.fromarray(pixels).save(base / "images" / split / f"{index:06}.png")
            text = "".join(f"{k} {x:.6f} {y:.6f} {w:.6f} {h:.6f}\n" for k, x, y, w, h in rows)
            (base / "labels" / split / f"{index:06}.txt").write_text(text)
    (base / "classes.txt").write_text("\n".join(NAMES) + "\n")
    (base / "manifest.json").write_text(json.dumps({"pixel_m": 0.04, "note": "toy"}) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
