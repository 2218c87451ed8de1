"""Real tiles as chips: packed side by side for training, one by one for measuring.

`real.npz` is written by `real_tiles.py`: tiles of 256 x 256 turned so that range grows to the right, a split by recording,
and for each effigy a box of its echo alone and one extended over its shadow.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from PIL import Image

from data import IGNORE, Chips, pad_boxes

CLASS = "effigy"
SLIVER_PX = 6.0
# How much larger or smaller than it is a tile is shown in training: its scale is known to about a fifth.
SCALES, SCALE_STEPS = (0.75, 1.4), 8
# Share of the training chips that hold one tile on black, as `single_chips` shows them; the others are full of tiles.
LONE_SHARE = 0.4
# Share of these that show a window of the tile only, its least side as a share of the tile's, and the least part of an effigy
# that is asked for there.
WINDOW_SHARE, SMALLEST_WINDOW, LEAST_PART = 0.7, 0.4, 0.15


@dataclass
class Tiles:
    """`images [n, rows, columns]` u8; `echo` and `extended [m, 5]`: tile, x1, y1, x2, y2; the rest one per tile."""

    images: np.ndarray
    echo: np.ndarray
    extended: np.ndarray
    split: np.ndarray
    names: np.ndarray
    pixel_m: float
    session: np.ndarray

    def whole(self) -> np.ndarray:
        """Which tiles cut no effigy at their edge (those without any included)."""
        cut = (self.echo[:, 1:].min(1) < 2) | (self.echo[:, 1:].max(1) > self.images.shape[1] - 2)
        return ~np.isin(np.arange(len(self.images)), self.echo[cut, 0])

    def boxes(self, tile: int, extended: bool) -> np.ndarray:
        """Corner boxes `[k, 4]` of one tile."""
        rows = self.extended if extended else self.echo
        return rows[rows[:, 0] == tile, 1:]


def read_tiles(path: Path) -> Tiles:
    """The tiles that `real_tiles.py` stored."""
    with np.load(path) as arrays:
        return Tiles(*(arrays[name] for name in ("images", "echo", "extended", "split", "names")), float(arrays["pixel_m"]), arrays["session"])


def leave_out(tiles: Tiles, sessions: list[int]) -> None:
    """Makes these sessions the split `test` and all others with labels `train`; `val` is empty then."""
    tiles.split = np.where(tiles.session < 0, "plain", np.where(np.isin(tiles.session, sessions), "test", "train"))


def levelled(pixels: np.ndarray) -> np.ndarray:
    """The picture at the level of every chip, as `src/objects/picture.rs` brings it: the 95th percentile of the pixels
    above 0 becomes 180, by a gain between 0.5 and 4."""
    below = np.bincount(pixels.ravel(), minlength=256)[1:].cumsum()
    if not below[-1]:
        return pixels
    gain = np.clip(180.0 / (1 + np.searchsorted(below, math.ceil(0.95 * below[-1]))), 0.5, 4.0)
    return np.minimum(np.round(pixels * gain), 255).astype(np.uint8)


def resized(tiles: Tiles, tile: int, scale: float) -> np.ndarray:
    """One tile at `scale` times its own resolution, area-averaged when smaller, at the level of a chip."""
    side = max(1, round(tiles.images.shape[1] * scale))
    how = Image.Resampling.BOX if scale < 1 else Image.Resampling.BILINEAR
    return levelled(np.asarray(Image.fromarray(tiles.images[tile]).resize((side, side), how)))


def single_chips(tiles: Tiles, split: str, extended: bool, meta: dict) -> Chips:
    """Each tile of a split at the network's resolution in the middle of a black chip."""
    side, kind = meta["side"], meta["names"].index(CLASS)
    chosen = np.flatnonzero(tiles.split == split)
    images, boxes = [], []
    for tile in chosen:
        scale = tiles.pixel_m / meta["pixel_m"]
        pixels = resized(tiles, tile, scale)
        canvas, corner = np.zeros((side, side), np.uint8), (side - len(pixels)) // 2
        paste(canvas, pixels, corner, corner)
        images.append(canvas)
        moved = tiles.boxes(tile, extended) * scale + corner
        boxes.append(np.concatenate([np.full((len(moved), 1), kind), moved], 1).astype(np.float32))
    return Chips(torch.from_numpy(np.stack(images)), pad_boxes(boxes), [str(tiles.names[tile]) for tile in chosen])


def paste(canvas: np.ndarray, pixels: np.ndarray, x: int, y: int) -> None:
    """Copies what fits of a picture to (x, y), which may lie outside."""
    side = len(canvas)
    x1, y1, x2, y2 = max(x, 0), max(y, 0), min(x + pixels.shape[1], side), min(y + pixels.shape[0], side)
    if x1 < x2 and y1 < y2:
        canvas[y1:y2, x1:x2] = pixels[y1 - y : y2 - y, x1 - x : x2 - x]


def packed_chips(tiles: Tiles, count: int, meta: dict, seed: int) -> Chips:
    """Training chips of random train tiles at random scales: most tiled with them, so that a batch of real data is as full as
    any other, the rest with one tile on black, where an effigy is cut by nothing but the tile's own edge."""
    rng, chosen, images, boxes = np.random.default_rng(seed), np.flatnonzero(tiles.split == "train"), [], []
    scales = tiles.pixel_m / meta["pixel_m"] * np.geomspace(*SCALES, SCALE_STEPS)
    pictures = {(tile, scale): resized(tiles, tile, scale) for tile in chosen for scale in scales}
    for _ in range(count):
        fill = lone if rng.random() < LONE_SHARE else pack
        canvas, rows = fill(tiles, pictures, chosen, rng.choice(scales), meta, rng)
        images.append(canvas)
        boxes.append(cut_boxes(np.array(rows, np.float32).reshape(-1, 5), meta["side"]))
    return Chips(torch.from_numpy(np.stack(images)), pad_boxes(boxes), [f"real{index:05}" for index in range(count)])


def pack(tiles: Tiles, pictures: dict, chosen: np.ndarray, scale: float, meta: dict, rng) -> tuple[np.ndarray, list]:
    """One canvas full of tiles side by side, and the boxes on it, which may reach beyond its edge."""
    side, kind, step = meta["side"], meta["names"].index(CLASS), len(pictures[chosen[0], scale])
    canvas, rows = np.zeros((side, side), np.uint8), []
    start = -rng.integers(0, step, 2)
    for y in range(start[1], side, step):
        for x in range(start[0], side, step):
            tile = rng.choice(chosen)
            paste(canvas, pictures[tile, scale], x, y)
            rows += [(kind, *box) for box in tiles.boxes(tile, True) * scale + np.array([x, y, x, y])]
    return canvas, rows


def lone(tiles: Tiles, pictures: dict, chosen: np.ndarray, scale: float, meta: dict, rng) -> tuple[np.ndarray, list]:
    """One tile, or a window of it, anywhere on a black canvas, and the boxes on it."""
    side, kind, step = meta["side"], meta["names"].index(CLASS), len(pictures[chosen[0], scale])
    tile, size = rng.choice(chosen), np.array([step, step])
    if rng.random() < WINDOW_SHARE:
        size = (step * rng.uniform(SMALLEST_WINDOW, 1, 2)).astype(int)
    corner = rng.integers(0, step - size + 1)
    place = rng.integers(np.minimum(0, side - size), np.maximum(1, side - size + 1))
    canvas, window = np.zeros((side, side), np.uint8), np.concatenate([corner, corner + size])
    paste(canvas, pictures[tile, scale][window[1] : window[3], window[0] : window[2]], *place)
    boxes = tiles.boxes(tile, True) * scale
    cut = np.concatenate([np.maximum(boxes[:, :2], window[:2]), np.minimum(boxes[:, 2:], window[2:])], 1)
    left = np.maximum(cut[:, 2:] - cut[:, :2], 0)
    share = left.prod(1) / np.maximum((boxes[:, 2:] - boxes[:, :2]).prod(1), 1e-6)
    kinds = np.where((share < LEAST_PART) | (left.min(1, initial=1e6) < SLIVER_PX), IGNORE, kind)
    rows = np.concatenate([kinds[:, None], cut + np.tile(place - corner, 2)], 1)
    return canvas, [tuple(row) for row in rows[share > 0.02]]


def cut_boxes(rows: np.ndarray, side: int) -> np.ndarray:
    """Boxes cut at the chip; those that lose more than half or are slivers become IGNORE, those outside vanish."""
    cut = rows.copy()
    cut[:, 1:] = cut[:, 1:].clip(0, side)
    area = (rows[:, 3] - rows[:, 1]) * (rows[:, 4] - rows[:, 2])
    share = (cut[:, 3] - cut[:, 1]) * (cut[:, 4] - cut[:, 2]) / np.maximum(area, 1e-6)
    sliver = np.minimum(cut[:, 3] - cut[:, 1], cut[:, 4] - cut[:, 2]) < SLIVER_PX
    cut[(share < 0.5) | sliver, 0] = IGNORE
    return cut[share > 0.02]
