"""The mean of two networks' weights, where the second was trained on from the first: python average.py FIRST.npz SECOND.npz OUT.npz

Between two ends of one training lies a network that is mostly better than either (M. Wortsman and others, Model soups, ICML
2022). What is told about it is what the second one tells.
"""

import sys

from network import build
from weights import load_weights, save_weights


def main(first: str, second: str, out: str) -> None:
    """Reads both, writes their mean."""
    (one, before), (other, meta) = load_weights(first, build), load_weights(second, build)
    if any(before[key] != meta[key] for key in ("network", "width", "names", "anchors")):
        raise SystemExit(f"these are networks of other kinds, classes or anchors: {first}, {second}")
    theirs = one.state_dict()
    mean = {key: (own + theirs[key]) / 2 if own.is_floating_point() else own for key, own in other.state_dict().items()}
    other.load_state_dict(mean)
    meta.setdefault("training", {})["averaged"] = "with the weights that it started from"
    save_weights(other, meta, out)


if __name__ == "__main__":
    main(*sys.argv[1:4])
