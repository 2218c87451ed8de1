#!/usr/bin/env python3
"""Writes epsg.csv: positions and their places in EPSG systems, by pyproj (3.7.2 when the file was made).

Every twelfth projected system in metres on a GRS80 or WGS84 ellipsoid for which PROJ, asked from WGS84, changes nothing but
the projection; and those that users name most.
"""
import csv
import pathlib

import pyproj
from pyproj.database import query_crs_info
from pyproj.enums import PJType

NAMED = [2154, 2193, 3006, 3034, 3035, 3067, 3857, 5041, 6350, 7856, 25830, 25832, 26912, 26917, 28355, 31983, 32612, 32756]


def plain(crs, position):
    """Whether the place is that of the bare projection, and where it is."""
    place = pyproj.Transformer.from_crs(4326, crs, always_xy=True).transform(*position)
    bare = pyproj.Transformer.from_crs(crs.geodetic_crs, crs, always_xy=True).transform(*position)
    return max(abs(a - b) for a, b in zip(place, bare)) < 1e-4, place


rows = []
for info in query_crs_info(auth_name="EPSG", pj_types=PJType.PROJECTED_CRS):
    code, area = int(info.code), info.area_of_use
    crs = pyproj.CRS.from_epsg(code)
    ellipsoid = crs.ellipsoid.name if crs.ellipsoid else ""
    metres = {axis.unit_name for axis in crs.axis_info} == {"metre"}
    if code > 65535 or area is None or not metres or ellipsoid not in ("GRS 1980", "WGS 84"):
        continue
    if code not in NAMED and code % 12:
        continue
    east = area.east if area.east >= area.west else area.east + 360
    position = ((0.6 * area.west + 0.4 * east + 180) % 360 - 180, 0.4 * area.south + 0.6 * area.north)
    try:
        ok, place = plain(crs, position)
    except pyproj.exceptions.ProjError:
        continue
    if ok:
        rows.append([code, *(f"{value:.9f}" for value in position), *(f"{value:.5f}" for value in place)])
with open(pathlib.Path(__file__).with_name("epsg.csv"), "w", newline="") as file:
    csv.writer(file, lineterminator="\n").writerows([["epsg", "lon", "lat", "x", "y"], *rows])
