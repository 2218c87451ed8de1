"""One side of a log as the program draws it for a detector (`src/objects/raster.rs`): square pixels, rows along the track."""

import math

import numpy as np

SIDE, PIXEL_M = 416, 0.04


def raster(levels: np.ndarray, along_m: np.ndarray, per_sample_m: float, range_m: float) -> np.ndarray:
    """One side as `objects/raster.rs` draws it: `[rows, columns]` of square pixels, not yet rounded."""
    columns = math.ceil(range_m / PIXEL_M)
    edges = np.minimum(np.round(np.arange(columns + 1) * PIXEL_M / per_sample_m).astype(int), levels.shape[1])
    sums = np.concatenate([np.zeros((len(levels), 1)), np.cumsum(levels, 1)], 1)
    widths = np.maximum(edges[1:] - edges[:-1], 1)
    lines = (sums[:, edges[1:]] - sums[:, edges[:-1]]) / widths
    rows = np.zeros((math.ceil(along_m[-1] / PIXEL_M), columns))
    for row in range(len(rows)):
        middle = (row + 0.5) * PIXEL_M
        first, last = np.searchsorted(along_m, (middle - PIXEL_M / 2, middle + PIXEL_M / 2))
        if middle > along_m[-1]:
            break
        if last > first:
            rows[row] = lines[first:last].mean(0)
        else:
            after = min(last, len(along_m) - 1)
            before = max(after - 1, 0)
            share = (middle - along_m[before]) / max(along_m[after] - along_m[before], 1e-9)
            rows[row] = lines[before] * (1 - share) + lines[after] * share
    return rows
