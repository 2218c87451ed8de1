#!/usr/bin/env python3
"""What `bathyscope compare NEWER OLDER --change DIR` writes, worked out again with GDAL and numpy from the depth maps of two runs."""

import json
import math
import sys
from pathlib import Path

import lxml.etree
import numpy
import pyproj
import rasterio
import scipy.ndimage


def layers(run):
    """Depths and standard deviations of a run, NaN where nothing is known, and where they lie."""
    with rasterio.open(run / "depth/depth.tif") as raster:
        depth, transform, crs = raster.read(1, masked=True).filled(numpy.nan), raster.transform, raster.crs
    with rasterio.open(run / "depth/uncertainty.tif") as raster:
        sigma = raster.read(1, masked=True).filled(numpy.nan)
    return depth.astype(float), sigma.astype(float), transform, crs


def at(values, rows, columns):
    """Bilinear between the middles of cells; the outermost ones reach to the edge."""
    inside = (rows > -0.5) & (columns > -0.5) & (rows < values.shape[0] - 0.5) & (columns < values.shape[1] - 0.5)
    there = [rows.ravel(), columns.ravel()]
    found, unknown = [
        scipy.ndimage.map_coordinates(one, there, order=1, mode="nearest").reshape(rows.shape)
        for one in (numpy.nan_to_num(values), numpy.isnan(values).astype(float))
    ]
    inside &= unknown < 1e-9
    return numpy.where(inside, found, numpy.nan)


def expected(newer, older, systematic):
    """Rise and level of detection on the cells of the newer map, and the square metres of one."""
    new_depth, new_sigma, transform, crs = layers(newer)
    old_depth, old_sigma, old_transform, old_crs = layers(older)
    rows, columns = numpy.indices(new_depth.shape)
    places = transform * (columns + 0.5, rows + 0.5)
    if crs != old_crs:
        places = pyproj.Transformer.from_crs(crs, old_crs, always_xy=True).transform(*places)
    there = [numpy.round(one - 0.5, 6) for one in ~old_transform * places]
    rise = at(old_depth, there[1], there[0]) - new_depth
    sigma = numpy.hypot(new_sigma, at(old_sigma, there[1], there[0]))
    corners = [transform * (new_depth.shape[1] / 2 + dx, new_depth.shape[0] / 2 + dy) for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1))]
    lon, lat = pyproj.Transformer.from_crs(crs, 4326, always_xy=True).transform(*numpy.array(corners).T)
    area, _ = pyproj.Geod(ellps="WGS84").polygon_area_perimeter(lon, lat)
    return rise, 1.96 * numpy.hypot(sigma, systematic), abs(area)


def check(newer, older, folder):
    record = json.loads((folder / "change.json").read_text())
    rise, level, cell_m2 = expected(newer, older, record["systematic_m"])
    written = {}
    for name in ("difference", "detection_level"):
        with rasterio.open(folder / f"{name}.tif") as raster:
            assert raster.dtypes == ("float32",) and raster.units == ("metre",)
            written[name] = raster.read(1, masked=True).filled(numpy.nan)
        renderer = lxml.etree.parse(folder / f"{name}.qml").find(".//rasterrenderer")
        stops = [float(item.get("value")) for item in renderer.iter("item")]
        assert stops == sorted(stops) and (name != "difference" or abs(stops[0] + stops[-1]) < 1e-9)
    both = numpy.isfinite(rise)
    assert (numpy.isfinite(written["difference"]) == both).all(), "cells that only one of the two knows"
    for name, own in (("difference", rise), ("detection_level", level)):
        off = numpy.abs(written[name] - own)[both].max()
        assert off < 1e-4, f"{name} is off by {off} m"
    detected = both & (numpy.abs(rise) > level)
    for part, cells in (("fill", detected & (rise > 0)), ("cut", detected & (rise < 0)), ("net", detected), ("all", both)):
        said, area = record[part], cells.sum() * cell_m2
        volume = rise[cells].sum() * cell_m2
        # A cell whose change is as large as its level may fall on either side.
        assert abs(said["cells"] - cells.sum()) <= 2, f"{part}: {cells.sum()} cells, not {said['cells']}"
        assert abs(said["area_m2"] - area) < 1e-3 * area + 1, f"{part}: {area} m2, not {said['area_m2']}"
        assert abs(said["volume_m3"] - volume) < 1e-3 * abs(volume) + 0.1, f"{part}: {volume} m3, not {said['volume_m3']}"
        variance = ((level[cells] / 1.96) ** 2 - record["systematic_m"] ** 2).mean() if cells.any() else 0
        averaged = min(1, math.pi * record["error_range_m"] ** 2 / (5 * max(area, 1e-9)))
        within = 1.96 * area * math.sqrt(variance * averaged + record["systematic_m"] ** 2)
        assert abs(said["within_95_m3"] - within) < 0.01 * within + 0.1, f"{part}: within {within}, not {said['within_95_m3']}"
    median = numpy.median(rise[both])
    assert abs(record["median_m"] - median) < 0.002, f"median {median}"
    page = (folder / "change.html").read_text()
    lxml.etree.fromstring(page, lxml.etree.HTMLParser())
    assert f"{record['fill']['volume_m3']:+.2f} m3" in page and "http" not in page
    return record


if __name__ == "__main__":
    newer, older, folder, truth_m3, height_m = sys.argv[1:]
    found = check(Path(newer), Path(older), Path(folder))
    # Of a Gaussian mound, what lies where it is higher than the level of detection.
    fill, expected_m3 = found["fill"], float(truth_m3) * (1 - found["detection_level_m"] / float(height_m))
    assert abs(fill["volume_m3"] - expected_m3) < 0.05 * expected_m3, f"{fill['volume_m3']} m3 of {expected_m3}"
    assert abs(found["all"]["volume_m3"] - float(truth_m3)) < 0.1 * float(truth_m3), f"{found['all']}"
    print(
        f"rasters and volumes agree with numpy; fill {fill['volume_m3']:.1f} +- {fill['within_95_m3']:.1f} m3 where {expected_m3:.1f} m3 can be detected "
        f"of a mound of {truth_m3} m3, cut {found['cut']['volume_m3']:.2f} m3"
    )
