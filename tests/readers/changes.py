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
    """Depths and standard deviations of a run, NaN where nothing is known, which cells were measured, and where they lie."""
    with rasterio.open(run / "depth/depth.tif") as raster:
        depth, transform, crs = raster.read(1, masked=True).filled(numpy.nan), raster.transform, raster.crs
    with rasterio.open(run / "depth/uncertainty.tif") as raster:
        sigma = raster.read(1, masked=True).filled(numpy.nan)
    with rasterio.open(run / "depth/source.tif") as raster:
        measured = raster.read(1) > 1
    return depth.astype(float), sigma.astype(float), measured, transform, crs


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
    """Rise and level of detection on the cells of the newer map, which either measured, and the square metres of one."""
    new_depth, new_sigma, new_measured, transform, crs = layers(newer)
    old_depth, old_sigma, old_measured, old_transform, old_crs = layers(older)
    rows, columns = numpy.indices(new_depth.shape)
    places = transform * (columns + 0.5, rows + 0.5)
    if crs != old_crs:
        places = pyproj.Transformer.from_crs(crs, old_crs, always_xy=True).transform(*places)
    there = [numpy.round(one - 0.5, 6) for one in ~old_transform * places]
    rise = at(old_depth, there[1], there[0]) - new_depth
    sigma = numpy.hypot(new_sigma, at(old_sigma, there[1], there[0]))
    known = numpy.isfinite(rise)
    measured = known & new_measured, known & (at(old_measured.astype(float), there[1], there[0]) > 0)
    corners = [transform * (new_depth.shape[1] / 2 + dx, new_depth.shape[0] / 2 + dy) for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1))]
    lon, lat = pyproj.Transformer.from_crs(crs, 4326, always_xy=True).transform(*numpy.array(corners).T)
    area, _ = pyproj.Geod(ellps="WGS84").polygon_area_perimeter(lon, lat)
    return rise, 1.96 * numpy.hypot(sigma, systematic), measured, abs(area)


def places(rise, level, measured, cell_m2, systematic, range_m):
    """The cells of each place that changed, its sign, and the standard deviation of the rise of each for what is drawn between measured cells."""
    known, cell = numpy.isfinite(rise), math.sqrt(cell_m2)
    side = 2 * min(10, max(1, round(1 / cell))) + 1
    counts = scipy.ndimage.uniform_filter(known.astype(float), side, mode="constant")
    ratio = numpy.where(known, 1.96 * numpy.nan_to_num(rise / level), 0)
    smooth = scipy.ndimage.uniform_filter(ratio, side, mode="constant") / numpy.maximum(counts, 1e-9)
    detected = known & (numpy.abs(numpy.nan_to_num(rise)) > numpy.nan_to_num(level))
    quiet = smooth[known & ~detected]
    # Stands out of the offset of the undetected cells by more than the depths' own errors.
    own = numpy.sqrt(numpy.maximum(numpy.nan_to_num(level) ** 2 - (1.96 * systematic) ** 2, 0))
    seeds = detected & (numpy.abs(numpy.nan_to_num(rise) - numpy.median(rise[known & ~detected])) > own)
    middle = numpy.median(quiet)
    noise = 1.4826 * numpy.median(numpy.abs(quiet - middle))
    away = cell * numpy.maximum(*[scipy.ndimage.distance_transform_edt(~one) for one in measured])
    offset = numpy.median(rise[known & ~detected])
    together = max(math.pi * range_m**2 / 5, cell_m2)
    largest = max(1.96, math.sqrt(2 * math.log(max(1, known.sum() * cell_m2 / together) / 0.05)))
    found = []
    for sign in (1, -1):
        above = known & (sign * (smooth - middle) > 1.5 * noise)
        labels, _ = scipy.ndimage.label(above)
        for label in numpy.unique(labels[above & seeds & (sign * numpy.nan_to_num(rise) > 0)]):
            cells = labels == label
            # Its detected cells stand out of the largest of the independent errors, and are no few wrong depths.
            sure = cells & detected
            area = sure.sum() * cell_m2
            random = math.sqrt(area * cell_m2 * ((own[sure] / 1.96) ** 2).sum() * min(1, together / max(area, 1e-9)))
            volume = abs((rise[sure] - offset).sum()) * cell_m2
            if sure.sum() < 4 or area < 2 or volume <= largest * random:
                continue
            rows, columns = numpy.nonzero(cells & (measured[0] | measured[1]))
            weights = rise[rows, columns] ** 2
            moment = 0
            if weights.sum() > 0:
                moment = sum(numpy.cov(one, aweights=weights, bias=True) for one in (rows, columns)) if len(rows) > 1 else 0
            width = 2 * cell_m2 * max(moment, 0.5)
            between = numpy.abs(rise[cells]) * (1 - numpy.exp(-0.5 * away[cells] ** 2 / width))
            found.append((sign, cells, between))
    return found


def check(newer, older, folder):
    record = json.loads((folder / "change.json").read_text())
    rise, level, measured, cell_m2 = expected(newer, older, record["systematic_m"])
    written = {}
    for name in ("difference", "detection_level", "uncertainty"):
        with rasterio.open(folder / f"{name}.tif") as raster:
            assert raster.dtypes == ("float32",) and raster.units == ("metre",)
            written[name] = raster.read(1, masked=True).filled(numpy.nan)
        renderer = lxml.etree.parse(folder / f"{name}.qml").find(".//rasterrenderer")
        stops = [float(item.get("value")) for item in renderer.iter("item")]
        assert stops == sorted(stops) and (name != "difference" or abs(stops[0] + stops[-1]) < 1e-9)
    both = numpy.isfinite(rise)
    assert (numpy.isfinite(written["difference"]) == both).all(), "cells that only one of the two knows"
    off = numpy.abs(written["difference"] - rise)[both].max()
    assert off < 1e-4, f"difference is off by {off} m"
    # What both maps err alike is not in their difference: of the stated errors a share is, which quiet cells show by groups.
    stated = numpy.sqrt((level / 1.96) ** 2 - record["systematic_m"] ** 2)[both]
    shown = numpy.sqrt(numpy.maximum((written["detection_level"] / 1.96) ** 2 - record["systematic_m"] ** 2, 0))[both]
    assert (shown <= stated * (1 + 1e-4) + 1e-4).all(), "an error is larger than both maps state"
    share = numpy.median(shown / stated)
    assert abs(share - record["error_share"]) < 0.01, f"error_share is {share}, not {record['error_share']}"
    level = numpy.where(both, written["detection_level"], level)
    # Its distances are by steps to neighbouring cells, at most 8 % too long.
    regions = places(rise, level, measured, cell_m2, record["systematic_m"], record["error_range_m"])
    inside = {part: [one for one in regions if one[0] in signs] for part, signs in (("fill", (1,)), ("cut", (-1,)), ("net", (1, -1)))}
    for part in ("fill", "cut", "net", "all"):
        own = inside.get(part, regions)
        cells = both if part == "all" else numpy.logical_or.reduce([one[1] for one in own] + [numpy.zeros_like(both)])
        said, area = record[part], cells.sum() * cell_m2
        between = math.sqrt(sum((cell_m2 * one[2].sum()) ** 2 for one in own))
        assert abs(said["between_sigma_m3"] - between) < 0.15 * between + 0.1, f"{part}: between {between}, not {said['between_sigma_m3']}"
        assert part == "all" or said["places"] == len(own), f"{part}: {len(own)} places"
        volume = rise[cells].sum() * cell_m2
        # A cell whose change is as large as its level may fall on either side.
        assert abs(said["cells"] - cells.sum()) <= 2, f"{part}: {cells.sum()} cells, not {said['cells']}"
        assert abs(said["area_m2"] - area) < 1e-3 * area + 1, f"{part}: {area} m2, not {said['area_m2']}"
        assert abs(said["volume_m3"] - volume) < 1e-3 * abs(volume) + 0.1, f"{part}: {volume} m3, not {said['volume_m3']}"
        variance = ((level[cells] / 1.96) ** 2 - record["systematic_m"] ** 2).mean() if cells.any() else 0
        averaged = min(1, math.pi * record["error_range_m"] ** 2 / (5 * max(area, 1e-9)))
        within = 1.96 * math.hypot(area * math.sqrt(variance * averaged + record["systematic_m"] ** 2), said["between_sigma_m3"])
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
    fill, truth_m3 = found["fill"], float(truth_m3)
    assert abs(fill["volume_m3"] - truth_m3) < fill["within_95_m3"], f"{fill['volume_m3']} +- {fill['within_95_m3']} m3 of {truth_m3}"
    assert found["detection_level_m"] < float(height_m)
    assert abs(found["all"]["volume_m3"] - float(truth_m3)) < 0.1 * float(truth_m3), f"{found['all']}"
    print(
        f"rasters and volumes agree with numpy; fill {fill['volume_m3']:.1f} +- {fill['within_95_m3']:.1f} m3 "
        f"of a mound of {truth_m3} m3, cut {found['cut']['volume_m3']:.2f} m3"
    )
