"""Chips of real ground, with and without objects pasted onto it, out of waterfalls of another recorder.

    python ground.py WATERFALLS CHIPS_DIR real.npz OUT --half train [--count 2400] [--contacts contacts.json]
    python ground.py WATERFALLS CHIPS_DIR real.npz OUT --half test

WATERFALLS holds pictures of 1024 x 1024 with the nadir in the middle column (Marine Sonic on an AUV: N. Pessanha Santos, R. Moura,
Data in Brief 53:110132, figshare doi 10.6084/m9.figshare.24574879, CC BY 4.0; changed here: made grey, scaled, cut, pasted on).
Every second picture, by name, is `train`, the others are `test`: no picture is in both.

`test`: bare ground as it is, three chips of each side. What lies there is not labelled: some hold contacts.
`train`: half of the chips bare, half with one to four echoes and shadows pasted onto them, out of simulated chips (CHIPS_DIR, split
train) and of real tiles (sessions of the split train): each pixel of a crop over its own bottom's level, times the level of the
ground it comes to, its edges blended. Range grows outward in both, so a shadow falls the right way; rows may be mirrored.
`contacts.json` says what was seen to lie there already: `{"picture/side": {"objects": [[class, x1, y1, x2, y2], ...], "hidden":
[[x1, y1, x2, y2], ...]}}` in pixels of the side at 0.06 m a pixel. Objects are labels, and stock to be pasted; at hidden places, which may
hold one, no loss is taken. `contacts.json` beside this file was made from
the proposals of the detector (confidence 0.1 and more), the 192 surest looked at: objects that are contacts, hidden what cannot be told
or was not looked at, and nothing at all on surge bands.
"""

import argparse
import json
from pathlib import Path

import numpy as np
from PIL import Image
from scipy import ndimage

import real
from data import read_names, read_split

SIDE, CHIP_PIXEL_M = 416, 0.04
# Not stated by the source: 0.05 to 0.07 m.
PIXEL_M = 0.06
LEAST_CONTRAST = 1.0  # deviations of the ground's speckle, over 4 x 5 pixels
RIM, BESIDE = 10, 60  # pixels around a box that are blended, and in which its bottom is measured


def sides(path: Path, pixel_m: float = PIXEL_M) -> dict[str, np.ndarray]:
    """Port and starboard of one waterfall as grey pictures, range to the right, at the network's resolution."""
    colours = np.asarray(Image.open(path).convert("RGB"), np.float32)
    grey = colours.mean(2)
    middle = grey.shape[1] // 2
    halves = {"port": grey[:, :middle][:, ::-1], "starboard": grey[:, middle:]}
    scale = pixel_m / CHIP_PIXEL_M
    return {name: np.clip(ndimage.zoom(half, scale, order=1), 0, 255).astype(np.uint8) for name, half in halves.items()}


def chosen(folder: Path, half: str) -> list[Path]:
    """The pictures of one half."""
    paths = sorted(folder.glob("*.jpg"))
    return paths[0::2] if half == "train" else paths[1::2]


def level_around(pixels: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Mean level of the bottom beside a box, column by column of its crop (rim included)."""
    x1, y1, x2, y2 = rim(box, pixels.shape)
    above, below = pixels[max(0, y1 - BESIDE) : y1, x1:x2], pixels[y2 : y2 + BESIDE, x1:x2]
    beside = np.concatenate([above, below]).astype(np.float32)
    if len(beside) < 20:
        return np.zeros(x2 - x1, np.float32)
    return ndimage.uniform_filter1d(beside.mean(0), 25, mode="nearest")


def rim(box: np.ndarray, shape) -> tuple[int, int, int, int]:
    """A box with its rim, cut at the picture."""
    x1, y1, x2, y2 = np.round(box).astype(int)
    return max(0, x1 - RIM), max(0, y1 - RIM), min(shape[1], x2 + RIM), min(shape[0], y2 + RIM)


def crops(images, boxes: list[np.ndarray], most: int, rng) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Class, levels over the bottom's, and box within the crop, of whole objects with enough bottom around them."""
    found = []
    for index in rng.permutation(len(images)):
        pixels, rows = images[index], boxes[index]
        for row in rows[rows[:, 0] >= 0]:
            box = row[1:]
            others = rows[(rows[:, 0] > -2) & (rows[:, 1:] != box).any(1), 1:]
            x1, y1, x2, y2 = rim(box, pixels.shape)
            crowded = ((others[:, 0] < x2) & (others[:, 2] > x1) & (others[:, 1] < y2) & (others[:, 3] > y1)).any()
            level = level_around(pixels, box)
            if crowded or min(box[0], box[1]) < 3 or max(box[2], box[3]) > pixels.shape[0] - 3 or level.min() < 8:
                continue
            found.append((int(row[0]), pixels[y1:y2, x1:x2] / level[None], box - np.array([x1, y1, x1, y1])))
        if len(found) >= most:
            break
    return found


def paste(canvas: np.ndarray, crop: np.ndarray, box: np.ndarray, at: tuple[int, int]) -> bool:
    """Lays a crop over ground: the ground's own speckle, brighter and darker as the crop is, blended over the rim. False, and nothing
    done, where that speckle would hide it."""
    x, y = at
    rows, columns = crop.shape
    ground = canvas[y : y + rows, x : x + columns]
    speckle = float(ground.std() / max(ground.mean(), 1.0))
    if np.abs(ndimage.uniform_filter(crop - 1, (4, 5))).max() < LEAST_CONTRAST * speckle:
        return False
    inside = np.zeros(crop.shape, np.float32)
    x1, y1, x2, y2 = np.round(box).astype(int)
    inside[y1:y2, x1:x2] = 1
    weight = np.clip(ndimage.gaussian_filter(inside, 3) * 1.6, 0, 1)
    smooth = ndimage.gaussian_filter(crop.astype(np.float32), 0.9)
    # What is brighter than the bottom brings speckle of its own; a shadow has that of the ground.
    factor = np.where(smooth > 1.3, 0.5 * smooth + 0.5 * crop, smooth)
    canvas[y : y + rows, x : x + columns] = ground * (1 + weight * (factor - 1))
    return True


def with_objects(ground: np.ndarray, stock: list, occupied: np.ndarray, rng) -> tuple[np.ndarray, list]:
    """Ground with some objects pasted where bottom is seen and nothing else is."""
    canvas, rows, taken = ground.astype(np.float32), [], [tuple(box) for box in occupied]
    for _ in range(rng.integers(1, 5)):
        kind, crop, box = stock[rng.integers(len(stock))]
        if rng.random() < 0.5:
            crop, box = crop[::-1], np.array([box[0], len(crop) - box[3], box[2], len(crop) - box[1]])
        room = SIDE - np.array(crop.shape[::-1])
        if room.min() < 4:
            continue
        for _ in range(12):
            x, y = (int(rng.integers(0, size)) for size in room)
            place = (x, y, x + crop.shape[1], y + crop.shape[0])
            under = ground[place[1] : place[3], place[0] : place[2]]
            clear = all(a[0] > place[2] or a[2] < place[0] or a[1] > place[3] or a[3] < place[1] for a in taken)
            if clear and (ndimage.uniform_filter(under.astype(np.float32), 15) > 12).all():
                if paste(canvas, crop, box, (x, y)):
                    rows.append((kind, *(box + np.array([x, y, x, y]))))
                    taken.append(place)
                break
    return np.clip(canvas, 0, 255).astype(np.uint8), rows


class Folder:
    """A folder of chips as `data.py` reads it, in one split."""

    def __init__(self, out: Path, split: str, names: list[str]):
        self.out, self.split, self.names, self.images, self.boxes = out, split, names, [], []
        for part in ("images", "labels"):
            (out / part / split).mkdir(parents=True, exist_ok=True)

    def add(self, chip: np.ndarray, rows: list, hidden, source: str) -> None:
        """One chip, its boxes, and where contacts may lie."""
        index, lines = len(self.images), []
        self.images.append({"id": index, "file_name": f"{index:06}.png", "width": SIDE, "height": SIDE, "source": source})
        Image.fromarray(real.levelled(chip)).save(self.out / f"images/{self.split}/{index:06}.png")
        for kind, x1, y1, x2, y2 in [*rows, *((-1, *box) for box in hidden)]:
            box = {"id": len(self.boxes), "image_id": index, "category_id": max(int(kind), 0) + 1, "iscrowd": int(kind < 0)}
            self.boxes.append(box | {"bbox": [float(v) for v in (x1, y1, x2 - x1, y2 - y1)], "area": float((x2 - x1) * (y2 - y1))})
            if kind >= 0:
                place = ((x1 + x2) / 2, (y1 + y2) / 2, x2 - x1, y2 - y1)
                lines.append(f"{int(kind)} " + " ".join(f"{value / SIDE:.6f}" for value in place))
        # data.py takes a box without an outline as it is.
        (self.out / f"labels/{self.split}/{index:06}.txt").write_text("".join(line + "\n" for line in lines))

    def close(self, manifest: dict) -> None:
        """The files beside the pictures."""
        categories = [{"id": number, "name": name} for number, name in enumerate(self.names, 1)]
        data = {"images": self.images, "annotations": self.boxes, "categories": categories}
        (self.out / f"{self.split}.json").write_text(json.dumps(data))
        (self.out / "classes.txt").write_text("".join(name + "\n" for name in self.names))
        (self.out / "manifest.json").write_text(json.dumps(manifest | {"pixel_m": CHIP_PIXEL_M}) + "\n")


def bare(paths: list[Path], folder: Folder) -> None:
    """Three chips of each side, alternately near and far."""
    for path in paths:
        for number, (side, pixels) in enumerate(sides(path).items()):
            for row in range(3):
                x = (pixels.shape[1] - SIDE) * ((row + number) % 2)
                y = row * (pixels.shape[0] - SIDE) // 2
                folder.add(pixels[y : y + SIDE, x : x + SIDE], [], [], f"{path.stem}/{side} {x} {y}")


def cut(places: dict, scale: float, x: int, y: int) -> tuple[np.ndarray, np.ndarray]:
    """What is known to lie in a cut-out: objects that are whole in it, and places without a loss, cut objects among them."""
    hidden = np.array(places.get("hidden", []), np.float32).reshape(-1, 4) * scale
    objects = np.array(places.get("objects", []), np.float32).reshape(-1, 5)
    moved = np.concatenate([np.concatenate([np.full((len(hidden), 1), -1), hidden], 1), objects * [1, *[scale] * 4]])
    moved[:, 1:] -= np.array([x, y, x, y])
    within = moved.copy()
    within[:, 1:] = moved[:, 1:].clip(0, SIDE)
    within[(within != moved).any(1), 0] = -1
    within = within[(within[:, 3] > within[:, 1]) & (within[:, 4] > within[:, 2])]
    return within[within[:, 0] >= 0], within[within[:, 0] < 0, 1:]


def contact_crops(paths: list[Path], contacts: dict, rng) -> list:
    """The contacts of the waterfalls themselves, at their own scale."""
    pictures, rows = [], []
    for path in paths:
        for side, pixels in sides(path).items():
            objects = np.array(contacts.get(f"{path.stem}/{side}", {}).get("objects", []), np.float32).reshape(-1, 5)
            for row in objects:
                # Room for the largest of them, and for the bottom beside it.
                middle = (row[1:3] + row[3:5]) / 2
                x, y = (int(v) for v in np.clip(middle - SIDE / 2, 0, np.array(pixels.shape[::-1]) - SIDE))
                pictures.append(pixels[y : y + SIDE, x : x + SIDE])
                rows.append((row - np.array([0, x, y, x, y], np.float32))[None])
    return crops(pictures, rows, 10_000, rng)


def varied(paths: list[Path], stock: list, contacts: dict, count: int, folder: Folder, rng) -> None:
    """Training chips, at several scales of the ground."""
    each = -(-count // len(paths))
    for path in paths:
        halves = sides(path, rng.choice([0.05, 0.06, 0.07]))
        for number in range(each):
            side = str(rng.choice(list(halves)))
            pixels = halves[side]
            x, y = rng.integers(0, pixels.shape[1] - SIDE + 1), rng.integers(0, pixels.shape[0] - SIDE + 1)
            ground = pixels[y : y + SIDE, x : x + SIDE]
            scale = pixels.shape[0] / (1024 * PIXEL_M / CHIP_PIXEL_M)
            own, places = cut(contacts.get(f"{path.stem}/{side}", {}), scale, x, y)
            occupied = np.concatenate([own[:, 1:], places])
            chip, rows = with_objects(ground, stock, occupied, rng) if number % 2 else (ground, [])
            folder.add(chip, [*rows, *own.tolist()], places, f"{path.stem}/{side} {x} {y}")


def tile_crops(tiles: "real.Tiles", kind: int, rng) -> list:
    """The effigies of the sessions of `train`, at several scales."""
    found = []
    for scale in tiles.pixel_m / CHIP_PIXEL_M * np.geomspace(0.8, 1.25, 4):
        chosen_tiles = np.flatnonzero(tiles.split == "train")
        pictures = [real.resized(tiles, tile, scale) for tile in chosen_tiles]
        boxes = [tiles.boxes(tile, True) * scale for tile in chosen_tiles]
        rows = [np.concatenate([np.full((len(b), 1), kind), b], 1) for b in boxes]
        found += crops(pictures, rows, 10_000, rng)
    return found


def main() -> None:
    """Reads the arguments, writes the folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("waterfalls", "chips", "real", "out"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--half", choices=["train", "test"], required=True)
    parser.add_argument("--count", type=int, default=2400)
    parser.add_argument("--contacts", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    names, rng = read_names(args.chips), np.random.default_rng(args.seed)
    folder, paths = Folder(args.out, args.half, names), chosen(args.waterfalls, args.half)
    if args.half == "test":
        bare(paths, folder)
    else:
        chips = read_split(args.chips, "train", 4000)
        simulated = crops(chips.images.numpy(), list(chips.boxes.numpy()), 1500, rng)
        effigies = tile_crops(real.read_tiles(args.real), names.index(real.CLASS), rng)
        contacts = json.loads(args.contacts.read_text()) if args.contacts else {}
        seen = contact_crops(paths, contacts, rng)
        print(f"{len(simulated)} simulated crops, {len(effigies)} of effigies, {len(seen)} of the ground's own contacts")
        # One real effigy and two real contacts for every six simulated objects.
        stock = list(simulated)
        for real_ones, parts in ((effigies, 6), (seen, 3)):
            stock += [real_ones[i] for i in rng.integers(0, len(real_ones), len(simulated) // parts)] if real_ones else []
        varied(paths, stock, contacts, args.count, folder, rng)
    folder.close({"program": "ground.py", "half": args.half, "seed": args.seed, "pictures": len(paths)})
    print(f"{len(folder.images)} chips, {sum(not box['iscrowd'] for box in folder.boxes)} boxes")


if __name__ == "__main__":
    main()
