#!/usr/bin/env python3
"""The checks must be able to fail: each spoils a copy of a folder that passes in one small way."""

import json
import shutil
import sys
import tempfile
from pathlib import Path

import rasterio
from check import check


def edit(name, change):
    """Changes a JSON file."""

    def spoil(folder):
        content = json.loads((folder / name).read_text())
        change(content)
        (folder / name).write_text(json.dumps(content))

    return spoil


def shift_a_point(folder):
    """Moves the last point of cloud.csv by a centimetre."""
    lines = (folder / "cloud.csv").read_text().splitlines()
    fields = lines[-1].split(",")
    fields[3] = f"{float(fields[3]) + 1e-7:.9f}"
    (folder / "cloud.csv").write_text("\n".join([*lines[:-1], ",".join(fields)]) + "\n")


def deepen(folder):
    """Takes the depth map 10 cm down, its record too."""
    with rasterio.open(folder / "depth.tif", "r+") as raster:
        values = raster.read(1)
        values[values != raster.nodata] += 0.1
        raster.write(values, 1)
    edit("depth.tif.json", lambda record: [record["values"].update({key: record["values"][key] + 0.1}) for key in ("least", "most")])(folder)


def append_overviews(folder):
    """Has GDAL make the overviews again, at the end of the file."""
    with rasterio.Env(GDAL_DISABLE_READDIR_ON_OPEN=True, IGNORE_COG_LAYOUT_BREAK="YES"):
        with rasterio.open(folder / "mosaic.tif", "r+") as raster:
            raster.build_overviews([2, 4, 8], rasterio.enums.Resampling.nearest)


def darken(folder):
    """Takes a level off a cell of the mosaic, its statistics left as they are."""
    with rasterio.Env(IGNORE_COG_LAYOUT_BREAK="YES"), rasterio.open(folder / "mosaic.tif", "r+") as raster:
        values = raster.read(1)
        values[values > 100] -= 1
        raster.write(values, 1)


def other_zone(folder):
    path = folder / "isobaths.prj"
    path.write_text(path.read_text().replace("-81", "-87"))


SPOILERS = {
    "a wrong count": edit("cloud.laz.json", lambda record: record["count"].update(points=1)),
    "a wrong system": edit("mosaic.tif.json", lambda record: record["crs"].update(epsg=32616)),
    "a wrong extent": edit("isobaths.shp.json", lambda record: record["extent"].update(west=0.0)),
    "a missing record": lambda folder: (folder / "track.kmz.json").unlink(),
    "a point moved by a centimetre": shift_a_point,
    "a map 10 cm too deep": deepen,
    "a mosaic that is darker than it says": darken,
    "overviews at the end of the file": append_overviews,
    "another zone": other_zone,
    "a line too few": edit("track.geojson", lambda lines: lines["features"].pop()),
    "an isobath of another depth": edit("isobaths.geojson", lambda lines: lines["features"][0]["properties"].update(depth_m=1.9)),
    "a band that crosses itself": edit(
        "depth_areas.geojson", lambda areas: areas["features"][0]["geometry"]["coordinates"][0][0].insert(1, [0.0, 0.0])
    ),
}

if __name__ == "__main__":
    for name, spoil in SPOILERS.items():
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch) / "spoiled"
            shutil.copytree(sys.argv[1], folder)
            spoil(folder)
            try:
                check(folder)
            except AssertionError as error:
                print(f"{name}: {error}")
            else:
                sys.exit(f"{name} passed")
