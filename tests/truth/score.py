#!/usr/bin/env python3
"""Scores the program on surveys of reach.py: `score.py PROGRAM FOLDER [EFFECTS-SEED ...]`, for example `score.py bathyscope reaches cut,lag-1`.

Without names: every effect with both kinds of beams, and six combinations (218 surveys, an hour on two cores and 6 GB, of which the
simulation is the most). FOLDER keeps the surveys, so that the next program is scored in a third of the time. Each survey is processed as
recorded, without its side-scan, and, where it has an offset of time or place, with `--latency`. FOLDER/scores.jsonl gets a line for each.

A table follows, with a row for an effect: the worst cell too deep within 0.75 m of the track, cm, by seed, of all witnesses and of the
soundings alone; the largest ratio of the RMS error within 0.5 m to that of the soundings alone; the shares of these cells within one and two
stated standard deviations, on all ground and on slopes of more than 10 degrees; first returns kept that are over 1 m late, and the largest
share of those over 0.3 m wrong; and the warnings, with # for their numbers.
"""
import json
import re
import shutil
import subprocess
import sys
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import survey
from survey import effects, reach

import reach_score  # noqa: E402  (beside reach.py)

WITH_GOALS = "base double lost cut scarp quay layer lag lever gps".split()
OTHERS = (
    "weed waves cone dunes sound draft tilt surface piers shoal fill quant quant10 second wash interf gain range ring unequal overlap speed "
    "stop tight fall high slow4 slow8"
).split()
COMBINED = {"cut,lag": (1, 2, 3), "lever,quant10": (1, 2, 3), "gps,waves": (1, 2, 3), "double,quay": (4, 5, 6), "layer,scarp": (4, 5, 6), "lost,weed": (4, 5, 6)}
OFFSETS = {"lag", "lever", "gps"}


def all_names():
    """Returns the names of all surveys, those with goals first."""
    names = [f"{effect}-{seed}" for effect in WITH_GOALS for seed in range(1, 7)]
    names += [f"{'halves' if effect == 'base' else f'halves,{effect}'}-{seed}" for effect in WITH_GOALS for seed in range(1, 7)]
    names += [f"{effects}-{seed}" for effects, seeds in COMBINED.items() for seed in seeds]
    names += [f"{effect}-{seed}" for effect in OTHERS for seed in (1, 2)]
    return names + [f"halves,{effect}-1" for effect in OTHERS if effect != "overlap"]


def processed(program, log, out, options):
    command = [program, "process", log, "-o", out, "--no-objects", "--products", "cloud,depth,residuals,report", "--set", "crs=wgs84", *options]
    subprocess.run([str(part) for part in command], check=True, capture_output=True, timeout=900)


def map_errors(out, truth, seed, on):
    """Returns the errors of the map and of its first returns as a dictionary; centimetres and per cent."""
    depth, lon, lat = reach_score.raster(out, "depth.tif")
    sigma_m = reach_score.raster(out, "uncertainty.tif")[0]
    bed = reach.Bed(seed, on)
    east_m, north_m = reach_score.to_en(lon, lat)
    true_m = bed.depth(east_m, north_m)
    error_m = np.abs(depth) - true_m
    column = lambda name: reach_score.col(truth, name)
    track = cKDTree(np.c_[column("east_m"), column("north_m")])
    away_m = track.query(np.c_[east_m.ravel(), north_m.ravel()])[0].reshape(depth.shape)
    s, t = reach.to_st(east_m, north_m)
    known = ~np.isnan(error_m) & (true_m > 0.3)
    inside = known & (t > 7) & (t < 39) & (s > 12) & (s < 168)
    half = 0.25
    slope = [bed.depth(east_m + x, north_m + y) - bed.depth(east_m - x, north_m - y) for x, y in ((half, 0), (0, half))]
    steep = np.degrees(np.arctan(np.hypot(*slope) / (2 * half))) > 10

    def shares(cells):
        return [100 * float(np.mean(np.abs(error_m[cells]) <= times * sigma_m[cells])) for times in (1, 2)]

    scores = {"bands": {}, "steep": shares(inside & (away_m < 0.5) & steep)}
    for near_m, far_m in ((0, 0.5), (0.5, 1.5), (1.5, 4), (4, 8)):
        cells = inside & (away_m >= near_m) & (away_m < far_m)
        if cells.sum() >= 5:
            scores["bands"][f"{near_m}-{far_m}"] = [100 * float(np.sqrt(np.mean(error_m[cells] ** 2))), *shares(cells)]
    scores["worst"] = 100 * float(np.max(np.where(known & (away_m < 0.75), error_m, -9)))
    return scores


def return_errors(out, truth):
    """Returns the first returns that are kept and over 1 m late, and the share of all that are kept and over 0.3 m wrong, per cent."""
    cloud = reach_score.table(next(out.rglob("cloud.csv")))
    returns = reach_score.table(next(out.rglob("first_returns.csv")))
    late = wrong = count = 0
    for side in ("port", "starboard"):
        kept = np.zeros(len(truth), bool)
        kept[[int(row["ping"]) for row in cloud if row["source"] == side and row["kept"] == "1"]] = True
        range_m = reach_score.col(returns, f"{side}_range_m")
        # The true first return, and the first that stands above all noise.
        off_m = [range_m - reach_score.col(truth, f"{side}_{name}_m") for name in ("range", "seen")]
        off_m[1] = np.where(np.isnan(off_m[1]), 99, off_m[1])
        with np.errstate(invalid="ignore"):
            late += int((kept & (np.minimum(*off_m) > 1)).sum())
            wrong += int((kept & (np.minimum(*np.abs(off_m)) > 0.3)).sum())
        count += int((~np.isnan(range_m)).sum())
    return {"late": late, "wrong": 100 * wrong / max(count, 1)}


def score(program, folder, name):
    """Returns the scores of a survey, by the way in which it was processed."""
    names, seed = name.rsplit("-", 1)
    on, seed, log = effects(names), int(seed), folder / f"{name}.sl2"
    if not log.with_suffix(".truth.csv").exists():
        survey.write(folder / name, seed, on)
    truth = reach_score.table(log.with_suffix(".truth.csv"))
    alone = folder / f"{name}-alone.sl2"
    survey.with_frames(log, alone, lambda frame, channel: channel == 0)
    ways = {"recorded": (log, []), "alone": (alone, [])} | ({"corrected": (log, ["--latency"])} if OFFSETS & set(on) else {})
    scores = {"name": name}
    for way, (log, options) in ways.items():
        out = folder / f"{name}-{way}"
        processed(program, log, out, options)
        scores[way] = map_errors(out, truth, seed, on)
        if way != "alone":
            report = json.loads(next(out.rglob("report.json")).read_text())
            scores[way] |= return_errors(out, truth) | {"warnings": report.get("warnings") or []}
        shutil.rmtree(out)
    alone.unlink()
    return scores


def row(effect, way, scores):
    near = [one[way]["bands"]["0-0.5"] for one in scores]
    ratio = max(one[way]["bands"]["0-0.5"][0] / one["alone"]["bands"]["0-0.5"][0] for one in scores)
    worst = lambda way: " ".join(f"{one[way]['worst']:.0f}" for one in scores)
    mean = lambda values: "/".join(f"{np.mean(each):.0f}" for each in zip(*values))
    span = lambda index: f"{min(each[index] for each in near):.0f}-{max(each[index] for each in near):.0f}"
    shares = f"{mean([each[1:] for each in near])} ({span(1)}/{span(2)}) | {mean([one[way]['steep'] for one in scores])}"
    returns = f"{sum(one[way]['late'] for one in scores)}, {max(one[way]['wrong'] for one in scores):.1f} %"
    return f"| {effect}{'' if way == 'recorded' else f', {way}'} | {worst(way)} | {worst('alone')} | {ratio:.2f} | {shares} | {returns} |"


def print_table(all_scores):
    by_effect = defaultdict(list)
    for scores in all_scores:
        by_effect[scores["name"].rsplit("-", 1)[0]].append(scores)
    print("| effect | worst, cm | alone | ratio | 1/2 sigma | steep | late, wrong |\n|---|---|---|---|---|---|---|")
    for effect, scores in by_effect.items():
        for way in ("recorded", "corrected"):
            if way in scores[0]:
                print(row(effect, way, scores))
    for effect, scores in by_effect.items():
        warnings = Counter(re.sub(r"\d[\d .,]*", "# ", text) for one in scores for text in one["recorded"]["warnings"])
        for text, count in warnings.items():
            print(f"{effect}, {count} times in {len(scores)} surveys: {text}")


def main():
    program, folder, *names = sys.argv[1:]
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    all_scores = []
    for name in names or all_names():
        all_scores.append(score(program, folder, name))
        with open(folder / "scores.jsonl", "a") as out:
            out.write(json.dumps(all_scores[-1]) + "\n")
        print(f"{name}: worst {all_scores[-1]['recorded']['worst']:.0f} cm", file=sys.stderr)
    print_table(all_scores)


if __name__ == "__main__":
    main()
