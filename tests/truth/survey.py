#!/usr/bin/env python3
"""Writes surveys of `../shared/simulators/reach.py`: `survey.py FILE SEED EFFECTS [--bed SEED] [--shift METRES]`.

FILE.sl2 is the log and FILE.truth.csv the truth, as reach.py writes them; EFFECTS are names with commas between them, or `base`. `slow4` is an
effect of this script: every fourth ping of the log, two a second, as of a slow recorder; `slow8` is one ping a second. The echoes take most
of the time. Surveys that differ in soundings or positions alone share them, in the folder `echoes` beside FILE.
"""
import argparse
import csv
import math
import os
import re
import struct
import sys
from pathlib import Path

import numpy as np

SIMULATORS = Path(os.environ.get("BATHYSCOPE_SIMULATORS", Path(__file__).resolve().parents[3] / "shared" / "simulators"))
sys.path.insert(0, str(SIMULATORS))
import reach  # noqa: E402

# Effects that change no echo.
SILENT = {"quant", "quant10", "lag", "lost", "double", "cone", "gps", "lever"}
HEADER = (
    "ping time_s east_m north_m heading_deg depth_m port_range_m starboard_range_m port_seen_m starboard_seen_m "
    "level_m sounding_m s_m t_m labels"
).split()


def effects(names):
    """Returns the effects in a text such as `cut,lag`; `base` is none."""
    return [name for name in names.split(",") if name not in ("", "base")]


def slowness(on):
    """Returns the number of pings of which a slow recorder writes one, and the other effects."""
    slow = [int(match[1]) for effect in on if (match := re.fullmatch(r"slow(\d+)", effect))]
    return max(slow, default=1), [effect for effect in on if not effect.startswith("slow")]


def write(file, seed, on, bed=None, shift_m=0.0):
    """Writes the log and the truth of a survey: of another bed than the seed's with `bed`, beside its lines with `shift_m`."""
    every, on = slowness(on)
    make_bed, path = reach.Bed, reach.path
    if bed is not None:
        reach.Bed = lambda _, on: make_bed(bed, on)

    def shifted(rng, on):
        time_s, s, t, heading, speed = path(rng, on)
        return time_s, s, t + shift_m, heading, speed

    reach.path = shifted
    try:
        survey = with_echoes(file, seed, on, bed, shift_m)
    finally:
        reach.Bed, reach.path = make_bed, path
    log = Path(f"{file}.sl2")
    reach.write_sl2(log, survey, np.random.default_rng(seed + 6), on)
    pings = len(survey["t"])
    if every > 1:
        frames_a_ping = sum(1 for _ in frames(log.read_bytes())) // pings
        with_frames(log, log, lambda frame, channel: frame // frames_a_ping % every == 0)
    write_truth(f"{file}.truth.csv", survey, range(0, pings, every))


def frames(data):
    """Returns the place, size and channel of each frame of an SL2."""
    at = 8
    while at < len(data):
        size, _, channel = struct.unpack_from("<HHH", data, at + 28)
        yield at, size, channel
        at += size


def with_frames(log, made, is_kept):
    """Writes the frames of an SL2 for whose number and channel `is_kept` is true, with links that are mended."""
    data = log.read_bytes()
    out, last, before = bytearray(data[:8]), 0, 0
    for number, (at, size, channel) in enumerate(frames(data)):
        if is_kept(number, channel):
            frame, place = bytearray(data[at : at + size]), len(out)
            struct.pack_into("<7I", frame, 0, place, last, 0, 0, 0, 0, 0)
            struct.pack_into("<H", frame, 30, before)
            last, before = place, size
            out += frame
    made.write_bytes(out)


def with_echoes(file, seed, on, bed, shift_m):
    loud = sorted(effect for effect in on if effect not in SILENT)
    kept = Path(file).parent / "echoes" / f"{seed}-{'+'.join(loud)}-{bed}-{shift_m}.npz"
    if set(loud) != set(on) and kept.exists():
        survey = reach.survey(seed, on, echoes=False)
        with np.load(kept) as echoes:
            survey.update({name: echoes[name] for name in ("true", "seen", "raw")})
        return survey
    survey = reach.survey(seed, on)
    if not kept.exists():
        kept.parent.mkdir(parents=True, exist_ok=True)
        unfinished = kept.with_suffix(".unfinished.npz")
        np.savez(unfinished, **{name: survey[name] for name in ("true", "seen", "raw")})
        unfinished.rename(kept)
    return survey


def write_truth(file, survey, pings):
    with open(file, "w", newline="") as out:
        rows = csv.writer(out)
        rows.writerow(HEADER)
        for ping in pings:
            time_s = survey["t"][ping]
            value = lambda name: survey[name][ping]
            metres = [value("e"), value("n"), math.degrees(value("azimuth")) % 360, value("depth"), *value("true"), *value("seen")]
            metres += [value("level"), value("z"), value("s"), value("v")]
            labels = " ".join(name for name, pings in survey["flags"].items() if pings[ping])
            rows.writerow([ping, f"{time_s:.3f}", *(f"{number:.3f}" for number in metres), labels])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file")
    parser.add_argument("seed", type=int)
    parser.add_argument("effects")
    parser.add_argument("--bed", type=int)
    parser.add_argument("--shift", type=float, default=0.0)
    given = parser.parse_args()
    write(given.file, given.seed, effects(given.effects), given.bed, given.shift)
