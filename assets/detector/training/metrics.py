"""Average precision, counts at a confidence, and errors, each with its definition.

Matching follows COCO: detections in order of falling score, each takes the free truth of its class that it overlaps most.
"""

import numpy as np

from detect import box_iou

COCO_IOUS = np.arange(0.5, 0.96, 0.05)
# Longest side of a truth box in pixels; at 0.04 m per pixel these are 0.5, 1, 2 and 4 m.
SIZE_EDGES_PX = (0.0, 12.5, 25.0, 50.0, 100.0, float("inf"))


def match(found: np.ndarray, truth: np.ndarray, limit: float) -> tuple[np.ndarray, np.ndarray]:
    """For each detection of one chip (falling score) the truth it takes or -1, and the IoU with it."""
    taken, overlap = -np.ones(len(found), int), np.zeros(len(found))
    if not len(found) or not len(truth):
        return taken, overlap
    table = np.where(found[:, 5][:, None] == truth[:, 4][None], box_iou(found[:, :4], truth[:, :4]), 0.0)
    free = np.ones(len(truth), bool)
    for row in range(len(found)):
        best = int(np.where(free, table[row], -1.0).argmax())
        if free[best] and table[row, best] >= limit:
            taken[row], overlap[row], free[best] = best, table[row, best], False
    return taken, overlap


def average_precision(scores: np.ndarray, right: np.ndarray, truths: int) -> dict[str, float]:
    """Area under the precision envelope over all points, and COCO's mean over 101 recalls."""
    order = np.argsort(-scores, kind="stable")
    right = right[order].astype(float)
    recall = right.cumsum() / max(truths, 1)
    precision = right.cumsum() / np.arange(1, len(right) + 1)
    envelope = np.maximum.accumulate(precision[::-1])[::-1]
    all_points = float((np.diff(recall, prepend=0.0) * envelope).sum())
    at = np.searchsorted(recall, np.linspace(0, 1, 101), side="left")
    coco = float(np.append(envelope, 0.0)[np.minimum(at, len(envelope))].mean())
    return {"all_points": all_points, "coco101": coco}


def class_precision(found: list, truth: list, kind: int, limit: float) -> dict[str, float]:
    """Average precision of one class at one IoU."""
    scores, right, count = [], [], 0
    for f, t in zip(found, truth):
        f, t = f[f[:, 5] == kind], t[t[:, 4] == kind]
        taken, _ = match(f, t, limit)
        scores.append(f[:, 4])
        right.append(taken >= 0)
        count += len(t)
    return average_precision(np.concatenate(scores), np.concatenate(right), count)


def precision_table(found: list, truth: list, names: list[str], ious=COCO_IOUS) -> dict:
    """AP50 and AP50:95 per class that has truths, and their means."""
    table = {}
    for kind, name in enumerate(names):
        count = int(sum((t[:, 4] == kind).sum() for t in truth))
        if count:
            each = [class_precision(found, truth, kind, limit) for limit in ious]
            table[name] = {
                "truths": count,
                "ap50": each[0]["all_points"],
                "ap50_coco101": each[0]["coco101"],
                "ap50_95": float(np.mean([e["coco101"] for e in each])),
            }
    means = {
        key: float(np.mean([row[key] for row in table.values()])) if table else 0.0 for key in ("ap50", "ap50_coco101", "ap50_95")
    }
    return {"map50": means["ap50"], "map50_coco101": means["ap50_coco101"], "map50_95": means["ap50_95"], "classes": table}


def ratio(a: float, b: float) -> float:
    """a / b, and 0 where there is nothing to divide by."""
    return float(a / b) if b else 0.0


def counts(found: list, truth: list, score: float, limit: float = 0.5) -> dict:
    """True and false detections at one confidence, over all classes."""
    hits, misses, wrong, shared, on_empty = 0, 0, 0, 0.0, 0
    for f, t in zip(found, truth):
        f = f[f[:, 4] >= score]
        taken, overlap = match(f, t, limit)
        right = int((taken >= 0).sum())
        hits, misses, wrong, shared = hits + right, misses + len(t) - right, wrong + len(f) - right, shared + overlap.sum()
        on_empty += len(f) if not len(t) else 0
    precision, recall = ratio(hits, hits + wrong), ratio(hits, hits + misses)
    return {
        "score": round(float(score), 4), "tp": hits, "fp": wrong, "fn": misses, "fp_on_empty_chips": on_empty,
        "precision": precision, "recall": recall, "f1": ratio(2 * precision * recall, precision + recall),
        "mean_iou_of_matches": ratio(shared, hits), "darknet_average_iou": ratio(shared, hits + wrong),
    }  # fmt: skip


def sweep(found: list, truth: list) -> list[dict]:
    """The counts over confidences of 0.05 to 0.95."""
    return [counts(found, truth, score) for score in np.arange(0.05, 0.951, 0.05)]


def recall_by_size(found: list, truth: list, score: float, pixel_m: float) -> list[dict]:
    """Truths found at one confidence, by the longest side of their box."""
    rows = []
    sizes = [(t[:, 2:4] - t[:, 0:2]).max(1) if len(t) else np.zeros(0) for t in truth]
    hits = []
    for f, t in zip(found, truth):
        taken, _ = match(f[f[:, 4] >= score], t, 0.5)
        hits.append(np.isin(np.arange(len(t)), taken))
    sizes, hits = np.concatenate(sizes), np.concatenate(hits)
    for low, high in zip(SIZE_EDGES_PX[:-1], SIZE_EDGES_PX[1:]):
        chosen = (sizes >= low) & (sizes < high)
        row = {"longest_side_px": [low, high if np.isfinite(high) else None], "from_m": low * pixel_m}
        rows.append(row | {"truths": int(chosen.sum()), "found": int(hits[chosen].sum())})
    return rows


def confusion(found: list, truth: list, score: float, classes: int, limit: float = 0.5) -> list[list[int]]:
    """Rows are what was found (last: nothing), columns what was there (last: background), matched without regard to class."""
    table = np.zeros((classes + 1, classes + 1), int)
    for f, t in zip(found, truth):
        f = f[f[:, 4] >= score]
        blind_f, blind_t = f.copy(), t.copy()
        blind_f[:, 5], blind_t[:, 4] = 0, 0
        taken, _ = match(blind_f, blind_t, limit)
        for row, of in zip(f, taken):
            table[int(row[5]), int(t[of, 4]) if of >= 0 else classes] += 1
        for missed in set(range(len(t))) - set(taken.tolist()):
            table[classes, int(t[missed, 4])] += 1
    return table.tolist()


def errors(found: list, truth: list, chips: list[str], names: list[str], score: float) -> list[dict]:
    """Every false alarm (with the best IoU it has with any truth) and every miss at one confidence."""

    def error(chip: str, what: str, kind: float, box: np.ndarray) -> dict:
        return {"chip": chip, "error": what, "class": names[int(kind)], "box_px": [round(float(v), 1) for v in box]}

    rows = []
    for f, t, chip in zip(found, truth, chips):
        f = f[f[:, 4] >= score]
        taken, _ = match(f, t, 0.5)
        near = box_iou(f[:, :4], t[:, :4]).max(1) if len(f) and len(t) else np.zeros(len(f))
        for row, of, best in zip(f, taken, near):
            if of < 0:
                scored = {"score": round(float(row[4]), 3), "best_iou": round(float(best), 3)}
                rows.append(error(chip, "false alarm", row[5], row[:4]) | scored)
        missed = sorted(set(range(len(t))) - set(taken.tolist()))
        rows += [error(chip, "miss", t[index, 4], t[index, :4]) for index in missed]
    return rows
