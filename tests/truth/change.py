#!/usr/bin/env python3
"""Judges the stated change between two surveys of the same water: `change.py PROGRAM FOLDER [BED ...]`.

BED is `r1` to `r10` (reach.py) or `p1` to `p5` (pond.py); without any, all: 100 pairs. Of each bed there are surveys along the same lines and
along others, with and without a fill (48 m3 in reach.py, a mound of 18 m3 in the pond). A pair holds if the 95 % interval of the net change
contains the true one within the compared cells; where nothing was detected, if the true change is within the volume that may hide. FOLDER keeps the surveys,
and FOLDER/maps the maps of the program: remove them before another program is judged.
"""
import json
import subprocess
import sys
import types
from collections import defaultdict
from pathlib import Path

import numpy as np
import rasterio

import survey
from survey import SIMULATORS, reach

import reach_score  # noqa: E402  (beside reach.py)

# Name of a survey: seed less the bed's number, effects, and metres by which its lines are moved.
REACHES = {f"{lines}{int(filled)}": (seed, ["fill"] * filled, shift_m) for lines, seed, shift_m in (("A", 0, 0.0), ("B", 50, 0.0), ("C", 20, 3.5)) for filled in (False, True)}
PAIRS = {
    "r": [
        ("same lines, no change", "B0 A0"),
        ("same lines, fill", "B1 A0"),
        ("same lines, fill", "A1 B0"),
        ("other lines, no change", "C0 A0"),
        ("other lines, no change", "C0 B0"),
        ("other lines, fill", "C1 A0"),
        ("other lines, fill", "C1 B0"),
        ("other lines, fill", "A1 C0"),
    ],
    "p": [("same lines, no change", "Q0 P0"), ("same lines, fill", "Q1 P0"), ("other lines, no change", "S0 P0"), ("other lines, fill", "S1 P0")],
}
# Draws that a survey of a pond skips, so that its noise is its own, and metres by which its lines are moved.
PONDS = {"P": (0, 0.0), "Q": (1000, 0.0), "S": (3000, 6.0)}
MOUND_M, MOUND_SIGMA_M = 0.45, 2.5


def write_pond(file, bed, name):
    """Writes a survey of pond.py with the lines, the noise and the mound that the name stands for."""
    pond = types.ModuleType("pond")
    source = (SIMULATORS / "pond.py").read_text().rsplit("\nmain()", 1)[0]
    exec(compile(source, "pond.py", "exec"), pond.__dict__)
    place = np.random.default_rng(900 + bed)
    mound = (float(place.uniform(16, 40)), float(place.uniform(25, 95)), MOUND_M, MOUND_SIGMA_M)
    skipped, shift_m = PONDS[name[0]]
    track = pond.track

    def changed(lines, speed, hz):
        caller = sys._getframe(1).f_locals
        caller["rng"].bytes(skipped)
        if name[1] == "1":
            caller["bed"].mounds = [*caller["bed"].mounds, mound]
        time_s, east_m, north_m, heading = track(lines, speed, hz)
        return time_s, east_m + shift_m, north_m, heading

    pond.track = changed
    given, sys.argv = sys.argv, ["pond.py", str(file), "--seed", str(bed), "--lines", "4"]
    try:
        pond.main()
    finally:
        sys.argv = given
    Path(f"{file}.mound.json").write_text(json.dumps(mound))


def depth_map(program, folder, water, name):
    """Returns the folder with the map of a survey, which is made where it is missing."""
    file, out = folder / f"{water}{name}", folder / "maps" / f"{water}{name}"
    bed = int(water[1:])
    if not file.with_suffix(".sl2").exists():
        if water[0] == "r":
            seed, on, shift_m = REACHES[name]
            survey.write(file, seed + bed, on, bed=bed, shift_m=shift_m)
        else:
            write_pond(file, bed, name)
    if not out.exists():
        command = [program, "process", f"{file}.sl2", "-o", out, "--no-objects", "--products", "depth", "--set", "crs=wgs84"]
        subprocess.run([str(part) for part in command], check=True, capture_output=True)
    return out


def true_change_m3(folder, water, new, is_filled, difference):
    """Returns the true volume of the fill within the cells of a difference of two maps."""
    with rasterio.open(difference) as raster:
        known = ~np.isnan(raster.read(1, masked=True).astype(float).filled(np.nan))
        transform = raster.transform
    column, row = np.meshgrid(*(np.arange(count) + 0.5 for count in known.shape[::-1]))
    lon, lat = transform * (column, row)
    if water[0] == "r":
        east_m, north_m = reach_score.to_en(lon, lat)
        bed = int(water[1:])
        height_m = reach.Bed(bed, []).depth(east_m, north_m) - reach.Bed(bed, ["fill"]).depth(east_m, north_m)
    else:
        # The place and the two metres a degree of pond.py.
        east_m = np.radians(lon + 82.1702) * 6378137 * np.cos(np.radians(29.4094)) * 1.0008
        north_m = np.radians(lat - 29.4094) * 6351000
        x_m, y_m, high_m, sigma_m = json.loads((folder / f"{water}{new}.mound.json").read_text())
        height_m = high_m * np.exp(-((east_m - x_m) ** 2 + (north_m - y_m) ** 2) / (2 * sigma_m**2))
    cell_m2 = float(np.median(np.diff(east_m[0])) * abs(np.median(np.diff(north_m[:, 0]))))
    return float(np.sum(height_m[known]) * cell_m2) if is_filled else 0.0


def main():
    program, folder, *waters = sys.argv[1:]
    folder = Path(folder)
    (folder / "maps").mkdir(parents=True, exist_ok=True)
    kinds = defaultdict(list)
    for water in waters or [f"r{bed}" for bed in range(1, 11)] + [f"p{bed}" for bed in range(1, 6)]:
        for kind, pair in PAIRS[water[0]]:
            new, old = pair.split()
            out = folder / "maps" / f"{water}{new}-{old}"
            command = [program, "compare", depth_map(program, folder, water, new), depth_map(program, folder, water, old), "--change", out, "--json"]
            answer = json.loads(subprocess.run([str(part) for part in command], check=True, capture_output=True).stdout)
            truth_m3 = true_change_m3(folder, water, new, "fill" in kind, out / "difference.tif")
            net, hidden_m3 = answer["net"], answer["hidden_fill_m3"]
            holds = abs(net["volume_m3"] - truth_m3) <= net["within_95_m3"] if net["places"] else truth_m3 <= hidden_m3
            kinds[f"{water[0]} {kind}"].append((holds, net["within_95_m3"], net["places"]))
            print(f"{water} {pair}: true {truth_m3:.0f}, net {net['volume_m3']:.0f} +- {net['within_95_m3']:.0f} m3{'' if holds else ' FAILS'}", flush=True)
    for kind, pairs in kinds.items():
        widths = sorted(width for _, width, places in pairs if places)
        median = f"+-{widths[len(widths) // 2]:.0f} m3" if widths else "none detected"
        print(f"{kind}: {sum(holds for holds, *_ in pairs)} of {len(pairs)} hold, median {median}, nothing detected in {len(pairs) - len(widths)}")


if __name__ == "__main__":
    main()
