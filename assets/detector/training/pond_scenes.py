"""Chips of ponds whose recorder, water, bed and objects vary, to train on: the physics of a simulator that is not Bathyscope's.

    python pond_scenes.py OUT [--first 1] [--last 60] [--scenes 11] [--sheet sheet.png]

The laws are those of `pond.py` (a second simulator, which checks Bathyscope and is no part of it): Lambert's law with a facet
term near the nadir, a beam pattern, spreading, pulse, speckle, ring-down, a noise floor under a time-varied gain. `pond.py` itself
makes one recorder over one kind of pond. Here the exponent, the pattern, the pulse, the floor, the gain, the compression (decibels,
amplitude down to its eighth root), range, depth, speed and ping rate, patches, weed, mounds and objects are drawn anew for every
scene. `ponds.py` measures on what `pond.py` makes from other seeds.

Each seed makes `--scenes` scenes, each scene chips of both sides, drawn and levelled as the program does (`raster.py`). An object
is asked for where the rectangle that shows it best has a signal-to-noise ratio of 5. Between two boxes its shadow fades: where the
mean level differs by 1 dB and by 2 dB; the label is the mean of both.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from ground import Folder
from pond_sonar import ROSE, Pass
from raster import PIXEL_M, SIDE, raster
from real import levelled

NAMES = ["rock", "block", "cylinder", "tyre", "boat", "log", "effigy"]
# A bar of 2 to 4 m, 0.25 to 0.5 m thick: as long and as thick as the cylinders of `bathyscope simulate`.
CLASS = {"rock": "rock", "block": "block", "bar": "cylinder"}
TRACE = 2.0  # signal-to-noise ratio from which an object may be found or not
IGNORE = -1


def scene(job: tuple[int, int]) -> list:
    """The chips of one stretch: picture, boxes asked for, boxes that may be found or not."""
    boat = Pass(np.random.default_rng(job))
    rng, one = boat.rng, boat.recorder
    things = boat.bed.strew(boat, rng)
    whole, chips = slice(0, len(boat.heading)), []
    along_m = 0.001 + one.ping_m * np.arange(len(boat.heading))
    means = {sign: boat.heard(sign, whole, things) for sign in (-1, 1)}
    drawn = {sign: boat.drawn(means[sign], sign) for sign in (-1, 1)}
    boat.scale(drawn[1])
    for sign in (-1, 1):
        picture = raster(boat.levels(drawn[sign]), along_m, boat.per_sample_m, one.range_m)
        rows = []
        for thing in things:
            if found := boat.shown(thing, [other for other in things if other is not thing], sign, means[sign]):
                clear, (first, last, near, far) = found
                kind = NAMES.index(CLASS[thing.kind]) if clear >= ROSE else IGNORE
                top, bottom = np.interp([first - 0.5, last - 0.5], np.arange(len(along_m)), along_m) / PIXEL_M
                if clear >= TRACE:
                    rows.append((kind, near / PIXEL_M, top, far / PIXEL_M, bottom))
        chips += cut_up(picture, np.array(rows, np.float32).reshape(-1, 5), rng)
    return chips


def cut_up(picture: np.ndarray, rows: np.ndarray, rng) -> list:
    """Chips one behind the other, each at a near, a far or a middle column; of cut objects the part that is left."""
    chips = []
    for start in range(0, len(picture) - SIDE + 1, SIDE):
        last = max(0, picture.shape[1] - SIDE)
        column = int(rng.choice([0, last, rng.integers(0, last + 1)]))
        piece = np.round(picture[start : start + SIDE, column : column + SIDE]).astype(np.uint8)
        chip = np.zeros((SIDE, SIDE), np.uint8)
        chip[:, : piece.shape[1]] = piece
        moved = rows - np.array([0, column, start, column, start], np.float32)
        within = moved.copy()
        within[:, 1:] = moved[:, 1:].clip(0, SIDE)
        areas = [(box[:, 3] - box[:, 1]).clip(0) * (box[:, 4] - box[:, 2]).clip(0) for box in (within, moved)]
        share = areas[0] / np.maximum(areas[1], 1e-6)
        within[(share < 0.5) & (within[:, 0] >= 0), 0] = IGNORE
        within = within[share > 0.05]
        asked, hidden = within[within[:, 0] >= 0].tolist(), within[within[:, 0] < 0, 1:].tolist()
        chips.append((chip, asked, hidden))
    return chips


def sheet(chips: list, path: str, columns: int = 6, rows: int = 4) -> None:
    """Some chips, their boxes drawn: green is asked for, grey is not."""
    picture = Image.new("RGB", (columns * SIDE, rows * SIDE))
    for slot, (chip, boxes, hidden) in enumerate(chips[: columns * rows]):
        tile = Image.fromarray(levelled(chip)).convert("RGB")
        draw = ImageDraw.Draw(tile)
        for box in hidden:
            draw.rectangle(box, outline=(150, 150, 150))
        for kind, *box in boxes:
            draw.rectangle(box, outline=(60, 255, 90))
            draw.text((box[0], box[3] + 1), NAMES[int(kind)], fill=(60, 255, 90))
        picture.paste(tile, (slot % columns * SIDE, slot // columns * SIDE))
    picture.save(path)


def main() -> None:
    """Reads the arguments, makes all chips, tells what they hold."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--last", type=int, default=60)
    parser.add_argument("--scenes", type=int, default=11)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--sheet")
    args = parser.parse_args()
    jobs = [(seed, index) for seed in range(args.first, args.last + 1) for index in range(args.scenes)]
    folder, some = Folder(args.out, "train", NAMES), []
    with ProcessPoolExecutor(args.threads) as pool:
        for number, chips in enumerate(pool.map(scene, jobs, chunksize=2)):
            for chip, boxes, hidden in chips:
                folder.add(chip, boxes, hidden, f"seed {jobs[number][0]} scene {jobs[number][1]}")
            some += chips if len(some) < 24 else []
    folder.close({"program": "pond_scenes.py", "seeds": [args.first, args.last], "scenes": args.scenes})
    asked = sum(not box["iscrowd"] for box in folder.boxes)
    print(f"{len(folder.images)} chips, {asked} objects asked for, {len(folder.boxes) - asked} not")
    if args.sheet:
        sheet(some, args.sheet)


if __name__ == "__main__":
    main()
