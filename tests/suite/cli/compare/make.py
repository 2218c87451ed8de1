"""Makes columns.csv and expected.json: two column sets of one table, and what numpy and scipy say of their differences.

    pip install numpy==2.4.6 scipy==1.17.1
    python make.py
"""
import json
import pathlib

import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import cKDTree

HERE = pathlib.Path(__file__).parent
ORDERS = {"exclusive": (0.15, 0.0075), "special": (0.25, 0.0075), "1a/1b": (0.5, 0.013), "2": (1.0, 0.023)}
WATER_LEVEL = 1.5


def statistics(measured, reference):
    """Of points that have a reference."""
    there = ~np.isnan(reference)
    d = measured[there] - reference[there]
    depth = WATER_LEVEL - reference[there]
    return {
        "n": int(there.sum()),
        "unmatched": int((~there).sum()),
        "mean_m": np.mean(d),
        "median_m": np.median(d),
        "sd_m": np.std(d, ddof=1),
        "rms_m": np.sqrt(np.mean(d**2)),
        "mae_m": np.mean(np.abs(d)),
        "p95_m": np.quantile(np.abs(d), 0.95),
        "shares": {name: np.mean(np.abs(d) <= np.sqrt(a**2 + (b * depth) ** 2)) for name, (a, b) in ORDERS.items()},
    }


def main():
    rng = np.random.default_rng(4)
    n = 238
    xy = rng.uniform(0, 60, (n, 2)).round(3)
    bed = lambda p: -3 - np.sin(p[:, 0] / 9) - 0.5 * np.cos(p[:, 1] / 7)
    z = (bed(xy) + rng.normal(0.2, 0.17, n)).round(4)
    reference_xy = (xy + rng.normal(0, 1.1, (n, 2))).round(3)
    reference_z = bed(reference_xy).round(4)
    blank = rng.random(n) < 0.05
    rows = ["Easting,Northing,Predicted,RefE,RefN,Elevation,Depth"]
    for (x, y), value, (rx, ry), rz, none in zip(xy, z, reference_xy, reference_z, blank):
        right = ",,," if none else f"{rx},{ry},{rz},{-rz:.4f}"
        rows.append(f"{x},{y},{value},{right}")
    (HERE / "columns.csv").write_text("\n".join(rows) + "\n")

    reference_xy, reference_z = reference_xy[~blank], reference_z[~blank]
    near, index = cKDTree(reference_xy).query(xy)
    nearest = reference_z[index]
    surface = LinearNDInterpolator(reference_xy, reference_z)(xy)
    expected = {
        "all": statistics(z, nearest),
        "some": statistics(z, np.where(near <= 1.0, nearest, np.nan)),
        "surface": statistics(z, surface),
    }
    (HERE / "expected.json").write_text(json.dumps(expected, indent=1) + "\n")


main()
