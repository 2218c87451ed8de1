"""Bathyscope's own run of a model (tract) against onnxruntime on the same machine, alternately: ratios, and peak memory.

    python speed.py [--rounds 3] [--model ../default.onnx]

needs `onnxruntime numpy` and, for Bathyscope's side, cargo: it runs `cargo bench -- detector`, which searches a
tile on one thread and a simulated survey of 10 000 pings on two. onnxruntime then runs as many bare networks, without drawing,
levelling, decoding, suppression and merging: the ratios are against Bathyscope. On a busy machine look at the processor time."""

import argparse
import os
import re
import statistics
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import onnxruntime

ROOT = Path(__file__).resolve().parents[3]
THREADS = 2
TILES = 20
SIDE = 416


def of_bathyscope(model: Path) -> dict:
    """Seconds of a tile and of the survey, on the clock and of processor; tiles of the survey; MB."""
    env = {**os.environ, "RAYON_NUM_THREADS": str(THREADS), "BATHYSCOPE_MODEL": str(model)}
    command = ["cargo", "bench", "--bench", "bench", "--", "detector"]
    told = subprocess.run(command, cwd=ROOT, env=env, check=True, capture_output=True, text=True).stdout
    tile = re.search(r"a tile.*?([\d.]+) ms \(([\d.]+) ms of processor", told)
    survey = re.search(r"pings, (\d+) tiles\s+([\d.]+) s \(([\d.]+) s of processor", told)
    memory = re.search(r"memory\s+(\d+) MB at the peak, (\d+) MB before", told)
    return {
        "tile_s": float(tile[1]) / 1e3,
        "tile_processor_s": float(tile[2]) / 1e3,
        "tiles": int(survey[1]),
        "survey_s": float(survey[2]),
        "survey_processor_s": float(survey[3]),
        "peak_mb": int(memory[1]) if memory else 0,
        "before_mb": int(memory[2]) if memory else 0,
    }


def session(model: Path) -> onnxruntime.InferenceSession:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    return onnxruntime.InferenceSession(model.read_bytes(), options, providers=["CPUExecutionProvider"])


def of_onnxruntime(model: Path, tiles: int) -> dict:
    """The same of bare networks: one thread, and a network a thread for the survey's tiles."""
    numbers = (np.arange(SIDE * SIDE) * 7 % 251).astype(np.float32).reshape(1, 1, SIDE, SIDE) / 255
    sessions = [session(model) for _ in range(THREADS)]
    feed = {sessions[0].get_inputs()[0].name: numbers}
    sessions[0].run(None, feed)
    took, spent = [], time.process_time()
    for _ in range(TILES):
        start = time.perf_counter()
        sessions[0].run(None, feed)
        took.append(time.perf_counter() - start)
    tile_processor_s = (time.process_time() - spent) / TILES

    def search(one: onnxruntime.InferenceSession) -> None:
        for _ in range(tiles // THREADS):
            one.run(None, feed)

    threads = [threading.Thread(target=search, args=(one,)) for one in sessions]
    start, spent = time.perf_counter(), time.process_time()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return {
        "tile_s": statistics.median(took),
        "tile_processor_s": tile_processor_s,
        "survey_s": time.perf_counter() - start,
        "survey_processor_s": time.process_time() - spent,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--model", type=Path, default=ROOT / "assets/detector/default.onnx")
    args = parser.parse_args()
    rounds = []
    for _ in range(args.rounds):
        ours = of_bathyscope(args.model.resolve())
        rounds.append((ours, of_onnxruntime(args.model, ours["tiles"])))
    rows = {
        "tile_s": "a tile, one thread, on the clock",
        "tile_processor_s": "a tile, processor",
        "survey_s": f"10 000 pings, {rounds[0][0]['tiles']} tiles, {THREADS} threads, on the clock",
        "survey_processor_s": "10 000 pings, processor",
    }
    print(f"{'medians of ' + str(args.rounds) + ' rounds':56} Bathyscope  onnxruntime  ratio")
    for key, words in rows.items():
        ours, theirs = (statistics.median(one[side][key] for one in rounds) for side in (0, 1))
        print(f"{words:56} {ours:9.3f} s {theirs:10.3f} s  {ours / theirs:5.2f}")
    peak, before = (max(one[0][key] for one in rounds) for key in ("peak_mb", "before_mb"))
    print(f"peak memory of the search of 10 000 pings: {peak} MB, of which {before} MB were there before it")


if __name__ == "__main__":
    main()
