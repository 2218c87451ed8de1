#!/usr/bin/env python3
"""Opens an archive of many logs with readers that are not ours: DuckDB, Arrow and GeoPandas for its rows, GDAL for its maps and mosaics and their VRTs, pystac
for its index; fails on the first that disagrees."""

import csv
import json
import sys
from pathlib import Path

import duckdb
import geopandas
import numpy
import pyarrow.parquet
import pyproj
import pystac
import pystac.validation
import rasterio
import shapely
import tiles
from rasters import check_cloud_optimized

TILE_M = 512


def system(tile):
    """The zone of a tile, and its south-west corner."""
    zone, easting, northing = tile.split("_")
    epsg = (32600 if zone[-1] == "N" else 32700) + int(zone[:-1])
    return epsg, int(easting), int(northing)


def check_rows(folder, logs):
    """Every file of rows against the records of the logs; how many there are."""
    halo_m = json.loads((folder / "lake.json").read_text())["halo_m"]
    named = {file["file"]: (log, rows) for log in logs for rows in log["tiles"] for file in rows["files"]}
    kinds = {"points": "parquet", "pings": "parquet", "mosaic": "tif", "mosaic_weights": "tif"}
    there = {str(path.relative_to(folder)) for kind, ending in kinds.items() for path in folder.glob(f"{kind}/*/*.{ending}")}
    assert there == set(named), f"records and folder differ in {there ^ set(named)}"
    for log, rows in named.values():
        has_part = any(file["file"].startswith("mosaic/") for file in rows["files"])
        assert has_part == (rows["mosaic_cells"] > 0), f"{rows['tile']}: {rows['mosaic_cells']} cells of a mosaic"
    for name, (log, rows) in named.items():
        kind = name.split("/")[0]
        if kinds[kind] == "tif":
            check_part(folder / name, rows)
            continue
        metadata = pyarrow.parquet.read_metadata(folder / name)
        assert metadata.num_rows == rows[kind], f"{name}: {metadata.num_rows} rows, not {rows[kind]}"
        assert metadata.created_by == "bathyscope"
        frame = geopandas.read_parquet(folder / name)
        assert frame.crs.to_string() == "OGC:CRS84" and (frame.geometry.geom_type == "Point").all()
        assert (frame["log"] == log["log"]).all() and name.endswith(f"/{log['log']}.parquet")
        epsg, west, south = system(rows["tile"])
        zone = pyproj.Transformer.from_crs(4326, epsg, always_xy=True)
        places = numpy.array(zone.transform(frame.geometry.x.to_numpy(), frame.geometry.y.to_numpy()))
        off_m = numpy.abs(places - [frame.x, frame.y]).max()
        assert off_m < 1e-6, f"{name}: places are off by {off_m} m"
        core = frame.x.between(west, west + TILE_M, "left") & frame.y.between(south, south + TILE_M, "left")
        assert (core != frame.halo).all(), f"{name}: the halo is marked otherwise"
        if kind == "points":
            near = frame.x.between(west - halo_m, west + TILE_M + halo_m) & frame.y.between(south - halo_m, south + TILE_M + halo_m)
            assert near.all() and core.sum() == rows["core_points"]
            assert (frame.weight[~frame.kept] == 0).all() and (frame.kept == (frame["class"] == 40)).all()
        else:
            assert frame.ping.is_monotonic_increasing and (frame.altitude_m >= 0).all()
            length = numpy.hypot(frame.starboard_x, frame.starboard_y)
            assert (numpy.abs(length - 1) < 0.001).all(), f"{name}: starboard is no direction"
    return len(named)


def check_part(path, rows):
    """A log's part of the mosaic of a tile, on the cells of the tile."""
    epsg, west, south = system(rows["tile"])
    check_cloud_optimized(path.name, path)
    with rasterio.open(path) as raster:
        assert raster.crs.to_epsg() == epsg
        assert numpy.allclose(raster.bounds, (west, south, west + TILE_M, south + TILE_M), atol=1e-6), raster.bounds
        count = raster.read(1, masked=True).count()
    assert count == rows["mosaic_cells"], f"{path}: {count} cells, not {rows['mosaic_cells']}"


def check_mosaic(folder, tile, logs, record):
    """The mosaic of a tile: what any log shows there, in the levels of one of them, and the VRT shows the same."""
    epsg, west, south = system(tile)
    path = folder / f"tiles/{tile}/mosaic.tif"
    assert path.is_file() == (record["mosaic_cells"] > 0), path
    if not path.is_file():
        return
    check_cloud_optimized("mosaic.tif", path)
    with rasterio.open(path) as raster:
        assert raster.crs.to_epsg() == epsg and raster.dtypes == ("uint8",) and raster.descriptions == ("echo level",)
        assert numpy.allclose(raster.bounds, (west, south, west + TILE_M, south + TILE_M), atol=1e-6), raster.bounds
        levels, mask = raster.read(1), raster.dataset_mask()
    assert ((mask > 0) == (levels > 0)).all() and (mask > 0).sum() == record["mosaic_cells"]
    # By the rule of the usual setting: the later log over the earlier.
    parts = [log for log in logs if any(rows["tile"] == tile and rows["mosaic_cells"] for rows in log["tiles"])]
    parts.sort(key=lambda log: (float("-inf") if log["start_unix_s"] is None else log["start_unix_s"], log["log"]))
    with open(folder / "offsets.csv") as table:
        factors = {row["log"]: numpy.float32(row["level_factor"]) for row in csv.DictReader(table)}
    expected = numpy.zeros_like(levels)
    for log in parts:
        with rasterio.open(folder / f"mosaic/tile={tile}/{log['log']}.tif") as part:
            of_log = part.read(1)
        brightened = numpy.floor(of_log * factors[log["log"]] + numpy.float32(0.5)).clip(1, 255)
        of_log = numpy.where(of_log > 0, brightened, 0).astype("uint8")
        expected = numpy.where(of_log > 0, of_log, expected)
    assert (levels == expected).all(), f"{tile}: the mosaic is not that of its logs"
    with rasterio.open(folder / f"index/mosaic_{tile.split('_')[0]}.vrt") as whole:
        window = rasterio.windows.from_bounds(west, south, west + TILE_M, south + TILE_M, whole.transform)
        window = window.round_offsets().round_lengths()
        assert numpy.array_equal(whole.read(1, window=window), levels), f"{tile}: the VRT shows another mosaic"


def check_partitions(folder, logs):
    """The partitions as DuckDB reads them."""
    rows = f"read_parquet('{folder}/points/*/*.parquet', hive_partitioning = true)"
    counted = duckdb.sql(f"select tile, count(*), count(distinct log) from {rows} group by tile").fetchall()
    expected = {}
    for log in logs:
        for tile in log["tiles"]:
            if tile["points"]:
                points, count = expected.get(tile["tile"], (0, 0))
                expected[tile["tile"]] = (points + tile["points"], count + 1)
    assert {tile: (points, count) for tile, points, count in counted} == expected
    cores = duckdb.sql(f"select count(*) from {rows} where not halo").fetchall()[0][0]
    assert cores == sum(log["points"] for log in logs), "points outside of halos"


def check_maps(folder, logs):
    """Maps and mosaics against their records and the VRTs; which tiles have any."""
    mapped = set()
    for path in sorted(folder.glob("tiles/*/tile.json")):
        record, tile = json.loads(path.read_text()), path.parent.name
        if not record["files"]:
            continue
        mapped.add(tile)
        check_mosaic(folder, tile, logs, record)
        if not record["cells"]:
            continue
        epsg, west, south = system(tile)
        for name in ("depth.tif", "uncertainty.tif"):
            check_cloud_optimized(name, path.parent / name)
        with rasterio.open(path.parent / "depth.tif") as raster:
            assert raster.crs.to_epsg() == epsg
            assert tuple(raster.bounds) == (west, south, west + TILE_M, south + TILE_M), raster.bounds
            depth = raster.read(1, masked=True)
        assert depth.count() == record["cells"]
        assert abs(depth.min() - record["depth_m"][0]) < 1e-6 and abs(depth.max() - record["depth_m"][1]) < 1e-6
        rows, columns = numpy.nonzero(~numpy.ma.getmaskarray(depth))
        cell_m, north = TILE_M / depth.shape[0], south + TILE_M
        edges = [west + columns.min() * cell_m, north - (rows.max() + 1) * cell_m, west + (columns.max() + 1) * cell_m, north - rows.min() * cell_m]
        assert numpy.allclose(edges, record["bounds_m"], atol=1e-6, rtol=0.0), f"{tile}: depths lie within {edges}"
        zone = tile.split("_")[0]
        with rasterio.open(folder / f"index/depth_{zone}.vrt") as whole:
            window = rasterio.windows.from_bounds(west, south, west + TILE_M, south + TILE_M, whole.transform)
            assert numpy.ma.allequal(whole.read(1, masked=True, window=window), depth), f"{tile}: the VRT shows another map"
        check_isobaths(path.parent / "isobaths.geojson", epsg, (west, south), record["isobaths"])
    return mapped


def check_isobaths(path, epsg, corner, count):
    """Lines lie in their tile; GeoPandas reads an empty collection as none."""
    features = json.loads(path.read_text())["features"]
    assert len(features) == count, f"{len(features)} isobaths, not {count}"
    if features:
        lines = geopandas.read_file(path).to_crs(epsg)
        tile = shapely.box(*corner, *(metres + TILE_M for metres in corner)).buffer(0.002)
        assert lines.within(tile).all(), f"{path}: a line leaves its tile"


def check_index(folder):
    """The collection and its items, compared with the core schemas, which come with pystac; those of extensions need the network."""
    for path in folder.glob("index/*.json"):
        pystac.validation.validate_dict(json.loads(path.read_text()) | {"stac_extensions": []})
    collection = pystac.Collection.from_file(str(folder / "index/collection.json"))
    items = list(collection.get_items())
    for item in items:
        for asset in item.assets.values():
            assert Path(asset.get_absolute_href()).is_file(), asset.href
        assert item.datetime is None and item.common_metadata.start_datetime <= item.common_metadata.end_datetime
        assert shapely.geometry.shape(item.geometry).is_valid
    return {item.id for item in items}


def check(folder):
    logs = [json.loads(path.read_text()) for path in sorted(folder.glob("logs/*.json"))]
    files = check_rows(folder, logs)
    check_partitions(folder, logs)
    maps = check_maps(folder, logs)
    items = check_index(folder)
    # An item must have a time, which some recorders do not know.
    timed = {rows["tile"] for log in logs for rows in log["tiles"] if rows["unix_s"]}
    assert maps and items == maps & timed, f"maps of {sorted(maps)}, items of {sorted(items)}"
    pictures, pixels = tiles.check_archive(folder)
    print(
        f"{files} files of rows of {len(logs)} logs, {len(maps)} maps and their index agree with the records, "
        f"{pixels} pixels of {pictures} map tiles with the maps"
    )


if __name__ == "__main__":
    check(Path(sys.argv[1]))
