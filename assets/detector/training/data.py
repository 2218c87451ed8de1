"""Chips and their boxes in memory, read from the folder that `bathyscope simulate --dataset DIR` writes, or `bathyscope review`
as its `dataset`: then all chips of a log are in one split, and the others are empty.

DIR/images/{train,val,test}/NNNNNN.png   8-bit grey; rows run along track, columns outward in slant range
DIR/labels/{train,val,test}/NNNNNN.txt   `class cx cy w h` per line, fractions of the chip; a box holds echo and shadow
DIR/{train,val,test}.json                COCO; its boxes with `iscrowd` 1 may be found or not: cut off, or hardly to be seen;
                                         the others are those of the labels, in their order, some with an outline
DIR/classes.txt                          one class name per line
DIR/manifest.json                        how the data was made (`pixel_m` among it)
"""

import json
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from PIL import Image

# In the class column of `Chips.boxes`: an object of unknown or too little content (no loss, no truth), and an empty slot.
IGNORE, ABSENT = -1, -2
DEFAULT_PIXEL_M = 0.04
# Bands of rows in which the near and the far edge of an object's outline are kept.
BANDS = 16


@dataclass
class Chips:
    """`images [n, side, side]` as u8 and `boxes [n, slots, 5]`: class (or IGNORE, ABSENT), x1, y1, x2, y2 in pixels.

    `edges [n, slots, BANDS, 2]` are the nearest and farthest column of each box's outline in equal bands of its rows (x1, x2
    where only the box is known): what is left of an object that is cut.
    """

    images: torch.Tensor
    boxes: torch.Tensor
    names: list[str]
    edges: torch.Tensor | None = None

    def __post_init__(self):
        if self.edges is None:
            self.edges = self.boxes[..., [1, 3]].unsqueeze(2).repeat(1, 1, BANDS, 1)

    def __len__(self) -> int:
        return len(self.images)

    @property
    def side(self) -> int:
        """Rows and columns of a chip."""
        return self.images.shape[-1]

    def to(self, device) -> "Chips":
        """The same chips in the memory of `device`."""
        return Chips(self.images.to(device), self.boxes.to(device), self.names, self.edges.to(device))

    def first(self, count: int) -> "Chips":
        """At most `count` chips, spread evenly."""
        if count >= len(self):
            return self
        pick = torch.linspace(0, len(self) - 1, count).long()
        return Chips(self.images[pick], self.boxes[pick], [self.names[i] for i in pick.tolist()], self.edges[pick])


def read_label(path: Path, side: int) -> np.ndarray:
    """The boxes of one YOLO file, `[n, 5]`: class, x1, y1, x2, y2 in pixels. A missing file means an empty chip."""
    if not path.exists():
        return np.zeros((0, 5), np.float32)
    rows = [line.split() for line in path.read_text().splitlines() if line.strip()]
    rows = np.array(rows, dtype=np.float32).reshape(-1, 5)
    centre, half = rows[:, 1:3] * side, rows[:, 3:5] * side / 2
    return np.concatenate([rows[:, :1], centre - half, centre + half], 1)


def read_ignored(path: Path) -> dict[str, np.ndarray]:
    """The boxes of a COCO file that may be found or not, as rows of IGNORE, x1, y1, x2, y2 by the picture's stem."""
    if not path.exists():
        return {}
    coco = json.loads(path.read_text())
    stems, rows = {image["id"]: Path(image["file_name"]).stem for image in coco["images"]}, {}
    for box in coco["annotations"]:
        if box.get("iscrowd"):
            x, y, width, height = box["bbox"]
            rows.setdefault(stems[box["image_id"]], []).append((IGNORE, x, y, x + width, y + height))
    return {stem: np.array(boxes, np.float32) for stem, boxes in rows.items()}


def read_outlines(path: Path) -> dict[str, list[np.ndarray]]:
    """The outlines `[n, 2]` of a COCO file's objects, by the picture's stem, in the order of its labels; empty where unknown."""
    if not path.exists():
        return {}
    coco = json.loads(path.read_text())
    stems, rows = {image["id"]: Path(image["file_name"]).stem for image in coco["images"]}, {}
    for one in coco["annotations"]:
        if not one.get("iscrowd"):
            outline = np.array(one.get("segmentation", [[]])[0], np.float32).reshape(-1, 2)
            rows.setdefault(stems[one["image_id"]], []).append(outline)
    return rows


def banded(box: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """Nearest and farthest column `[BANDS, 2]` of an outline in equal bands of the rows of its box `x1 y1 x2 y2`.

    The outline runs down the near side and up the far side, a pair of corners for each ping. A band without a ping has an
    edge that is inside out.
    """
    if not len(outline):
        return np.repeat(box[None, [0, 2]], BANDS, 0)
    half = len(outline) // 2
    near, far = outline[:half:2], outline[half:][::-1][:half:2]
    top, bottom = outline[:half:2, 1], outline[1:half:2, 1]
    step, edges = (box[3] - box[1]) / BANDS, np.empty((BANDS, 2), np.float32)
    for band in range(BANDS):
        rows = (bottom > box[1] + band * step) & (top < box[1] + (band + 1) * step)
        edges[band] = (near[rows, 0].min(), far[rows, 0].max()) if rows.any() else (box[2], box[0])
    return edges


def read_picture(path: Path) -> np.ndarray:
    """One grey picture, `[rows, columns]` u8."""
    with Image.open(path) as image:
        return np.asarray(image.convert("L"))


def pad_boxes(boxes: list[np.ndarray]) -> torch.Tensor:
    """Boxes of different counts as one array, filled up with ABSENT."""
    slots = max([1] + [len(b) for b in boxes])
    padded = np.zeros((len(boxes), slots, 5), np.float32)
    padded[:, :, 0] = ABSENT
    for row, b in zip(padded, boxes):
        row[: len(b)] = b
    return torch.from_numpy(padded)


def read_split(root: Path, split: str, limit: int | None = None, names: list[str] | None = None) -> Chips:
    """All chips of one split, decoded by every core; with `names` the classes are numbered by their place there."""
    paths = sorted((root / "images" / split).glob("*.png"))[:limit]
    if not paths:
        raise SystemExit(
            f"no chips to read: write them with `bathyscope simulate --dataset`, looked in {root / 'images' / split}"
        )
    ignored, nothing = read_ignored(root / f"{split}.json"), np.zeros((0, 5), np.float32)
    outlines = read_outlines(root / f"{split}.json")
    if unknown := [name for name in used_names(root) if names and name not in names]:
        raise SystemExit(f"classes that no data trains: {', '.join(unknown)}: {root / 'classes.txt'}")
    own = read_names(root) if names else []
    number = np.array([names.index(name) if name in names else -1 for name in own], np.float32)
    images = torch.empty(len(paths), *read_picture(paths[0]).shape, dtype=torch.uint8)

    def read(index: int) -> np.ndarray:
        images[index] = torch.from_numpy(read_picture(paths[index]).copy())
        stem = paths[index].stem
        label = read_label(root / "labels" / split / f"{stem}.txt", images.shape[-1])
        if names:
            label[:, 0] = number[label[:, 0].astype(int)]
        return np.concatenate([label, ignored.get(stem, nothing)])

    # Decoding a PNG releases Python's lock, so threads are enough, and no picture is copied between processes.
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        boxes = list(pool.map(read, range(len(paths))))
    chips = Chips(images, pad_boxes(boxes), [path.stem for path in paths])
    for row, path in enumerate(paths):
        for slot, outline in enumerate(outlines.get(path.stem, [])):
            chips.edges[row, slot] = torch.from_numpy(banded(boxes[row][slot, 1:], outline))
    return chips


def has_split(root: Path, split: str) -> bool:
    """Whether there is at least one chip in a split."""
    return any((root / "images" / split).glob("*.png"))


def holding(roots: list[Path], split: str) -> list[Path]:
    """The folders with chips in a split; the first where none has any, for its message."""
    return [root for root in roots if has_split(root, split)] or roots[:1]


def join(parts: list[Chips]) -> Chips:
    """The chips of several folders as one."""
    if len(parts) == 1:
        return parts[0]
    slots = max(part.boxes.shape[1] for part in parts)
    boxes = [torch.nn.functional.pad(part.boxes, (0, 0, 0, slots - part.boxes.shape[1]), value=ABSENT) for part in parts]
    edges = [torch.nn.functional.pad(part.edges, (0, 0, 0, 0, 0, slots - part.edges.shape[1])) for part in parts]
    names = [f"{index}/{name}" for index, part in enumerate(parts) for name in part.names]
    return Chips(torch.cat([part.images for part in parts]), torch.cat(boxes), names, torch.cat(edges))


def read_names(root: Path) -> list[str]:
    """The class names, in the order of the labels' numbers."""
    return (root / "classes.txt").read_text().splitlines()


def used_names(root: Path) -> list[str]:
    """The names of the classes that boxes have, in the order of their numbers."""
    lines = (line for path in root.glob("labels/*/*.txt") for line in path.read_text().splitlines())
    used = {int(line.split()[0]) for line in lines if line.strip()}
    return [name for number, name in enumerate(read_names(root)) if number in used]


def read_manifest(root: Path) -> dict:
    """How the data was made, without the seeds of its scenes; empty where nothing says."""
    path = root / "manifest.json"
    manifest = json.loads(path.read_text()) if path.exists() else {}
    for part in manifest.get("parts", []):
        part.pop("scene_seeds", None)
    return manifest
