#!/usr/bin/env python3
"""Compares the error of depth maps of pond.py with the error that they state: `ponds.py PROGRAM FOLDER [KIND ...]`.

KIND is `rocks`, `mounds`, `shoal` or `level`; without any, all four. Of each there are twelve ponds of six lines (seeds 1 to 12), which FOLDER
keeps. A row for a kind: by the distance to the track, the RMS of the error and of the stated standard deviation, and the shares of the cells
within one and two of these, as mean (lowest to highest pond); and the largest error of the shoal's depth.
"""
import pickle
import shutil
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from survey import SIMULATORS

import reach_score  # noqa: E402  (beside pond.py)

KINDS = {"rocks": [], "mounds": ["--mounds", "40"], "shoal": ["--shoal", "0.5"], "level": ["--flat"]}
BANDS_M = ((0, 0.5), (0.5, 1.5), (1.5, 4), (4, 8))
SEEDS = range(1, 13)
# The shoal of pond.py, metres east and north.
SHOAL_M = (22, 40)


def load_pond():
    pond = types.ModuleType("pond")
    source = (SIMULATORS / "pond.py").read_text().rsplit("\nmain()", 1)[0]
    exec(compile(source, "pond.py", "exec"), pond.__dict__)
    return pond


def write(file, seed, options):
    """Writes a pond with its bed, which the simulator keeps to itself: FILE.bed.pickle has its numbers."""
    pond, beds = load_pond(), []

    class Kept(pond.Bed):
        def __init__(self, *given):
            super().__init__(*given)
            beds.append(self)

    pond.Bed = Kept
    given, sys.argv = sys.argv, ["pond.py", str(file), "--seed", str(seed), *options]
    try:
        pond.main()
    finally:
        sys.argv = given
    Path(f"{file}.bed.pickle").write_bytes(pickle.dumps(beds[-1].__dict__))


def scores(program, folder, kind, seed):
    """Returns for each band error, stated error, and shares; and the error of the shallowest cell over the shoal, cm."""
    file = folder / f"{kind}-{seed}"
    kept = Path(f"{file}.bed.pickle")
    if not kept.exists():
        write(file, seed, KINDS[kind])
    pond = load_pond()
    bed = pond.Bed.__new__(pond.Bed)
    bed.__dict__ = pickle.loads(kept.read_bytes())
    out = folder / f"{kind}-{seed}-map"
    command = [program, "process", f"{file}.sl2", "-o", out, "--no-objects", "--products", "depth", "--set", "crs=wgs84"]
    subprocess.run([str(part) for part in command], check=True, capture_output=True)
    depth, lon, lat = reach_score.raster(out, "depth.tif")
    sigma_m = reach_score.raster(out, "uncertainty.tif")[0]
    shutil.rmtree(out)
    # East and north as pond.to_lonlat places them.
    origin_lon, origin_lat = pond.to_lonlat(0, 0)
    east_m = (lon - origin_lon) / (pond.to_lonlat(1, 0)[0] - origin_lon)
    north_m = (lat - origin_lat) / (pond.to_lonlat(0, 1)[1] - origin_lat)
    true_m = bed.depth(east_m, north_m)
    error_m = np.abs(depth) - true_m
    truth = reach_score.table(f"{file}.truth.csv")
    track = cKDTree(np.c_[reach_score.col(truth, "east_m"), reach_score.col(truth, "north_m")])
    away_m = track.query(np.c_[east_m.ravel(), north_m.ravel()])[0].reshape(depth.shape)
    bands = []
    for near_m, far_m in BANDS_M:
        cells = ~np.isnan(error_m) & (away_m >= near_m) & (away_m < far_m)
        error, sigma = error_m[cells], sigma_m[cells]
        rms = [100 * np.sqrt(np.mean(values**2)) for values in (error, sigma)]
        bands.append([*rms, *(100 * np.mean(np.abs(error) <= times * sigma) for times in (1, 2))])
    over = np.hypot(east_m - SHOAL_M[0], north_m - SHOAL_M[1]) < 0.5
    return bands, 100 * float(np.nanmax(np.abs(error_m[over]))) if over.any() else np.nan


def main():
    program, folder, *kinds = sys.argv[1:]
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for kind in kinds or KINDS:
        ponds, shoals_cm = zip(*(scores(program, folder, kind, seed) for seed in SEEDS))
        ponds = np.array(ponds)
        cells = []
        for band in range(len(BANDS_M)):
            error, sigma = np.sqrt(np.mean(ponds[:, band, :2] ** 2, axis=0))
            share = lambda index: "{:.0f} ({:.0f} to {:.0f})".format(*(of(ponds[:, band, index]) for of in (np.mean, np.min, np.max)))
            cells.append(f"{error:.1f}, {sigma:.1f} cm: {share(2)}, {share(3)} %")
        print(f"| {kind} | {' | '.join(cells)} |" + (f" shoal off by at most {max(shoals_cm):.1f} cm" if kind == "shoal" else ""), flush=True)


if __name__ == "__main__":
    main()
