"""survey.gpkg by SQLite itself, its R-trees too, and by GDAL (pyogrio), against the GeoJSON files; spot soundings and shoals against cloud.csv."""

import contextlib
import sqlite3

import geopandas
import numpy
import pyogrio
import shapely
from common import check_count, check_extent, into, system
from lxml import etree

# Layers and the files that hold the same.
SAME = {
    "depth_areas": "isobaths/depth_areas.geojson",
    "isobaths": "isobaths/isobaths.geojson",
    "spot_soundings": "isobaths/spot_soundings.geojson",
    "footprint": "track/footprint.geojson",
    "track": "track/track.geojson",
    "targets": "objects/detections.geojson",
}


def check(folder, made, points):
    if "survey.gpkg" in made:
        check_package(folder, made["survey.gpkg"])
    if "spot_soundings.geojson" in made:
        check_soundings(folder / SAME["spot_soundings"], made, points)
    if "depth_areas.geojson" in made and made["depth_areas.geojson"]["settings"]["isobaths"]["shoal_safe"]:
        check_shoals(folder / SAME["depth_areas"], made, points)


def check_package(folder, record):
    path = folder / "survey.gpkg"
    with contextlib.closing(sqlite3.connect(path)) as database:
        assert database.execute("pragma integrity_check").fetchall() == [("ok",)]
        assert database.execute("pragma foreign_key_check").fetchall() == []
        tables = [name for (name,) in database.execute("select table_name from gpkg_contents where data_type = 'features'")]
        for name in tables:
            assert database.execute(f"select rtreecheck('rtree_{name}_geom')").fetchone() == ("ok",), f"the R-tree of {name}"
            counts = [database.execute(f"select count(*) from {table}").fetchone() for table in (name, f"rtree_{name}_geom")]
            assert counts[0] == counts[1], f"the R-tree of {name} has {counts[1]} features, not {counts[0]}"
        styles = database.execute("select f_table_name, styleQML from layer_styles where useAsDefault").fetchall()
    layers = [name for name, kind in pyogrio.list_layers(path) if kind]
    assert sorted(name for name, _ in styles) == sorted(layers), "a layer without a style"
    for name, style in styles:
        assert etree.fromstring(style.encode()).find("renderer-v2") is not None, f"the style of {name} draws nothing"
    read = {name: geopandas.read_file(path, layer=name) for name in layers}
    check_count("survey.gpkg", record, "features", sum(len(layer) for layer in read.values()))
    bounds = numpy.array([layer.total_bounds for layer in read.values() if len(layer)])
    check_extent("survey.gpkg", record, bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0), 0.001)
    for name, file in SAME.items():
        if (folder / file).is_file():
            check_layer(name, read[name], folder / file, record)


def check_layer(name, layer, file, record):
    """A layer has the features of a GeoJSON, in its order."""
    other = geopandas.read_file(file)
    assert len(layer) == len(other), f"{name}: {len(layer)} features, not {len(other)}"
    if not len(layer):
        return
    assert layer.crs.to_epsg() == record["crs"]["epsg"] and layer.geometry.is_valid.all(), name
    metres = other.estimate_utm_crs()
    here, there = layer.to_crs(metres).geometry, other.to_crs(metres).geometry
    farthest_m = max(off_m(one, other) for one, other in zip(here, there))
    # Both are rounded to a millimetre.
    assert farthest_m < 0.004, f"{name} is {farthest_m} m off"
    for column in set(layer.columns) & set(other.columns) - {"geometry"}:
        here, there = layer[column], other[column]
        if here.dtype.kind in "fiu":
            assert numpy.allclose(here, there.astype(float), atol=0.002, equal_nan=True), f"{name}: {column}"
        elif here.dtype.kind == "b":
            assert (here == there.astype(bool)).all(), f"{name}: {column}"


def off_m(here, there):
    """How far two geometries lie apart: lines and points at most, areas on average along their edges, for a part that is thinner than what
    both are rounded to may have gone from one of them."""
    if here.geom_type in ("Polygon", "MultiPolygon"):
        return shapely.area(shapely.symmetric_difference(here, shapely.make_valid(there))) / shapely.length(here)
    return shapely.hausdorff_distance(here, there)


def depths(points, record):
    """Places in metres and depths of the kept points."""
    return into(record, points.lon, points.lat), -points.z


def check_soundings(file, made, points):
    """They are depths of the cloud, none is near another, and around every recorded depth there is one that is as shallow."""
    layer = geopandas.read_file(file)
    check_count("spot_soundings.geojson", made["spot_soundings.geojson"], "points", len(layer))
    record = {"crs": {"epsg": layer.estimate_utm_crs().to_epsg()}}
    places, depth_m = depths(points, record)
    spots = into(record, layer.geometry.x, layer.geometry.y)
    apart = numpy.hypot(*(spots[:, None] - spots[None]).transpose(2, 0, 1))
    least = apart[~numpy.eye(len(spots), dtype=bool)].min()
    radius = made["spot_soundings.geojson"]["settings"]["isobaths"].get("spot_radius_m")
    assert least >= (radius or 0) - 0.004, f"two spot soundings are {least} m apart"
    for spot, shown in zip(spots, layer.depth_m):
        near = numpy.hypot(*(places - spot).T) < 0.01
        assert numpy.abs(depth_m[near] - shown).min() < 0.002, f"no depth of {shown} m at {spot}"
    recorded = points.source == 0
    for place, depth in zip(places[recorded], depth_m[recorded]):
        near = numpy.hypot(*(spots - place).T) < least + 0.01
        assert (layer.depth_m[near] <= depth + 0.002).any(), f"no spot sounding stands for {depth} m at {place}"
    assert layer.depth_m.is_monotonic_increasing
    unit_m = {"m": 1.0, "ft": 0.3048, "fm": 1.8288}[layer.unit[0]]
    below = layer.depth_m / unit_m - layer.label.astype(float)
    assert (below > -1e-3).all() and (below < 1.0).all(), "a figure is deeper than its depth"


def check_shoals(file, made, points):
    """No kept depth that is shallower than an area lies within it."""
    areas = geopandas.read_file(file)
    metres = areas.estimate_utm_crs()
    places, depth_m = depths(points, {"crs": {"epsg": metres.to_epsg()}})
    for shape, from_m in zip(areas.to_crs(metres).geometry, areas.from_m):
        shoaler = places[depth_m < from_m - 0.001]
        inside = shapely.contains_xy(shape.buffer(-0.01), *shoaler.T)
        assert not inside.any(), f"{inside.sum()} depths lie in an area from {from_m} m on, and are shallower"
