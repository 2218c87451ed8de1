"""Boxes of the shipped model on one chip by onnxruntime and a suppression of its own: python oracle.py chip.png boxes.json"""

import json
import sys
from pathlib import Path

import numpy as np
import onnxruntime
from PIL import Image

SCORE, IOU = 0.3, 0.45
model = Path(__file__).resolve().parents[5] / "assets/detector/default.onnx"
chip = np.asarray(Image.open(sys.argv[1]).convert("L"), np.float32)
session = onnxruntime.InferenceSession(model.read_bytes(), providers=["CPUExecutionProvider"])
boxes, confs = session.run(["boxes", "confs"], {"input": chip[None, None] / 255})
boxes, confs = boxes[0, :, 0] * chip.shape[0], confs[0]

kept = []
for row in np.argsort(-confs.max(1), kind="stable"):
    score, box = confs[row].max(), boxes[row]
    if score < SCORE:
        break
    low = [np.maximum(box[:2], other["box"][:2]) for other in kept]
    high = [np.minimum(box[2:], other["box"][2:]) for other in kept]
    area = lambda b: float(np.prod(np.maximum(b[2:] - b[:2], 0)))
    shared = [float(np.prod(np.maximum(h - l, 0))) for l, h in zip(low, high)]
    if all(s / (area(box) + area(o["box"]) - s) <= IOU for s, o in zip(shared, kept)):
        kept.append({"class": int(confs[row].argmax()), "score": float(score), "box": box})
found = [{**one, "box": [float(v) for v in one["box"]]} for one in kept]
Path(sys.argv[2]).write_text(json.dumps(found, indent=1) + "\n")
print(len(found), found)
