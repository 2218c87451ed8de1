"""Makes metrics.json: boxes, and the figures that two public evaluators give for them.

    python -m venv venv && venv/bin/pip install numpy pycocotools==2.0.11 mean_average_precision==2024.1.5
    venv/bin/python make_metrics.py > metrics.json

Edges are multiples of 1/8 and scores of 1/1024, which single precision holds exactly.
"""

import contextlib
import io
import json
import random

import numpy as np
from mean_average_precision import MetricBuilder
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval


def truth(klass, x, y, w, h, ignored=0):
    return [klass, x, y, x + w, y + h, ignored]


def predicted(klass, score, x, y, w, h):
    return [klass, score, x, y, x + w, y + h]


def image(truths=(), predictions=()):
    return {"truth": list(truths), "predicted": list(predictions)}


def scattered(rng, images, classes, per_image, extra, sides, ties):
    """Truths, most of them found by one box or more that is off by a little, and boxes on nothing."""
    def eighth(value):
        return round(value * 8) / 8

    def score(low):
        step = 64 if ties else 1
        return rng.randint(int(low * 1024), 1023) // step * step / 1024

    made = []
    for _ in range(images):
        truths, boxes = [], []
        for _ in range(rng.randint(0, per_image)):
            klass = rng.randrange(classes)
            w, h = (eighth(rng.uniform(*sides)) for _ in range(2))
            x, y = (eighth(rng.uniform(0, 400)) for _ in range(2))
            truths.append(truth(klass, x, y, w, h))
            for _ in range(rng.choice([0, 1, 1, 1, 2, 3])):
                off = rng.choice([0.02, 0.08, 0.2])
                jitter = lambda size: eighth(rng.gauss(0, off * size))
                named = klass if rng.random() < 0.85 else rng.randrange(classes)
                boxes.append(predicted(named, score(0.2), x + jitter(w), y + jitter(h),
                                       max(1, w + jitter(w)), max(1, h + jitter(h))))
        for _ in range(rng.randint(0, extra)):
            w, h = (eighth(rng.uniform(*sides)) for _ in range(2))
            boxes.append(predicted(rng.randrange(classes), score(0.0),
                                   eighth(rng.uniform(0, 400)), eighth(rng.uniform(0, 400)), w, h))
        rng.shuffle(boxes)
        made.append(image(truths, boxes))
    return made


def distinct_scores(images, rng):
    """Gives every prediction its own score: the all-point evaluator sorts ties as it pleases."""
    boxes = [box for one in images for box in one["predicted"]]
    assert len(boxes) <= 1023
    for box, score in zip(boxes, rng.sample(range(1, 1024), len(boxes))):
        # Sure where the box was sure before, mostly.
        box[1] = (score + int(box[1] * 1024)) // 2 / 1024
    seen = set()
    for box in boxes:
        while box[1] in seen:
            box[1] = (int(box[1] * 1024) + 1) % 1024 / 1024
        seen.add(box[1])
    return images


def cases():
    rng = random.Random(20)
    square = lambda at, score=0.5, klass=0: predicted(klass, score, at, 10, 32, 32)
    both, coco = ["coco", "voc"], ["coco"]
    yield "no detections", 2, both, [image([truth(0, 10, 10, 40, 30), truth(1, 90, 90, 50, 50)])]
    yield "no truths", 2, both, [image([], [square(10, 0.875), square(60, 0.5, 1)])]
    yield "no boxes at all", 1, both, [image()]
    yield "empty picture between others", 1, both, [
        image([truth(0, 10, 10, 32, 32)], [square(10, 0.5)]), image(), image([], [square(10, 0.75)])]
    yield "duplicates", 1, both, [image([truth(0, 10, 10, 32, 32), truth(0, 200, 10, 32, 32)],
                                        [square(10, 0.875), square(11, 0.75), square(12, 0.625), square(200, 0.25)])]
    yield "two truths in one place", 1, both, [image([truth(0, 10, 10, 32, 32), truth(0, 10, 10, 32, 32)],
                                                     [square(10, 0.875), square(10, 0.75)])]
    yield "next best truth is free", 1, both, [image([truth(0, 10, 10, 32, 32), truth(0, 16, 10, 32, 32)],
                                                     [square(10, 0.875), square(12, 0.75)])]
    # 32 x 32 against 16 x 32 inside it: 512 / 1024.
    yield "IoU exactly 0.5", 1, both, [image([truth(0, 10, 10, 32, 32)], [predicted(0, 0.5, 10, 10, 16, 32)])]
    # 3/5, 3/4, 7/10, 17/20 and 1 of the truth.
    yield "IoU on the other thresholds", 1, both, [
        image([truth(0, 0, 0, 40, 40)], [predicted(0, score, 0, 0, width, 40)])
        for score, width in [(0.875, 24), (0.75, 30), (0.625, 28), (0.5, 34), (0.375, 40), (0.25, 20)]]
    yield "class without truths", 3, both, [image([truth(0, 10, 10, 32, 32), truth(2, 100, 10, 32, 32)],
                                                  [square(10, 0.5), square(60, 0.75, 1), square(101, 0.25, 2)])]
    yield "right place, other class", 2, both, [image([truth(0, 10, 10, 32, 32)], [square(10, 0.5, 1)])]
    yield "ties of score", 2, coco, scattered(rng, 12, 2, 6, 5, (10, 90), True)
    yield "all scores alike", 1, coco, [
        image([truth(0, 10, 10, 32, 32)], [square(60), square(10)]),
        image([truth(0, 10, 10, 32, 32)], [square(10), square(60)])]
    yield "sizes on and across the limits", 1, both, [
        image([truth(0, 0, 0, 32, 32), truth(0, 100, 0, 31, 32), truth(0, 200, 0, 96, 96), truth(0, 300, 200, 97, 96),
               truth(0, 0, 200, 12, 14)],
              [predicted(0, 0.9375, 0, 0, 32, 33), predicted(0, 0.875, 100, 0, 33, 32),
               predicted(0, 0.75, 200, 0, 96, 100), predicted(0, 0.625, 300, 200, 90, 96),
               predicted(0, 0.5, 0, 200, 12, 14), predicted(0, 0.375, 150, 150, 20, 20),
               predicted(0, 0.25, 10, 300, 60, 60), predicted(0, 0.125, 120, 280, 120, 120)])]
    yield "more than 100 boxes in a picture", 1, coco, [
        image([truth(0, 40 * index, 300, 32, 32) for index in range(8)],
              [predicted(0, (900 - 7 * index) / 1024, 3 * index, 0, 20, 20) for index in range(97)]
              + [predicted(0, (120 - index) / 1024, 40 * index, 300, 32, 32) for index in range(8)])]
    yield "crowds", 2, coco, [
        image([truth(0, 10, 10, 32, 32), truth(0, 100, 100, 200, 200, 1), truth(1, 10, 200, 40, 40, 1)],
              [square(10, 0.875), predicted(0, 0.75, 110, 110, 30, 30), predicted(0, 0.625, 150, 150, 30, 30),
               predicted(0, 0.5, 90, 120, 30, 30), predicted(1, 0.5, 10, 200, 40, 40), square(60, 0.25)]),
        image([truth(0, 10, 10, 32, 32), truth(0, 10, 10, 34, 34, 1)], [square(10, 0.375), square(11, 0.25)])]
    yield "ignored first, counted second", 1, coco, [
        image([truth(0, 10, 10, 32, 32, 1), truth(0, 14, 10, 32, 32)], [square(10, 0.875)])]
    # A hundred truths, of which the recall goes through every hundredth.
    yield "recall on every hundredth", 1, both, [
        image([truth(0, 40 * index, 0, 32, 32) for index in range(10)],
              [predicted(0, (1000 - 10 * (10 * row + index) - (3 if index % 3 else 0)) / 1024,
                         40 * index if (index + row) % 4 else 40 * index + 25, 0, 32, 32) for index in range(10)])
        for row in range(10)]
    yield "scattered small", 3, both, distinct_scores(scattered(rng, 20, 3, 6, 5, (6, 40), False), rng)
    yield "scattered of all sizes", 4, both, distinct_scores(scattered(rng, 30, 4, 6, 6, (8, 180), False), rng)
    yield "scattered, one class, many false", 1, both, distinct_scores(scattered(rng, 25, 1, 3, 14, (10, 60), False), rng)


def number(value):
    return None if value < 0 or np.isnan(value) else float(value)


def by_coco(images, classes):
    annotations, results = [], []
    for index, one in enumerate(images):
        for klass, x0, y0, x1, y1, ignored in one["truth"]:
            annotations.append({"id": len(annotations) + 1, "image_id": index, "category_id": klass, "iscrowd": ignored,
                                "bbox": [x0, y0, x1 - x0, y1 - y0], "area": (x1 - x0) * (y1 - y0)})
        for klass, score, x0, y0, x1, y1 in one["predicted"]:
            results.append({"image_id": index, "category_id": klass, "score": score, "bbox": [x0, y0, x1 - x0, y1 - y0]})
    with contextlib.redirect_stdout(io.StringIO()):
        known = COCO()
        known.dataset = {"images": [{"id": index} for index in range(len(images))], "annotations": annotations,
                         "categories": [{"id": klass} for klass in range(classes)]}
        known.createIndex()
        found = known.loadRes(results) if results else COCO()
        if not results:
            found.dataset = {"images": known.dataset["images"], "annotations": [], "categories": known.dataset["categories"]}
            found.createIndex()
        evaluator = COCOeval(known, found, "bbox")
        evaluator.evaluate()
        evaluator.accumulate()
    # Threshold, recall, class, size, most detections.
    precision = evaluator.eval["precision"][..., -1]
    mean = lambda part: number(np.mean(part[part > -1])) if (part > -1).any() else None
    iou_sum, hits = 0.0, 0
    for entry in evaluator.evalImgs:
        if entry is None or entry["aRng"] != evaluator.params.areaRng[0]:
            continue
        matched = entry["dtMatches"][0] * ~entry["dtIgnore"][0]
        order = [one["id"] for one in evaluator._gts[entry["image_id"], entry["category_id"]]]
        overlaps = evaluator.ious[entry["image_id"], entry["category_id"]]
        for row, annotation in enumerate(matched):
            if annotation:
                hits += 1
                iou_sum += overlaps[row, order.index(int(annotation))]
    return {
        "ap50": [mean(precision[0, :, klass, 0]) for klass in range(classes)],
        "ap50_95": [mean(precision[:, :, klass, 0]) for klass in range(classes)],
        "map50": mean(precision[0, :, :, 0]),
        "map50_95": mean(precision[:, :, :, 0]),
        "sizes_map50": [mean(precision[0, :, :, size]) for size in (1, 2, 3)],
        "sizes_map50_95": [mean(precision[:, :, :, size]) for size in (1, 2, 3)],
        "recall50": [number(value) for value in evaluator.eval["recall"][0, :, 0, -1]],
        "hits50": hits,
        "iou_sum50": iou_sum,
    }


def by_voc(images, classes):
    metric = MetricBuilder.build_evaluation_metric("map_2d", async_mode=False, num_classes=classes)
    for one in images:
        # That evaluator counts the last pixel as part of the box.
        boxes = [[x0, y0, x1 - 1, y1 - 1, klass, score] for klass, score, x0, y0, x1, y1 in one["predicted"]]
        truths = [[x0, y0, x1 - 1, y1 - 1, klass, 0, 0] for klass, x0, y0, x1, y1, _ in one["truth"]]
        metric.add(np.array(boxes, dtype=float).reshape(-1, 6), np.array(truths, dtype=float).reshape(-1, 7))
    eleven = np.array([point / 10 for point in range(11)])
    made = {}
    for name, points in (("all", None), ("11", eleven)):
        value = metric.value(iou_thresholds=[0.5], recall_thresholds=points)
        made[name] = {"ap": [float(value[0.5][klass]["ap"]) for klass in range(classes)], "map": float(value["mAP"])}
    return made


def main():
    made = []
    for name, classes, oracles, images in cases():
        case = {"name": name, "classes": classes, "images": images}
        if "coco" in oracles:
            case["coco"] = by_coco(images, classes)
        if "voc" in oracles:
            case["voc"] = by_voc(images, classes)
        made.append(case)
    lines = ",\n".join(json.dumps(case, separators=(",", ":")) for case in made)
    print(f"[\n{lines}\n]")


main()
