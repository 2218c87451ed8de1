#!/usr/bin/env python3
"""Writes one survey at 10, 1 and 0.2 Hz into each format, and compares what the program makes of it: `rates.py PROGRAM FOLDER [SEEDS]`.

A boat at 2 m/s runs 450 s straight and 150 s along a circle of 50 m radius. From 300 s to 420 s the recorder has lost the bottom and writes
depths at random, from 1.7 m to 30 m or 108 m. A row for a rate, a format, a greatest depth and a seed (1 to 5 by default): the largest error of
a place, and of the lost soundings those that count, of the others those that do not.
"""
import csv
import math
import shutil
import subprocess
import sys
from datetime import datetime, timezone
from pathlib import Path

import numpy as np

START_UNIX_S, LAT_DEG, LON_DEG, RADIUS_M = 1_700_000_000, 46.0, 8.0, 50.0
# Metres a degree at this latitude (Snyder 1987, series of the WGS 84 ellipsoid).
PHI = math.radians(LAT_DEG)
NORTH_M = 111132.954 - 559.822 * math.cos(2 * PHI) + 1.175 * math.cos(4 * PHI)
EAST_M = 111412.84 * math.cos(PHI) - 93.5 * math.cos(3 * PHI)


def place(time_s):
    """Returns metres to the east and north of the start."""
    if time_s <= 450:
        return 2 * time_s, 0.0
    angle = 2 * (time_s - 450) / RADIUS_M
    return 900 + RADIUS_M * math.sin(angle), RADIUS_M - RADIUS_M * math.cos(angle)


def soundings(interval_s, deepest_m, seed):
    """Returns rows of time, place, depth and whether the bottom was lost."""
    rng = np.random.default_rng(seed)
    rows = []
    for time_s in np.arange(0, 600 + 1e-9, interval_s):
        east_m, north_m = place(time_s)
        is_lost = 300 <= time_s < 420
        depth_m = rng.uniform(1.7, deepest_m) if is_lost else 6 + 1.5 * math.sin(east_m / 60) + north_m / 60
        rows.append((time_s, east_m, north_m, depth_m, is_lost))
    return rows


def degrees(east_m, north_m):
    return LAT_DEG + north_m / NORTH_M, LON_DEG + east_m / EAST_M


def csv_text(rows):
    lines = ["time,lat,lon,depth_m"]
    for time_s, east_m, north_m, depth_m, _ in rows:
        lat, lon = degrees(east_m, north_m)
        lines.append(f"{START_UNIX_S + time_s:.3f},{lat:.9f},{lon:.9f},{depth_m:.2f}")
    return "\n".join(lines) + "\n"


def sentence(body):
    check = 0
    for letter in body:
        check ^= ord(letter)
    return f"${body}*{check:02X}"


def nmea_text(rows, has_time):
    """Returns RMC and DBT, each with the time of the logger before it, or without."""
    minutes = lambda value, width: f"{int(value):0{width}d}{value % 1 * 60:09.6f}"
    lines = []
    for time_s, east_m, north_m, depth_m, _ in rows:
        at, (lat, lon) = datetime.fromtimestamp(START_UNIX_S + time_s, timezone.utc), degrees(east_m, north_m)
        clock = f"{at:%H%M%S}.{at.microsecond // 10000:02d}"
        before = f"{at:%Y-%m-%dT%H:%M:%S}.{at.microsecond // 1000:03d}Z " if has_time else ""
        fix = f"GPRMC,{clock},A,{minutes(lat, 2)},N,{minutes(lon, 3)},E,3.9,,{at:%d%m%y},,"
        for body in (fix, f"SDDBT,{depth_m / 0.3048:.2f},f,{depth_m:.2f},M,{depth_m / 1.8288:.2f},F"):
            lines.append(before + sentence(body))
    return "\r\n".join(lines) + "\r\n"


def judged(program, log, rows, out):
    """Returns the largest error of a place, the lost soundings that count, and the others that do not."""
    shutil.rmtree(out, ignore_errors=True)
    command = [program, "process", log, "-o", out, "--no-objects", "--products", "cloud", "--set", "crs=wgs84"]
    subprocess.run([str(part) for part in command], check=True, capture_output=True)
    with open(out / "points" / "cloud.csv") as file:
        points = [row for row in csv.DictReader(file) if row["source"] == "downscan"]
    assert len(points) == len(rows), f"{log}: {len(points)} points of {len(rows)} soundings"
    worst_m, kept, left_out = 0.0, 0, 0
    for point, (_, east_m, north_m, _, is_lost) in zip(points, rows):
        lat, lon = degrees(east_m, north_m)
        off_m = math.hypot((float(point["lon"]) - lon) * EAST_M, (float(point["lat"]) - lat) * NORTH_M)
        worst_m, counts = max(worst_m, off_m), point["kept"] == "1"
        kept, left_out = kept + (is_lost and counts), left_out + (not is_lost and not counts)
    return worst_m, kept, left_out


def main():
    program, folder = sys.argv[1], Path(sys.argv[2])
    seeds = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    folder.mkdir(parents=True, exist_ok=True)
    print("| Hz | format | to, m | seed | largest error, m | lost | of these kept | good left out |\n|---|---|---|---|---|---|---|---|")
    for interval_s in (0.1, 1.0, 5.0):
        for deepest_m in (30, 108):
            for seed in range(1, seeds + 1):
                rows = soundings(interval_s, deepest_m, seed)
                table = folder / "table.csv"
                table.write_text(csv_text(rows))
                (folder / "timed.nmea").write_text(nmea_text(rows, True), newline="")
                (folder / "untimed.nmea").write_text(nmea_text(rows, False), newline="")
                (folder / "copy.sl2").unlink(missing_ok=True)
                subprocess.run([program, "convert", table, "-o", folder / "copy.sl2"], check=True, capture_output=True)
                for name in ("table.csv", "timed.nmea", "untimed.nmea", "copy.sl2"):
                    worst_m, kept, left_out = judged(program, folder / name, rows, folder / "out")
                    lost = sum(row[4] for row in rows)
                    print(f"| {1 / interval_s:g} | {name} | {deepest_m} | {seed} | {worst_m:.2f} | {lost} | {kept} | {left_out} |", flush=True)


if __name__ == "__main__":
    main()
