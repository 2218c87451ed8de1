"""Recall by contrast and size at one false box a hectare, on scenes of another law and on real tiles by recording.

    python recall.py MODEL OUT --foreign DIR [--real real.npz] [--ground DIR] [--test DIR] [--per-hectare 1]

MODEL is an export (`.onnx`, its sidecar beside it) or a `weights.npz`; it looks twice at each chip, as the program does. DIR of
`--foreign` is what `foreign.py` wrote, of `--ground` what `ground.py --half test` wrote (bare, unlabelled), of `--test` any folder
of chips with a split `test`.

A box is any object's: classes do not count here. A box is false when it reaches no truth at an IoU of 0.3 that is free, and does
not lie mostly on an object that may be found or not. The confidence is the lowest with at most `--per-hectare` false boxes a
hectare over all foreign chips, with and without objects, or over those without weed (`open`); recall is counted there at both IoUs. Class names are counted at that
confidence too: of the boxes on an object whose kind has a class, how many name it.
"""

import argparse
import json
from pathlib import Path

import numpy as np

import metrics
import real
from data import Chips, read_names, read_split
from detect import Exported, judged, look_twice, suppress, truths
from foreign import CLASS
from network import build
from weights import load_weights

SIZE_EDGES_M = (0.25, 0.6, 1.0, 2.0, 10.0)
CONTRAST_EDGES = (1.0, 2.0, 3.0, 5.0, 100.0)
FALSE_IOU, STRICT_IOU = 0.3, 0.5
GOAL_SIZE_M, GOAL_CONTRAST = 0.6, 3.0
CHIP_HECTARE = 1e-4


def one_class(found: list) -> list:
    """Boxes of any class as boxes of the first."""
    return [np.concatenate([rows[:, :5], np.zeros((len(rows), 1), rows.dtype)], 1) for rows in found]


def look(network, meta: dict, chips: Chips) -> tuple[list, list]:
    """What is found in each chip with its class, and the same without."""
    found = [suppress(rows, agnostic=True) for rows in look_twice(network, meta["anchors"], chips)]
    plain = Chips(chips.images, chips.boxes.clone(), chips.names)
    plain.boxes[..., 0] = plain.boxes[..., 0].clamp(max=0)
    return found, judged(one_class(found), plain)


def blind(chips: Chips) -> list:
    """Truths without their class."""
    return [np.concatenate([rows[:, :4], np.zeros((len(rows), 1))], 1) for rows in truths(chips)]


def ranked(found: list, truth: list, limit: float) -> tuple[np.ndarray, np.ndarray]:
    """Score of every box and whether it reaches a truth, over all chips."""
    right = [metrics.match(f, t, limit)[0] >= 0 for f, t in zip(found, truth)]
    return np.concatenate([f[:, 4] for f in found]), np.concatenate(right)


def score_at(found: list, truth: list, hectares: float, per_hectare: float) -> float:
    """The lowest confidence with no more false boxes than that."""
    scores, right = ranked(found, truth, FALSE_IOU)
    false = np.sort(scores[~right])[::-1]
    allowed = int(per_hectare * hectares)
    return float(false[allowed]) + 1e-6 if len(false) > allowed else 0.01


def hits(found: list, truth: list, score: float, limit: float) -> np.ndarray:
    """Whether each truth is found at a confidence."""
    taken = [(metrics.match(f[f[:, 4] >= score], t, limit)[0], len(t)) for f, t in zip(found, truth)]
    return np.concatenate([np.isin(np.arange(count), each) for each, count in taken])


def described(folder: Path) -> list[dict]:
    """What `foreign.py` says of each object that is asked for, in the order of the chips' boxes."""
    data = json.loads((folder / "test.json").read_text())
    asked = [box for box in data["annotations"] if not box["iscrowd"]]
    return sorted(asked, key=lambda box: (box["image_id"], box["id"]))


def table(objects: list[dict], loose: np.ndarray, strict: np.ndarray) -> list[dict]:
    """Found and asked for, by contrast and size."""
    size, contrast = np.array([o["size_m"] for o in objects]), np.array([o["contrast"] for o in objects])
    rows = []
    for low, high in zip(CONTRAST_EDGES[:-1], CONTRAST_EDGES[1:]):
        for small, large in zip(SIZE_EDGES_M[:-1], SIZE_EDGES_M[1:]):
            here = (contrast >= low) & (contrast < high) & (size >= small) & (size < large)
            row = {"contrast": [low, high], "size_m": [small, large], "objects": int(here.sum())}
            rows.append(row | {"iou30": int(loose[here].sum()), "iou50": int(strict[here].sum())})
    return rows


def named(found: list, chips: Chips, objects: list[dict], names: list[str], score: float) -> dict:
    """How many boxes on objects of each kind name it rightly, by the kind."""
    counts, at = {}, 0
    for f, t in zip(found, truths(chips)):
        own, at = objects[at : at + len(t)], at + len(t)
        f = f[f[:, 4] >= score]
        plain = np.concatenate([f[:, :5], np.zeros((len(f), 1))], 1)
        taken, _ = metrics.match(plain, np.concatenate([t[:, :4], np.zeros((len(t), 1))], 1), FALSE_IOU)
        for row, of in zip(f, taken):
            if of >= 0:
                kind, said = own[of]["kind"], names[int(row[5])] if row[5] < len(names) else "object"
                counts.setdefault(kind, {}).setdefault(said, 0)
                counts[kind][said] += 1
    sure = [(CLASS[kind] == said, n) for kind, row in counts.items() if CLASS[kind] for said, n in row.items() if said != "object"]
    return {"by_kind": counts, "right": sum(n for ok, n in sure if ok), "of": sum(n for _, n in sure)}


def reliability(scores: np.ndarray, right: np.ndarray, edges=np.arange(0.1, 1.01, 0.1)) -> list[dict]:
    """Boxes by confidence, and how many of them are right."""
    rows = []
    for low, high in zip(edges[:-1], edges[1:]):
        here = (scores >= low) & (scores < high)
        rows.append({"score": [round(float(low), 1), round(float(high), 1)], "boxes": int(here.sum()), "right": int(right[here].sum())})
    return rows


def holdings(folder: Path) -> dict[str, list[str]]:
    """What else lies in each chip, by its name."""
    return {Path(image["file_name"]).stem: image["holds"] for image in json.loads((folder / "test.json").read_text())["images"]}


def counted(found: list, truth: list, objects: list[dict], hectares: float, per_hectare: float) -> dict:
    """Recall at that many false boxes a hectare of some chips, by contrast, size and kind."""
    score = score_at(found, truth, hectares, per_hectare)
    goal = np.array([o["size_m"] >= GOAL_SIZE_M and o["contrast"] >= GOAL_CONTRAST for o in objects])

    def at(confidence: float) -> dict:
        loose, strict = (hits(found, truth, confidence, limit) for limit in (FALSE_IOU, STRICT_IOU))
        row = {"score": confidence, "iou30": int(loose.sum()), "iou50": int(strict.sum())}
        return row | {"goal30": int(loose[goal].sum()), "goal50": int(strict[goal].sum())}

    loose, strict = (hits(found, truth, score, limit) for limit in (FALSE_IOU, STRICT_IOU))
    kinds = {kind: np.array([o["kind"] == kind for o in objects]) for kind in CLASS}
    report = {"chips": len(found), "hectares": hectares, "objects": len(objects), "goal": int(goal.sum())} | at(score)
    return report | {
        "by_contrast_and_size": table(objects, loose, strict),
        "by_kind": {kind: [int(loose[own].sum()), int(strict[own].sum()), int(own.sum())] for kind, own in kinds.items()},
        "ap30": metrics.class_precision(found, truth, 0, FALSE_IOU)["all_points"],
        "ap50": metrics.class_precision(found, truth, 0, STRICT_IOU)["all_points"],
        "rates": {rate: at(score_at(found, truth, hectares, rate)) for rate in (0.5, 1.0, 2.0, 4.0, 8.0)},
        "reliability": reliability(*ranked(found, truth, FALSE_IOU)),
    }


def foreign(network, meta: dict, folder: Path, per_hectare: float) -> dict:
    """The whole report of the other simulator's scenes: over all ground, and over that without weed, which is most of what is
    taken for objects."""
    chips, objects, holds = read_split(folder, "test"), described(folder), holdings(folder)
    with_class, found = look(network, meta, chips)
    truth, area = blind(chips), (chips.side * meta["pixel_m"]) ** 2 * CHIP_HECTARE
    starts = np.cumsum([0, *map(len, truth)])
    report = {}
    for name, wanted in (("all", None), ("open", "weed")):
        own = [i for i, stem in enumerate(chips.names) if wanted not in holds[stem]]
        there = [one for i in own for one in objects[starts[i] : starts[i + 1]]]
        report[name] = counted([found[i] for i in own], [truth[i] for i in own], there, len(own) * area, per_hectare)
    shown, (scores, right) = meta["thresholds"]["score"], ranked(found, truth, FALSE_IOU)
    false = int((~right & (scores >= shown)).sum())
    report["own"] = {"score": shown, "found": int(hits(found, truth, shown, FALSE_IOU).sum()), "false": false}
    names = {score: named(with_class, chips, objects, meta["names"], score) for score in (report["open"]["score"], shown)}
    return report | {"names": names}


def recordings(network, meta: dict, path: Path, scores: list[float]) -> dict:
    """Real effigies by recording (the sessions of `real_tiles.py` that training left out): found of those there, any class."""
    tiles, report = real.read_tiles(path), {}
    for split in ("val", "test"):
        chips = real.single_chips(tiles, split, True, meta)
        _, found = look(network, meta, chips)
        truth, session = blind(chips), np.array([tiles.session[list(tiles.names).index(name)] for name in chips.names])
        for number in sorted(set(session.tolist())):
            own = np.flatnonzero(session == number)
            f, t = [found[i] for i in own], [truth[i] for i in own]
            row = {"split": split, "tiles": len(own), "effigies": sum(map(len, t)), "ap30": metrics.class_precision(f, t, 0, 0.3)["all_points"]}
            for score in scores:
                false = metrics.counts(f, t, score, FALSE_IOU)
                row[f"{score:.3f}"] = {"iou30": false["tp"], "false": false["fp"], "iou50": metrics.counts(f, t, score)["tp"]}
            report[f"session {number}"] = row
    return report


def bare(network, meta: dict, folder: Path, scores: list[float]) -> dict:
    """Boxes a hectare of unlabelled ground."""
    chips = read_split(folder, "test")
    hectares = len(chips) * (chips.side * meta["pixel_m"]) ** 2 * CHIP_HECTARE
    _, found = look(network, meta, chips)
    scored = np.concatenate([rows[:, 4] for rows in found])
    return {"chips": len(chips), "hectares": hectares} | {f"{score:.3f}": int((scored >= score).sum()) for score in scores}


def labelled(network, meta: dict, folder: Path, scores: list[float]) -> dict:
    """Any class on chips of known truth: found, false, and how far confidences can be believed."""
    chips = read_split(folder, "test")
    with_class, found = look(network, meta, chips)
    truth = blind(chips)
    report = {"objects": sum(map(len, truth)), "ap30": metrics.class_precision(found, truth, 0, 0.3)["all_points"]}
    report |= {f"{score:.3f}": metrics.counts(found, truth, score, FALSE_IOU) for score in scores}
    return report | {"ap50": metrics.class_precision(found, truth, 0, 0.5)["all_points"], "reliability": reliability(*ranked(found, truth, FALSE_IOU))}


def load(path: Path) -> tuple:
    """Network and meta data of weights or of an export."""
    if path.suffix == ".npz":
        network, meta = load_weights(path, build)
        return network, {"thresholds": {"score": 0.5}} | meta
    sidecar = json.loads(path.with_suffix(".json").read_text())
    meta = {"names": sidecar["names"], "pixel_m": sidecar["pixel_m"], "side": sidecar["input"]["width"], "anchors": None}
    return Exported(path), meta | {"thresholds": sidecar["thresholds"]}


def markdown(report: dict, ground: str) -> str:
    """The tables as they stand in the model card, over all ground or the open one."""
    def share(found: int, of: int) -> str:
        return f"{found}/{of} ({found / of:.2f})" if of else "none"

    far, lines = report["foreign"][ground], []
    lines.append(f"{ground} ground, confidence {far['score']:.3f}, {far['hectares']:.1f} ha")
    lines.append(f"found {share(far['iou30'], far['objects'])} at IoU 0.3, {share(far['iou50'], far['objects'])} at 0.5")
    lines.append(f"from 0.6 m and contrast 3: {share(far['goal30'], far['goal'])}, {share(far['goal50'], far['goal'])}")
    lines.append(f"AP30 {far['ap30']:.3f}, AP50 {far['ap50']:.3f}")
    for limit in ("iou30", "iou50"):
        sizes = [f"{low:g} to {high:g} m" for low, high in zip(SIZE_EDGES_M[:-1], SIZE_EDGES_M[1:])]
        lines += ["", f"| {limit}: contrast | " + " | ".join(sizes) + " | all |", "|---" * (len(sizes) + 2) + "|"]
        for low, high in zip(CONTRAST_EDGES[:-1], CONTRAST_EDGES[1:]):
            rows = [row for row in far["by_contrast_and_size"] if row["contrast"] == [low, high]]
            rows.append({limit: sum(r[limit] for r in rows), "objects": sum(r["objects"] for r in rows)})
            lines.append(f"| {low:g} to {high:g} | " + " | ".join(share(r[limit], r["objects"]) for r in rows) + " |")
    return "\n".join(lines)


def main() -> None:
    """Reads the arguments, measures, writes `recall.json` and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--foreign", type=Path, required=True)
    for name in ("real", "ground", "test"):
        parser.add_argument(f"--{name}", type=Path)
    parser.add_argument("--per-hectare", type=float, default=1.0)
    args = parser.parse_args()
    network, meta = load(args.model)
    args.out.mkdir(parents=True, exist_ok=True)
    report = {}
    report["foreign"] = foreign(network, meta, args.foreign, args.per_hectare)
    scores = [round(report["foreign"][ground]["score"], 3) for ground in ("all", "open")] + [meta["thresholds"]["score"]]
    if args.real:
        report["real"] = recordings(network, meta, args.real, scores)
    if args.ground:
        report["ground"] = bare(network, meta, args.ground, scores)
    if args.test:
        report["test"] = labelled(network, meta, args.test, scores)
    (args.out / "recall.json").write_text(json.dumps(report, indent=1) + "\n")
    for ground in ("all", "open"):
        print(markdown(report, ground), end="\n\n")


if __name__ == "__main__":
    main()
