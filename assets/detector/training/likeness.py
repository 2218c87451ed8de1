"""How alike real and simulated pictures are: levels, speckle, echo and shadow, as a table and a picture to look at.

    python likeness.py real.npz CHIPS_DIR OUT_DIR [PICTURES_DIR...]

Compares the real effigy tiles (all sessions) with the simulated chips of the split `train` that hold an effigy, both at the
network's resolution and level, and the bottom in pictures of other recordings, such as the chips that `bathyscope detect
--score 0.02` writes. Writes `likeness.json` and `likeness.png`. Of each set, as quartiles over what is measured:

level        a pixel with signal (above 0), in parts of 255
speckle      standard deviation / mean in a window of 24 x 24 pixels of bottom; 0.52 is a fully developed Rayleigh amplitude
along, across  correlation of neighbouring pixels in such a window, along track and in range
echo         98th percentile of 3 x 3 means in an effigy's box / median of the bottom at the same range
shadow       10th percentile of 5 x 5 means in the box / the same median
"""

import json
import sys
from pathlib import Path

import numpy as np
import torch
from PIL import Image, ImageDraw

import real
from data import Chips, read_names, read_split
from real_tiles import mean_filter

WINDOW, BESIDE_PX, MOST_CHIPS = 24, 60, 400
CROP, COLUMNS, ROWS = 120, 8, 3
MEASURES = ("level", "speckle", "along", "across", "echo", "shadow")
COLOURS = ((230, 120, 40), (60, 140, 230), (90, 200, 110), (210, 90, 200), (220, 210, 80))


def windows(pixels: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """The windows of bottom: full of signal, away from every box. `[n, 24, 24]`."""
    taken = pixels == 0
    for x1, y1, x2, y2 in boxes.astype(int):
        taken[max(0, y1) : y2 + 1, max(0, x1) : x2 + 1] = True
    rows, columns = (size // WINDOW for size in pixels.shape)
    blocks = [
        array[: rows * WINDOW, : columns * WINDOW].reshape(rows, WINDOW, columns, WINDOW).swapaxes(1, 2)
        for array in (pixels, taken)
    ]
    pictures, taken = (block.reshape(-1, WINDOW, WINDOW) for block in blocks)
    return pictures[taken.mean((1, 2)) < 0.02].astype(float)


def texture(block: np.ndarray) -> tuple[float, float, float]:
    """Speckle and the correlation with the next pixel along track and across it."""
    away = block - block.mean()
    variance = max(float((away**2).mean()), 1e-9)
    along, across = (away[1:] * away[:-1]).mean() / variance, (away[:, 1:] * away[:, :-1]).mean() / variance
    return float(np.sqrt(variance) / block.mean()), float(along), float(across)


def echo_and_shadow(pixels: np.ndarray, box: np.ndarray) -> tuple[float, float] | None:
    """Both as shares of the bottom before and behind the box along track; None where too little of it is seen."""
    x1, y1, x2, y2 = (int(round(v)) for v in box)
    beside = np.concatenate([pixels[max(0, y1 - BESIDE_PX) : max(0, y1), x1:x2], pixels[y2 : y2 + BESIDE_PX, x1:x2]])
    beside, inside = beside[beside > 0], pixels[max(0, y1) : y2, max(0, x1) : x2]
    if beside.size < 500 or min(inside.shape) < 6:
        return None
    bottom = max(float(np.median(beside)), 1.0)
    echo, dark = np.percentile(mean_filter(inside, 3, 3), 98), np.percentile(mean_filter(inside, 5, 5), 10)
    return float(echo / bottom), float(dark / bottom)


def measure(chips: Chips, kind: int) -> tuple[dict[str, list], list[np.ndarray]]:
    """All values of one set, and crops around its effigies."""
    values, crops = {name: [] for name in MEASURES}, []
    for picture, rows in zip(chips.images.numpy(), chips.boxes.numpy()):
        boxes = rows[rows[:, 0] > -2]
        values["level"].append(np.bincount(picture[picture > 0], minlength=256))
        for block in windows(picture, boxes[:, 1:]):
            for name, value in zip(("speckle", "along", "across"), texture(block)):
                values[name].append(value)
        for row in boxes[boxes[:, 0] == kind]:
            if pair := echo_and_shadow(picture, row[1:]):
                values["echo"].append(pair[0])
                values["shadow"].append(pair[1])
                crops.append(crop(picture, row[1:]))
    return values, crops


def measure_bottom(folder: Path) -> tuple[dict[str, list], list[np.ndarray]]:
    """Level and texture of a folder of pictures, objects and all; no crops."""
    values = {name: [] for name in MEASURES[:4]}
    for path in sorted(folder.glob("*.png")):
        picture = np.asarray(Image.open(path).convert("L"))
        values["level"].append(np.bincount(picture[picture > 0], minlength=256))
        for block in windows(picture, np.zeros((0, 4))):
            for name, value in zip(("speckle", "along", "across"), texture(block)):
                values[name].append(value)
    return values, []


def crop(picture: np.ndarray, box: np.ndarray) -> np.ndarray:
    """The surroundings of a box, 4.8 m on a side."""
    x, y = int((box[0] + box[2] - CROP) / 2), int((box[1] + box[3] - CROP) / 2)
    return np.asarray(Image.fromarray(picture).crop((x, y, x + CROP, y + CROP)))


def quartiles(name: str, values: list) -> list[float]:
    """First quartile, median, third quartile."""
    if name != "level":
        return [round(float(v), 3) for v in np.percentile(values, (25, 50, 75))]
    counts = np.sum(values, 0).cumsum()
    return [round(int(np.searchsorted(counts, share * counts[-1])) / 255, 3) for share in (0.25, 0.5, 0.75)]


def shares(name: str, values: list, edges: np.ndarray) -> np.ndarray:
    """The histogram of one set, as shares."""
    if name == "level":
        counts = np.sum(values, 0).reshape(64, 4).sum(1).astype(float)
    else:
        counts = np.histogram(np.clip(values, edges[0], edges[-1]), edges)[0].astype(float)
    return counts / counts.sum()


def plot(draw: ImageDraw.ImageDraw, at: tuple[int, int], size: tuple[int, int], name: str, sets: dict) -> None:
    """One measure's histograms over each other, with its range below."""
    top = {"level": 1.0, "echo": 8.0, "shadow": 1.2}.get(name, 1.0)
    low = -0.2 if name in ("along", "across") else 0.0
    edges = np.linspace(low, top, 65 if name == "level" else 41)
    curves = {key: shares(name, values[name], edges) for key, (values, _) in sets.items() if name in values}
    highest = max(float(curve.max()) for curve in curves.values())
    x, y = at
    draw.rectangle((x, y, x + size[0], y + size[1]), outline=(90, 90, 90))
    for colour, (key, curve) in zip(COLOURS, curves.items()):
        step = size[0] / len(curve)
        points = [(x + (i + 0.5) * step, y + size[1] * (1 - 0.92 * v / highest)) for i, v in enumerate(curve)]
        draw.line(points, fill=colour, width=2)
    draw.text((x + 6, y + 4), f"{name}, {low:g} to {top:g}", fill=(230, 230, 230))


def sheet(sets: dict) -> Image.Image:
    """Crops of each set above each other, histograms below."""
    width, block = COLUMNS * CROP, ROWS * CROP + 18
    picture = Image.new("RGB", (width, 2 * block + 2 * 170 + 30))
    draw = ImageDraw.Draw(picture)
    for index, (key, (_, crops)) in enumerate(sets.items()):
        if not crops:
            continue
        draw.text((4, index * block + 2), f"{key}: effigies, 4.8 m on a side, range to the right", fill=COLOURS[index])
        order = np.random.default_rng(1).permutation(len(crops))[: COLUMNS * ROWS]
        for slot, chosen in enumerate(order):
            picture.paste(Image.fromarray(crops[chosen]), (slot % COLUMNS * CROP, index * block + 18 + slot // COLUMNS * CROP))
    for index, key in enumerate(sets):
        draw.text((4 + 160 * index, 2 * block + 4), key, fill=COLOURS[index])
    for index, name in enumerate(MEASURES):
        corner = (index % 3 * width // 3 + 4, 2 * block + 24 + index // 3 * 168)
        plot(draw, corner, (width // 3 - 10, 158), name, sets)
    return picture


def main(real_path: str, chips_dir: str, out: str, *others: str) -> None:
    """Measures every set, prints the table, writes both files."""
    root, out = Path(chips_dir), Path(out)
    out.mkdir(parents=True, exist_ok=True)
    tiles, chips, names = real.read_tiles(Path(real_path)), read_split(root, "train"), read_names(root)
    kind = names.index(real.CLASS)
    tiles.split[tiles.split != "plain"] = "all"
    real_chips = real.single_chips(tiles, "all", True, {"side": chips.side, "names": names, "pixel_m": 0.04})
    held = torch.nonzero((chips.boxes[..., 0] == kind).any(1))[:MOST_CHIPS, 0]
    simulated = Chips(chips.images[held], chips.boxes[held], [])
    sets = {"real": measure(real_chips, kind), "simulated": measure(simulated, kind)}
    sets |= {Path(other).name: measure_bottom(Path(other)) for other in others[: len(COLOURS) - len(sets)]}
    table = {
        name: {key: quartiles(name, values[name]) for key, (values, _) in sets.items() if name in values} for name in MEASURES
    }
    for name, rows in table.items():
        print(name.ljust(8), rows)
    (out / "likeness.json").write_text(json.dumps(table, indent=1) + "\n")
    sheet(sets).save(out / "likeness.png")


if __name__ == "__main__":
    main(*sys.argv[1:])
