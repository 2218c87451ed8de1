"""Writes height_offsets.json: meetings of logs with noise and outliers, and the height offsets that scipy finds.

Needs numpy and scipy. The weights are those of src/bathymetry/height_offsets/network.rs; the solution is scipy's own:
`least_squares` with Huber's loss and from there with Tukey's, the scale of the residuals settled in an outer loop.
"""

import json
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

DEPTH_SIGMA, POSITION_SIGMA, HUBER, TUKEY = 0.03, 0.5, 1.345, 4.685


def tukey(z):
    inside = np.clip(1 - z, 0, None)
    return np.array([(1 - inside**3) / 3, inside**2, -2 * inside])


def solve(count, a, b, d, sigma):
    full = lambda h: np.append(h, -h.sum())  # mean zero
    u = lambda h: (d - (full(h)[a] - full(h)[b])) / sigma
    h = least_squares(u, np.zeros(count - 1), x_scale="jac").x
    for loss, tuning in [("huber", HUBER), (tukey, TUKEY)]:
        for _ in range(200):
            scale = 1.4826 * np.median(np.abs(u(h)))
            new = least_squares(
                u, h, loss=loss, f_scale=tuning * scale, xtol=1e-15, ftol=1e-15, gtol=1e-15
            ).x
            moved = np.abs(new - h).max()
            h = new
            if moved < 1e-10:
                break
    r = u(h)
    w = np.clip(1 - (r / (TUKEY * scale)) ** 2, 0, None) ** 2
    design = np.zeros((len(d), count))
    design[np.arange(len(d)), a] = 1
    design[np.arange(len(d)), b] = -1
    normal = design.T @ (design * (w / sigma**2)[:, None])
    variance = (w * r**2).sum() / (w.sum() - (count - 1))
    # The pseudo-inverse is that of the solution with mean zero.
    errors = np.sqrt(np.diag(np.linalg.pinv(normal)) * variance)
    return full(h), errors


def case(seed, count, meetings, outliers):
    rng = np.random.default_rng(seed)
    truth = rng.normal(0, 0.3, count)
    truth -= truth.mean()
    pairs = np.sort(rng.integers(0, count, (meetings * 3, 2)), axis=1)
    pairs = pairs[pairs[:, 0] != pairs[:, 1]][:meetings]
    a, b = pairs.T
    slope = rng.exponential(0.08, len(a))
    sigma = np.hypot(DEPTH_SIGMA, slope * POSITION_SIGMA)
    d = truth[a] - truth[b] + rng.normal(0, 0.6 * sigma)
    wrong = rng.random(len(a)) < outliers
    d[wrong] += rng.uniform(0.3, 2.0, wrong.sum())
    d, slope = np.round(d, 4), np.round(slope, 4)
    sigma = np.hypot(DEPTH_SIGMA, slope * POSITION_SIGMA)
    h, errors = solve(count, a, b, d, sigma)
    print(seed, "largest error", np.abs(h - truth).max(), "largest standard error", errors.max())
    return {
        "count": count,
        "meetings": [[int(i), int(j), float(x), float(s)] for i, j, x, s in zip(a, b, d, slope)],
        "truth_m": np.round(truth, 6).tolist(),
        "offsets_m": np.round(h, 8).tolist(),
        "errors_m": np.round(errors, 8).tolist(),
    }


cases = [case(1, 10, 150, 0.0), case(2, 10, 300, 0.15), case(3, 4, 40, 0.1)]
Path(__file__).with_name("height_offsets.json").write_text(json.dumps(cases, separators=(",", ":")) + "\n")
