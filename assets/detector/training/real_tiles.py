"""Prepares the real side-scan tiles of an effigy (SDVDs, A. Jaszcz and others, ODbL 1.0) for training and measuring.

    python real_tiles.py SDVD_TRAIN_DIR real.npz [contact_sheet.png]

The folder holds `images/` and `masks/` of 220 tiles of 256 x 256. Three things are settled here:

Side. Tiles named `left_` show the port side, where range grows to the left, and are mirrored. Of the tiles with numbers for
names, those of index 100 and less are port (seen from the water column and the range marks), and mirrored too.

Split. By session, never by tile: recordings that follow each other within nine minutes share pings (up to 0.87 of the
speckle correlates between neighbours), so a whole session goes to one split. The numbered tiles hold no effigy but boats,
boulders and poles without labels: they are kept apart as `plain`, only to count false effigies.

Boxes. A mask covers the echo alone, while our simulated labels cover echo and shadow. The extended box therefore runs on
outward over the dark that touches the echo on its far side.
"""

import re
import sys
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

# The range marks of the numbered tiles stand 305 px apart for 10 m; the effigy's median length of 55 px agrees with 1.8 m.
PIXEL_M = 0.033
SESSION_GAP = timedelta(minutes=9)
SESSION_SPLIT = ("val", "val", "val", "test", "train", "test", "train")
LAST_PORT_INDEX = 100
DARK = 0.6  # of the bottom's level at the same range
REACH_PX, ROWS_BESIDE_PX, FRINGE_PX, LONGEST_SHADOW_PX = 10, 8, 3, 110
SMALLEST_MASK_PX = 30


def recorded_at(name: str) -> datetime | None:
    """The time in the name of a tile, None for the numbered ones."""
    found = re.search(r"\d{14}", name)
    return datetime.strptime(found.group(0), "%Y%m%d%H%M%S") if found else None


def is_port(name: str) -> bool:
    """Whether range grows to the left in this tile."""
    return name.startswith("left_") if recorded_at(name) else int(Path(name).stem.split("_")[1]) <= LAST_PORT_INDEX


def sessions(names: list[str]) -> list[int]:
    """The session of each tile, counted from 0; -1 for the numbered tiles."""
    session, last, of_time = 0, None, {}
    for time in sorted({time for time in map(recorded_at, names) if time}):
        session += bool(last and time - last > SESSION_GAP)
        last, of_time[time] = time, session
    return [of_time[time] if (time := recorded_at(name)) else -1 for name in names]


def splits(names: list[str]) -> list[str]:
    """The split of each tile, by session; `plain` for the numbered tiles."""
    return ["plain" if session < 0 else SESSION_SPLIT[session] for session in sessions(names)]


def mean_filter(pixels: np.ndarray, rows: int, columns: int) -> np.ndarray:
    """Mean over a window of odd size, edges repeated."""
    padded = np.pad(pixels.astype(np.float64), ((rows // 2 + 1, rows // 2), (columns // 2 + 1, columns // 2)), mode="edge")
    sums = padded.cumsum(0).cumsum(1)
    return (sums[rows:, columns:] - sums[:-rows, columns:] - sums[rows:, :-columns] + sums[:-rows, :-columns]) / (rows * columns)


def grown(region: np.ndarray, within: np.ndarray) -> np.ndarray:
    """A region with everything of `within` that hangs together with it."""
    region = region & within
    while True:
        padded = np.pad(region, 1)
        rows = padded[:-2] | padded[1:-1] | padded[2:]
        larger = (rows[:, :-2] | rows[:, 1:-1] | rows[:, 2:]) & within
        if (larger == region).all():
            return region
        region = larger


def shadow(pixels: np.ndarray, mask: np.ndarray, box: tuple[int, int, int, int]) -> np.ndarray:
    """The acoustic shadow of a mask, range growing to the right: what is dark beside the bottom at the same range and
    touches the echo on its far side."""
    x1, y1, x2, y2 = box
    level = mean_filter(pixels, 3, 9)
    empty = np.percentile(pixels, 99, axis=1) < 8
    level[empty] = np.nan
    around = np.concatenate([level[max(0, y1 - 50) : max(0, y1 - ROWS_BESIDE_PX)], level[y2 + ROWS_BESIDE_PX : y2 + 50]])
    if np.isnan(around).all():
        return np.zeros_like(mask)
    dark = level < DARK * np.nanmedian(np.where(np.isnan(around).all(0), np.nanmedian(around), around), 0)
    dark[: max(0, y1 - ROWS_BESIDE_PX)] = dark[y2 + ROWS_BESIDE_PX :] = False
    dark[:, :x1] = dark[:, x2 + LONGEST_SHADOW_PX :] = False
    behind = mask.copy()
    for shift in range(1, REACH_PX + 1):
        behind[:, shift:] |= mask[:, :-shift]
    return grown(behind, dark)


def with_shadow(box: tuple[int, int, int, int], region: np.ndarray) -> tuple[int, int, int, int]:
    """The rectangle around echo and shadow, without the shadow's thinnest fringes."""
    x1, y1, x2, y2 = box
    columns, rows = np.flatnonzero(region.sum(0) >= FRINGE_PX), np.flatnonzero(region.sum(1) >= 2 * FRINGE_PX)
    if not len(columns) or not len(rows):
        return box
    return x1, min(y1, int(rows[0])), max(x2, int(columns[-1]) + 1), max(y2, int(rows[-1]) + 1)


def box_of(mask: np.ndarray) -> tuple[int, int, int, int] | None:
    """The rectangle around a mask, None where there is (nearly) nothing."""
    if mask.sum() < SMALLEST_MASK_PX:
        return None
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1


def read_tile(root: Path, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Picture and mask of one tile, turned so that range grows to the right."""
    picture = np.asarray(Image.open(root / "images" / name).convert("L"))
    mask_path = next((root / "masks").glob(Path(name).stem + ".*"))
    mask = np.asarray(Image.open(mask_path).convert("L")) > 127
    return (picture[:, ::-1], mask[:, ::-1]) if is_port(name) else (picture, mask)


def contact_sheet(images: np.ndarray, echo: list, extended: list, names: list[str], path: str) -> None:
    """Every effigy with its surroundings and both boxes, to see that sides and shadows are right."""
    size, columns, around, zoom = 180, 12, 60, 1.5
    picture = Image.new("RGB", (columns * size, -(-len(echo) // columns) * size))
    for slot, (short, long) in enumerate(zip(echo, extended)):
        x, y = (short[1] + short[3]) / 2 + 20 - around, (short[2] + short[4]) / 2 - around
        tile = Image.fromarray(images[short[0]]).crop((int(x), int(y), int(x) + 2 * around, int(y) + 2 * around))
        tile = tile.resize((size, size)).convert("RGB")
        draw = ImageDraw.Draw(tile)
        for box, colour in ((long, (0, 200, 255)), (short, (255, 60, 60))):
            moved = np.array(box[1:]) - np.array([int(x), int(y)] * 2)
            draw.rectangle((moved * zoom).tolist(), outline=colour)
        draw.text((2, 2), re.sub(r"_sample|_tile|2024", "", names[short[0]])[:24], fill=(255, 255, 0))
        picture.paste(tile, (slot % columns * size, slot // columns * size))
    picture.save(path)


def main(folder: str, out: str, sheet: str | None = None) -> None:
    """Reads all tiles, writes the arrays."""
    root = Path(folder)
    names = sorted(path.name for path in (root / "images").iterdir())
    images, echo, extended = [], [], []
    for index, name in enumerate(names):
        pixels, mask = read_tile(root, name)
        images.append(pixels)
        if box := box_of(mask):
            echo.append((index, *box))
            extended.append((index, *with_shadow(box, shadow(pixels, mask, box))))
    images, split = np.stack(images), splits(names)
    np.savez_compressed(
        out, images=images, names=names, split=split, session=sessions(names), pixel_m=PIXEL_M,
        echo=np.array(echo, np.float32), extended=np.array(extended, np.float32),
    )  # fmt: skip
    counts = {kind: split.count(kind) for kind in ("train", "val", "test", "plain")}
    longer = np.array([long[3] - short[3] for short, long in zip(echo, extended)])
    print(f"{counts}, {len(echo)} effigies, shadow {np.median(longer):.0f} px in the median, none behind {(longer == 0).sum()}")
    if sheet:
        contact_sheet(images, echo, extended, names, sheet)


if __name__ == "__main__":
    main(*sys.argv[1:])
