"""Scenes of another simulator, to measure a detector by what neither it nor its makers trained on.

    python foreign.py OUT [--chips 800] [--seed 7] [--split test] [--sheet sheet.png]

It shares no code and no law with `bathyscope simulate`: height fields that are lit ray by ray, another angular law, other speckle
(K, Weibull, several looks), range smear, other compressions, beam patterns with roll, steps of gain and of altitude. Never train on
seed 7, which measures. OUT is laid out as `data.py` reads it, all chips in the split `test`, or in `train` with `--split train`:
416 x 416 at 0.04 m, rows along track, range outward.
`test.json` says for each object its `kind`, `size_m` (its longest side), and `contrast`: by how many standard deviations of a
cell's speckle the mean over the best window of 4 x 5 cells of its echo or shadow differs from the ground without it. Objects
whose contrast is below 1, or that a chip's edge cuts, may be found or not (`iscrowd`). Half of the chips are without objects:
plain and rippled ground, weed, fish, banks, patches, lost pings, water.
"""

import argparse
import json
import math
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw
from scipy import ndimage

from real import levelled

SIDE, PIXEL_M = 416, 0.04
NAMES = ("rock", "block", "cylinder", "tyre", "boat", "log", "effigy")
# What each kind may rightly be called; None: no class of the detector is its own.
CLASS = {"rock": "rock", "block": "block", "bar": None, "tyre": "tyre", "cylinder": "cylinder", "ring": None}
# What a detector that knows no class of their own had better call them.
NEAREST = {"bar": "cylinder", "ring": "tyre"}
ALONG_M, ACROSS_M, BIN_M = 0.04, 0.01, 0.02
MARGIN = 24  # rows before and behind the chip
SHOWN, LEAST_CONTRAST = 0.7, 1.0  # deviations of a cell's speckle
WINDOW = (4, 5)  # cells, 20 in all


@dataclass
class Recorder:
    """What one sounder does between the water and the picture."""

    beam_rad: float
    ping_m: float
    smear_m: float
    speckle: str
    shape: float
    grain: int
    floor: float
    compression: str
    power: float
    tilt_rad: float
    lobe_rad: float
    roll_rad: float
    left_over: float

    @staticmethod
    def draw(rng) -> "Recorder":
        """Any of the recorders that an owner of a small boat might have."""
        speckle = str(rng.choice(["k", "weibull", "looks"]))
        shape = {"k": rng.uniform(1.5, 15), "weibull": rng.uniform(0.8, 1.5), "looks": rng.uniform(0.8, 4)}[speckle]
        compression = str(rng.choice(["power", "log"], p=[0.6, 0.4]))
        return Recorder(
            math.radians(rng.uniform(0.4, 2.0)), rng.uniform(0.04, 0.16), rng.choice([0.01, 0.03, 0.08, 0.16]) * rng.uniform(0.7, 1.3),
            speckle, shape, int(rng.integers(1, 5)), 10 ** rng.uniform(-3, -0.7), compression, rng.uniform(0.5, 1.1), math.radians(rng.uniform(15, 40)),
            math.radians(rng.uniform(25, 50)), math.radians(rng.uniform(0, 3)), rng.uniform(-0.4, 0.4),
        )  # fmt: skip


def rough(shape, cells: float, rng) -> np.ndarray:
    """A smooth random field of unit deviation whose features are `cells` long along rows and columns."""
    step = max(1, int(cells / 3))
    small = rng.standard_normal((shape[0] // step + 3, shape[1] // step + 3))
    small = ndimage.gaussian_filter(small, cells / step / 2)
    large = ndimage.zoom(small, step, order=1)[: shape[0], : shape[1]] if step > 1 else small[: shape[0], : shape[1]]
    return (large / max(float(small.std()), 1e-9)).astype(np.float32)


def wide(shape, length_m: float, rng) -> np.ndarray:
    """`rough` in metres: the columns are finer than the rows."""
    field = rough((shape[0], int(shape[1] * ACROSS_M / ALONG_M) + 2), length_m / ALONG_M, rng)
    return ndimage.zoom(field, (1, ALONG_M / ACROSS_M), order=1)[:, : shape[1]]


def ground(x, y, rng, plain: bool) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Heights (m) and strengths of a bottom, and what it holds that is no object."""
    shape, holds = (len(x), len(y)), []
    z = 0.03 * rng.uniform(0.2, 1.5) * wide(shape, rng.uniform(1, 4), rng)
    strength = np.exp(rng.uniform(0.05, 0.35) * wide(shape, rng.uniform(0.5, 3), rng))
    z += 10 ** rng.uniform(-3.2, -2.2) * rough(shape, 4, rng)
    xx, yy = x[:, None], y[None]
    if rng.random() < 0.25:
        length, angle = rng.uniform(0.25, 1.2), rng.uniform(0, math.pi)
        bent = 0.4 * wide(shape, 3, rng)
        phase = 2 * math.pi * (xx * math.cos(angle) + yy * math.sin(angle) + 0.3 * length * bent) / length
        z += length * rng.uniform(0.01, 0.05) * np.abs(np.sin(phase / 2)) * (wide(shape, 5, rng) > rng.uniform(-1.5, 0.5))
        holds.append("ripples")
    if rng.random() < 0.25:
        edge = ndimage.gaussian_filter((wide(shape, rng.uniform(1.5, 5), rng) > rng.uniform(-0.5, 1)).astype(np.float32), (1, 4))
        strength = strength * np.exp(edge * rng.choice([-1, 1]) * rng.uniform(0.4, 1.4))
        holds.append("patches")
    if not plain and rng.random() < 0.35:
        meadow = np.clip(wide(shape, rng.uniform(1.0, 3.0), rng) - rng.uniform(0.0, 1.0), 0, 1)
        leaves = np.clip(rough(shape, 3, rng) + rough(shape, 9, rng), 0, None)
        z += rng.uniform(0.02, 0.09) * meadow * leaves
        strength = strength * (1 + rng.uniform(0, 1.5) * meadow * leaves)
        holds.append("weed")
    if not plain and rng.random() < 0.2:
        line = rng.uniform(0.35, 0.9) * y[-1] + 1.5 * wide(shape, 6, rng)[:, :1]
        z += rng.choice([-1, 1]) * rng.uniform(0.3, 1.5) / (1 + np.exp(-(yy - line) / rng.uniform(0.3, 1.5)))
        holds.append("bank")
    if not plain and rng.random() < 0.15:
        stones = rng.integers(30, 200)
        for _ in range(stones):
            bump(z, x, y, rng.uniform(x[0], x[-1]), rng.uniform(y[0], y[-1]), rng.uniform(0.03, 0.08), rng.uniform(0.02, 0.06))
        holds.append("gravel")
    return z.astype(np.float32), strength.astype(np.float32), holds


def window(x, y, at_x: float, at_y: float, reach: float) -> tuple[slice, slice, np.ndarray, np.ndarray]:
    """The part of the grids within `reach` of a place, and coordinates from it."""
    rows = slice(*np.searchsorted(x, (at_x - reach, at_x + reach)))
    columns = slice(*np.searchsorted(y, (at_y - reach, at_y + reach)))
    return rows, columns, (x[rows] - at_x)[:, None], (y[columns] - at_y)[None]


def bump(z, x, y, at_x, at_y, radius, height) -> None:
    """Adds one smooth stone."""
    rows, columns, u, v = window(x, y, at_x, at_y, radius)
    z[rows, columns] += height * np.sqrt(np.clip(1 - (u**2 + v**2) / radius**2, 0, None))


def put(kind: str, z, strength, x, y, at, size: float, rng) -> tuple[np.ndarray, np.ndarray, float]:
    """The bottom with one object of a longest side `size` on it: heights, strengths, and its height."""
    rows, columns, u, v = window(x, y, *at, 0.75 * size + 0.1)
    angle = rng.uniform(0, math.pi)
    along, beside = u * math.cos(angle) + v * math.sin(angle), v * math.cos(angle) - u * math.sin(angle)
    half = size / 2
    if kind == "rock":
        lumps = 1 + 0.18 * sum(np.cos(n * np.arctan2(beside, along) + rng.uniform(0, 6)) / n for n in (2, 3, 4, 5))
        height = size * rng.uniform(0.15, 0.6)
        inner = (along / half) ** 2 + (beside / (half * rng.uniform(0.6, 1.0))) ** 2
        top = height * np.clip(1 - (inner * lumps) ** rng.uniform(1, 2), 0, None) ** 0.5
    elif kind in ("block", "bar"):
        width = half * (rng.uniform(0.5, 1.0) if kind == "block" else rng.uniform(0.06, 0.14))
        height = 2 * width * rng.uniform(0.5, 1.0) if kind == "bar" else size * rng.uniform(0.3, 0.7)
        top = height * ((np.abs(along) < half) & (np.abs(beside) < width)) * (1 + rng.uniform(-0.2, 0.2) * along / half)
    elif kind == "cylinder":
        radius = half * rng.uniform(0.18, 0.4)
        height = radius * rng.uniform(1.0, 1.9)
        top = (height - radius + np.sqrt(np.clip(radius**2 - beside**2, 0, None))) * ((np.abs(along) < half) & (np.abs(beside) < radius))
    else:
        tube = half * (rng.uniform(0.22, 0.34) if kind == "tyre" else rng.uniform(0.08, 0.14))
        lean = rng.uniform(-0.35, 0.35) if kind == "tyre" else 0.0
        away = np.hypot(along, beside) - (half - tube)
        height = 2 * tube * rng.uniform(0.6, 1.0)
        top = np.where(np.abs(away) < tube, height - tube + np.sqrt(np.clip(tube**2 - away**2, 0, None)) + lean * (along + half), 0)
    top = np.clip(top, 0, None)
    higher, stronger = z.copy(), strength.copy()
    base = float(np.median(z[rows, columns])) if z[rows, columns].size else 0.0
    higher[rows, columns] = np.where(top > 0, np.maximum(z[rows, columns], base + top), z[rows, columns])
    material = 10 ** rng.uniform(-0.5, 0.5)
    stronger[rows, columns] = np.where(top > 0, material * np.median(strength), strength[rows, columns])
    return higher, stronger, float(top.max(initial=0))


class Sonar:
    """The geometry of one chip: where the transducer is ping by ping, and what it hears without noise."""

    def __init__(self, recorder: Recorder, rng):
        self.recorder, self.rows = recorder, SIDE + 2 * MARGIN
        self.x = np.arange(self.rows) * ALONG_M
        drift = 0.06 * ndimage.gaussian_filter1d(np.cumsum(rng.standard_normal(self.rows)) * 0.1, 20)
        step = (rng.random() < 0.15) * rng.uniform(-0.3, 0.3) * (np.arange(self.rows) > rng.integers(0, self.rows))
        self.height = np.clip(10 ** rng.uniform(math.log10(1.5), math.log10(7)) + drift + step, 1.0, None)
        self.near = max(0.0, rng.uniform(0.6, 1.0) * float(self.height[0])) if rng.random() < 0.35 else float(self.height[0]) + rng.uniform(0, 9)
        self.far = self.near + SIDE * PIXEL_M
        self.y = np.arange(0.05, math.sqrt(self.far**2 - 1) + 1, ACROSS_M, dtype=np.float64)
        period = rng.uniform(60, 200)
        self.roll = recorder.roll_rad * np.sin(2 * math.pi * (np.arange(self.rows) / period + rng.random()))
        self.exponent, self.gloss = rng.uniform(0.7, 2.2), rng.uniform(0, 6)
        self.dull = rng.uniform(0.02, 0.12)
        self.bins = int(SIDE * PIXEL_M / BIN_M)

    def hear(self, z, strength) -> np.ndarray:
        """Mean intensity `[rows, bins]` of slant range, beam and floor included, gain not yet."""
        below = self.height[:, None] - z
        angle = -below / self.y[None]
        highest = np.maximum.accumulate(angle, 1)
        lit = angle >= highest - 1e-6
        slope = np.gradient(z, ACROSS_M, axis=1)
        slant = np.sqrt(self.y[None] ** 2 + below**2)
        facing = np.clip((self.y[None] * slope + below) / (slant * np.sqrt(1 + slope**2)), 0, 1)
        area = np.minimum(np.sqrt(1 + slope**2), 12)
        law = facing**self.exponent + self.gloss * np.exp(-(1 - facing) / 0.03) * 0.3 + self.dull * facing
        depression = np.arctan2(below, self.y[None]) - self.recorder.tilt_rad + self.roll[:, None]
        heard = lit * law * area * strength * np.exp(-((depression / self.recorder.lobe_rad) ** 2))
        at = ((slant - self.near) / BIN_M).astype(np.int64)
        inside = (at >= 0) & (at < self.bins)
        flat = (np.arange(self.rows)[:, None] * self.bins + at)[inside]
        sums = np.bincount(flat, heard[inside], self.rows * self.bins).reshape(self.rows, self.bins)
        return self.beam(sums)

    def beam(self, heard) -> np.ndarray:
        """The along-track beam, which widens with range, in eight bands."""
        edges = np.linspace(0, self.bins, 9).astype(int)
        out = np.empty_like(heard)
        for low, high in zip(edges[:-1], edges[1:]):
            spread = (self.near + (low + high) / 2 * BIN_M) * self.recorder.beam_rad / 2.35 / ALONG_M
            out[:, low:high] = ndimage.gaussian_filter1d(heard[:, low:high], max(spread, 0.3), axis=0)
        return out


class Picture:
    """From mean intensities to a chip: floor, gain, speckle, smear, compression, level."""

    def __init__(self, sonar: Sonar, bare: np.ndarray, rng):
        self.recorder, self.sonar = sonar.recorder, sonar
        flat = ndimage.uniform_filter1d(np.median(bare, 0), 41)
        self.gain = (1 / np.maximum(flat, 0.02 * flat.max())) ** (1 - abs(self.recorder.left_over)) * np.exp(
            self.recorder.left_over * np.linspace(-1, 1, sonar.bins)
        )
        self.floor = self.recorder.floor * float(np.median(bare[bare > 0])) * rng.uniform(0.5, 2)
        self.pings = np.unique((np.arange(0, sonar.rows, max(self.recorder.ping_m / ALONG_M, 1.0))).astype(int))
        jitter = np.exp(rng.uniform(0, 0.12) * rng.standard_normal(len(self.pings)))
        step = np.where(np.arange(len(self.pings)) > rng.integers(0, len(self.pings)), 10 ** rng.uniform(-0.25, 0.25), 1)
        self.of_ping = (jitter * (step if rng.random() < 0.2 else 1))[:, None]
        self.linear = rng.random() < 0.7
        kernel = np.exp(-np.arange(0, 5 * self.recorder.smear_m, BIN_M) / self.recorder.smear_m)
        self.kernel = kernel / kernel.sum()

    def smeared(self, intensity) -> np.ndarray:
        """What the receiver's pulse and filter leave: an echo that trails outward."""
        return ndimage.convolve1d(intensity, self.kernel, axis=1, origin=-(len(self.kernel) // 2), mode="nearest")

    def means(self, heard) -> np.ndarray:
        """Mean intensities of the pings, gain included."""
        return self.smeared((heard[self.pings] + self.floor) * self.gain[None]) * self.of_ping

    def speckled(self, heard, rng) -> np.ndarray:
        """One draw of the pings."""
        mean, shape = (heard[self.pings] + self.floor) * self.gain[None], self.recorder.shape
        grains = (mean.shape[0], -(-mean.shape[1] // self.recorder.grain))
        if self.recorder.speckle == "weibull":
            noise = rng.weibull(shape, grains) / math.gamma(1 + 1 / shape)
        elif self.recorder.speckle == "k":
            noise = rng.exponential(1, grains) * rng.gamma(shape, 1 / shape, grains)
        else:
            noise = rng.gamma(shape, 1 / shape, grains)
        noise = noise.repeat(self.recorder.grain, 1)[:, : mean.shape[1]]
        return self.smeared(mean * noise) * self.of_ping

    def compressed(self, intensity) -> np.ndarray:
        """The recorder's law, on the scale of the bottom."""
        amplitude = np.sqrt(np.maximum(intensity, 0) / self.white)
        if self.recorder.compression == "log":
            return np.log1p(amplitude * 12) / math.log(13)
        return amplitude**self.recorder.power

    def gridded(self, pings) -> np.ndarray:
        """The chip's own cells: bins by twos, pings between neighbours or the nearest one."""
        pings = pings.reshape(len(pings), -1, 2).mean(2)
        wanted = np.arange(MARGIN, MARGIN + SIDE)
        at = np.interp(wanted, self.pings, np.arange(len(self.pings)))
        if not self.linear:
            return pings[np.round(at).astype(int)]
        low = np.minimum(at.astype(int), len(pings) - 2)
        share = (at - low)[:, None]
        return pings[low] * (1 - share) + pings[low + 1] * share

    def draw(self, heard, rng) -> np.ndarray:
        """The chip in levels before rounding; settles white and level."""
        intensity = self.speckled(heard, rng)
        self.white = float(np.percentile(intensity, 99.5)) * rng.uniform(0.6, 2.5)
        level = np.clip(255 * self.gridded(self.compressed(intensity)), 0, 255)
        lit = levelled(level.astype(np.uint8))
        grows = level > 20
        self.level = float(np.median(lit[grows] / level[grows])) if grows.any() else 1.0
        return lit

    def shown(self, heard) -> np.ndarray:
        """A chip of mean levels."""
        return np.minimum(255 * self.level * self.gridded(self.compressed(self.means(heard))), 255)

    def deviation(self, heard, rng) -> np.ndarray:
        """Standard deviation of a cell's level where the bottom is bare, smoothed over 25 cells."""
        draws = [np.minimum(255 * self.level * self.gridded(self.compressed(self.speckled(heard, rng))), 255) for _ in range(3)]
        return np.sqrt(ndimage.uniform_filter(np.var(draws, 0, ddof=1), 25)) + 1.0


def shows(bare, shown, deviation, before: tuple[int, int]) -> tuple[float, list[float] | None]:
    """Contrast of an object and the box around its echo and shadow: the cells around it that differ and hang together."""
    apart = (shown - bare) / deviation
    contrast = float(np.abs(ndimage.uniform_filter(apart, WINDOW)).max())
    differs = np.abs(ndimage.uniform_filter(apart, 3)) > SHOWN
    regions, count = ndimage.label(ndimage.binary_dilation(differs, iterations=3))
    if not count:
        return contrast, None
    weight = ndimage.sum(np.abs(apart) * differs, regions, np.arange(1, count + 1))
    own = differs & (regions == 1 + int(np.argmax(weight)))
    rows, columns = np.flatnonzero(own.sum(1) >= 2), np.flatnonzero(own.sum(0) >= 2)
    if len(rows) < 3 or len(columns) < 3:
        return contrast, None
    return contrast, [float(columns[0]), float(rows[0]), float(columns[-1] + 1), float(rows[-1] + 1)]


def fish(heard, sonar: Sonar, rng) -> None:
    """Echoes above the bottom, some of them a school."""
    for _ in range(rng.integers(1, 15)):
        row, column = rng.integers(0, sonar.rows), rng.integers(0, sonar.bins)
        length = rng.integers(2, 12)
        level = float(np.median(heard[heard > 0])) * 10 ** rng.uniform(0, 1.2)
        heard[row : row + length, column : column + rng.integers(2, 8)] += level


def scene(job: tuple[int, int, bool]) -> tuple[np.ndarray, list[dict], list[str]]:
    """One chip: its picture, its objects, and what else lies there."""
    seed, index, occupied = job
    rng = np.random.default_rng((seed, index))
    sonar = Sonar(Recorder.draw(rng), rng)
    z, strength, holds = ground(sonar.x, sonar.y, rng, plain=occupied and rng.random() < 0.6)
    bare, objects = sonar.hear(z, strength), []
    states = [bare]
    for _ in range(rng.integers(1, 4) if occupied else 0):
        kind = str(rng.choice(list(CLASS), p=[0.35, 0.2, 0.12, 0.12, 0.12, 0.09]))
        size = {"bar": rng.uniform(1.2, 4), "cylinder": rng.uniform(0.6, 2), "tyre": rng.uniform(0.5, 1.1)}.get(kind, 0.25 * 10 ** rng.uniform(0, 0.9))
        slant = rng.uniform(max(sonar.near + 0.5, 1.15 * float(sonar.height.max())), sonar.far - 1)
        at = (rng.uniform(MARGIN + 20, MARGIN + SIDE - 20) * ALONG_M, math.sqrt(max(slant**2 - sonar.height[0] ** 2, 0.1)))
        if any(math.hypot(at[0] - o["at"][0], at[1] - o["at"][1]) < 3.5 + size for o in objects):
            continue
        z, strength, height = put(kind, z, strength, sonar.x, sonar.y, at, size, rng)
        states.append(sonar.hear(z, strength))
        objects.append({"kind": kind, "size_m": round(size, 2), "height_m": round(height, 2), "at": at})
    heard = states[-1].copy()
    if not occupied and rng.random() < 0.2:
        fish(heard, sonar, rng)
        holds.append("fish")
    picture = Picture(sonar, bare, rng)
    chip = picture.draw(heard, rng)
    if rng.random() < 0.15:
        for row in rng.integers(0, SIDE, rng.integers(1, 6)):
            chip[row : row + rng.integers(1, 4)] = rng.integers(0, 60)
        holds.append("lost pings")
    if objects:
        deviation, means = picture.deviation(bare, rng), [picture.shown(state) for state in states]
        for number, one in enumerate(objects):
            one["contrast"], one["box"] = shows(means[number], means[number + 1], deviation, one.pop("at"))
    return chip, [one for one in objects if one["box"]], holds


def coco(scenes: list) -> dict:
    """All chips and boxes as COCO has them."""
    images, boxes = [], []
    for index, (_, objects, holds) in enumerate(scenes):
        images.append({"id": index, "file_name": f"{index:06}.png", "width": SIDE, "height": SIDE, "holds": holds})
        for one in objects:
            x1, y1, x2, y2 = one["box"]
            cut = min(x1, y1) < 2 or max(x2, y2) > SIDE - 2
            row = {"id": len(boxes), "image_id": index, "category_id": NAMES.index(CLASS[one["kind"]] or NEAREST[one["kind"]]) + 1}
            row |= {"bbox": [x1, y1, x2 - x1, y2 - y1], "area": (x2 - x1) * (y2 - y1), "iscrowd": int(cut or one["contrast"] < LEAST_CONTRAST)}
            boxes.append(row | {key: one[key] for key in ("kind", "size_m", "height_m")} | {"contrast": round(one["contrast"], 2)})
    categories = [{"id": number, "name": name} for number, name in enumerate(NAMES, 1)]
    return {"images": images, "annotations": boxes, "categories": categories}


def write(out: Path, scenes: list, seed: int, split: str) -> dict:
    """The folder."""
    for folder in (f"images/{split}", f"labels/{split}"):
        (out / folder).mkdir(parents=True)
    data = coco(scenes)
    lines = {index: [] for index in range(len(scenes))}
    for box in data["annotations"]:
        x, y, width, height = box["bbox"]
        if not box["iscrowd"]:
            place = ((x + width / 2) / SIDE, (y + height / 2) / SIDE, width / SIDE, height / SIDE)
            lines[box["image_id"]].append(f"{box['category_id'] - 1} " + " ".join(f"{value:.6f}" for value in place))
    for index, (chip, _, _) in enumerate(scenes):
        Image.fromarray(chip).save(out / f"images/{split}/{index:06}.png")
        (out / f"labels/{split}/{index:06}.txt").write_text("".join(line + "\n" for line in lines[index]))
    (out / f"{split}.json").write_text(json.dumps(data))
    (out / "classes.txt").write_text("".join(name + "\n" for name in NAMES))
    (out / "manifest.json").write_text(json.dumps({"program": "foreign.py", "seed": seed, "pixel_m": PIXEL_M}) + "\n")
    return data


def sheet(scenes: list, path: str, first: int, columns: int = 6, rows: int = 4) -> None:
    """Some chips, their boxes drawn: green is asked for, grey is not."""
    picture = Image.new("RGB", (columns * 300, rows * 300))
    for slot, (chip, objects, holds) in enumerate(scenes[first : first + columns * rows]):
        tile = Image.fromarray(chip).convert("RGB").resize((300, 300))
        draw = ImageDraw.Draw(tile)
        for one in objects:
            colour = (60, 255, 90) if one["contrast"] >= LEAST_CONTRAST else (150, 150, 150)
            x1, y1, x2, y2 = (value * 300 / SIDE for value in one["box"])
            draw.rectangle((x1 - 2, y1 - 2, x2 + 2, y2 + 2), outline=colour)
            draw.text((x1, y2 + 2), f"{one['kind']} {one['size_m']} c{one['contrast']:.1f}", fill=colour)
        draw.text((3, 3), " ".join(holds), fill=(120, 200, 255))
        picture.paste(tile, (slot % columns * 300, slot // columns * 300))
    picture.save(path)


def main() -> None:
    """Reads the arguments, makes all chips, tells what they hold."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--chips", type=int, default=800)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--split", default="test", choices=["test", "train"], help="train: never with seed 7")
    parser.add_argument("--threads", type=int)
    parser.add_argument("--sheet")
    args = parser.parse_args()
    jobs = [(args.seed, index, index % 2 == 0) for index in range(args.chips)]
    with ProcessPoolExecutor(args.threads) as pool:
        scenes = list(pool.map(scene, jobs, chunksize=4))
    data = write(args.out, scenes, args.seed, args.split)
    asked = [box for box in data["annotations"] if not box["iscrowd"]]
    hectares = args.chips * (SIDE * PIXEL_M) ** 2 / 1e4
    print(f"{len(asked)} objects asked for, {len(data['annotations']) - len(asked)} not, {hectares:.1f} ha in {args.chips} chips")
    if args.sheet:
        sheet(scenes, args.sheet, 0)


if __name__ == "__main__":
    main()
