#!/usr/bin/env python3
"""The checks must be able to fail: each spoils a copy of a folder that passes in one small way."""

import contextlib
import hashlib
import io
import json
import shutil
import sqlite3
import struct
import sys
import tempfile
from pathlib import Path

import archive
import numpy
import rasterio
import tiles
from check import check
from PIL import Image


def edit(name, change):
    """Changes a JSON file."""

    def spoil(folder):
        content = json.loads((folder / name).read_text())
        change(content)
        (folder / name).write_text(json.dumps(content))

    return spoil


def edit_entry(name, change):
    """Changes what the manifest says of a file."""

    def change_in(manifest):
        (entry,) = [file for file in manifest["files"] if file["file"] == name]
        change(entry)

    return edit("manifest.json", change_in)


def hashed(spoil, *names):
    """Spoils files and gives the manifest their hashes, so that the readers have to find what is wrong."""

    def spoil_and_hash(folder):
        spoil(folder)
        for name in names:
            content = (folder / name).read_bytes()
            said = {"sha256": hashlib.sha256(content).hexdigest(), "bytes": len(content)}
            edit_entry(name, lambda entry: entry.update(said))(folder)

    return spoil_and_hash


def shift_a_point(folder):
    """Moves the last point of cloud.csv by a centimetre."""
    lines = (folder / "points/cloud.csv").read_text().splitlines()
    fields = lines[-1].split(",")
    fields[3] = f"{float(fields[3]) + 1e-7:.9f}"
    (folder / "points/cloud.csv").write_text("\n".join([*lines[:-1], ",".join(fields)]) + "\n")


def deepen(folder):
    """Takes the depth map 10 cm down, its record too."""
    with rasterio.open(folder / "depth/depth.tif", "r+") as raster:
        values = raster.read(1)
        values[values != raster.nodata] += 0.1
        raster.write(values, 1)
    edit_entry("depth/depth.tif", lambda record: record["values"].update({key: record["values"][key] + 0.1 for key in ("least", "most")}))(folder)


def append_overviews(folder):
    """Has GDAL make the overviews again, at the end of the file."""
    with rasterio.Env(GDAL_DISABLE_READDIR_ON_OPEN=True, IGNORE_COG_LAYOUT_BREAK="YES"):
        with rasterio.open(folder / "mosaic/mosaic.tif", "r+") as raster:
            raster.build_overviews([2, 4, 8], rasterio.enums.Resampling.nearest)


def darken(folder):
    """Takes a level off a cell of the mosaic, its statistics left as they are."""
    with rasterio.Env(IGNORE_COG_LAYOUT_BREAK="YES"), rasterio.open(folder / "mosaic/mosaic.tif", "r+") as raster:
        values = raster.read(1)
        values[values > 100] -= 1
        raster.write(values, 1)


def raise_a_corner(folder):
    """Takes the first corner of the bottom up by a centimetre."""
    path = folder / "depth/bottom.glb"
    content = bytearray(path.read_bytes())
    at = 20 + int.from_bytes(content[12:16], "little") + 8 + 4
    (up,) = struct.unpack_from("<f", content, at)
    struct.pack_into("<f", content, at, up + 0.01)
    path.write_bytes(content)


def other_zone(folder):
    path = folder / "isobaths/isobaths.prj"
    path.write_text(path.read_text().replace("-81", "-87"))


def move_a_tile(folder):
    """Gives a tile of the database the place of its neighbour's neighbour."""
    with sqlite3.connect(folder / "map_tiles/depth.mbtiles") as base:
        base.execute("update tiles set tile_column = tile_column + 9 where rowid = (select max(rowid) from tiles)")


def other_zoom(folder):
    """Says of an archive that it reaches one zoom farther."""
    path = folder / "map_tiles/depth.pmtiles"
    content = bytearray(path.read_bytes())
    content[101] += 1
    path.write_bytes(content)


def flatten_tiles(folder):
    """Shows the depths a metre deeper in all tiles: the second colour is metres."""
    path = folder / "map_tiles/depth_values.pmtiles"
    _, _, found = tiles.open_pmtiles(path)
    content = path.read_bytes()
    for picture in found.values():
        values = tiles.rgba(picture).astype("uint8")
        values[..., 1][values[..., 3] > 0] -= 1
        packed = io.BytesIO()
        Image.fromarray(values).save(packed, "PNG", optimize=True, compress_level=9)
        packed = packed.getvalue()
        if len(packed) <= len(picture):
            content = content.replace(picture, packed + bytes(len(picture) - len(packed)))
    path.write_bytes(content)


def in_package(statement):
    """Changes survey.gpkg."""

    def spoil(folder):
        with contextlib.closing(sqlite3.connect(folder / "survey.gpkg")) as database, database:
            database.execute(statement)

    return hashed(spoil, "survey.gpkg")


def move_a_node(folder):
    """Has the first node of the octree begin a byte later; its table is the first record behind the points."""
    path = folder / "points/cloud.copc.laz"
    content = bytearray(path.read_bytes())
    at = struct.unpack_from("<Q", content, 235)[0] + 60 + 16
    struct.pack_into("<Q", content, at, struct.unpack_from("<Q", content, at)[0] + 1)
    path.write_bytes(content)


SPOILERS = {
    "a tile at another place": hashed(move_a_tile, "map_tiles/depth.mbtiles"),
    "a zoom that the archive does not have": hashed(other_zoom, "map_tiles/depth.pmtiles"),
    "tiles that are a metre deeper": hashed(flatten_tiles, "map_tiles/depth_values.pmtiles"),
    "a line too few in the package": in_package("delete from isobaths where fid = 1"),
    "a box of the R-tree at another place": in_package("update rtree_isobaths_geom_rowid set nodeno = 7 where rowid = 1"),
    "a layer without a style": in_package("delete from layer_styles where f_table_name = 'track'"),
    "a spot sounding that is shallower than the depth": hashed(
        edit("isobaths/spot_soundings.geojson", lambda spots: spots["features"][0]["properties"].update(depth_m=0.5)),
        "isobaths/spot_soundings.geojson",
    ),
    "a node of the octree at another place": hashed(move_a_node, "points/cloud.copc.laz"),
    "a wrong count": edit_entry("points/cloud.copc.laz", lambda record: record["count"].update(points=1)),
    "a wrong system": edit_entry("mosaic/mosaic.tif", lambda record: record["crs"].update(epsg=32616)),
    "a wrong extent": edit_entry("isobaths/isobaths.shp", lambda record: record["extent"].update(west=0.0)),
    "a wrong hash": lambda folder: (folder / "report.html").write_bytes(b"<p>"),
    "a file that the manifest does not name": lambda folder: (folder / "track/more.kmz").write_bytes(b""),
    "a file that is not there": lambda folder: (folder / "track/track.kmz").unlink(),
    "a point moved by a centimetre": hashed(shift_a_point, "points/cloud.csv"),
    "a map 10 cm too deep": hashed(deepen, "depth/depth.tif"),
    "a mosaic that is darker than it says": hashed(darken, "mosaic/mosaic.tif"),
    "overviews at the end of the file": hashed(append_overviews, "mosaic/mosaic.tif"),
    "a corner of the bottom a centimetre too high": hashed(raise_a_corner, "depth/bottom.glb"),
    "another zone": hashed(other_zone, "isobaths/isobaths.prj"),
    "a line too few": hashed(edit("track/track.geojson", lambda lines: lines["features"].pop()), "track/track.geojson"),
    "an isobath of another depth": hashed(
        edit("isobaths/isobaths.geojson", lambda lines: lines["features"][0]["properties"].update(depth_m=1.9)),
        "isobaths/isobaths.geojson",
    ),
    "a band that crosses itself": hashed(
        edit(
            "isobaths/depth_areas.geojson",
            lambda areas: areas["features"][0]["geometry"]["coordinates"][0][0].insert(1, [0.0, 0.0]),
        ),
        "isobaths/depth_areas.geojson",
    ),
}



def first(folder, pattern):
    """The first file of an archive that a pattern names."""
    return sorted(folder.glob(pattern))[0]


def edit_first(pattern, change):
    """Changes the first JSON file of an archive that a pattern names."""
    return lambda folder: edit(first(folder, pattern).relative_to(folder), change)(folder)


def move_map(folder):
    """Moves the depth map of a tile by a cell."""
    with rasterio.Env(IGNORE_COG_LAYOUT_BREAK="YES"), rasterio.open(first(folder, "tiles/*/depth.tif"), "r+") as raster:
        raster.transform = raster.transform @ rasterio.Affine.translation(1, 0)


def move_in_vrt(folder):
    path = first(folder, "index/depth_*.vrt")
    path.write_text(path.read_text().replace('<DstRect xOff="', '<DstRect xOff="1'))


def spoil_mosaic(folder):
    """Changes a level of the mosaic of a tile."""
    with rasterio.Env(IGNORE_COG_LAYOUT_BREAK="YES"), rasterio.open(first(folder, "tiles/*/mosaic.tif"), "r+") as raster:
        levels = raster.read(1)
        row, column = numpy.argwhere(levels > 0)[0]
        levels[row, column] = 255 - levels[row, column] // 2
        raster.write(levels, 1)


ARCHIVE_SPOILERS = {
    "a point too many": edit_first("logs/*.json", lambda log: log["tiles"][0].update(points=log["tiles"][0]["points"] + 1)),
    "a tile of another zone": edit_first("logs/*.json", lambda log: log["tiles"][0].update(tile="18N_392192_3253760")),
    "rows that are not there": lambda folder: first(folder, "pings/*/*.parquet").unlink(),
    "rows that no record names": lambda folder: first(folder, "points/*/*.parquet").with_name("0.parquet").write_bytes(b""),
    "a map moved by a cell": move_map,
    "a map elsewhere": edit_first("tiles/*/tile.json", lambda tile: tile.update(bounds_m=[edge + 1.0 for edge in tile["bounds_m"]])),
    "a map of other depths": edit_first("tiles/*/tile.json", lambda tile: tile.update(depth_m=[0.0, 99.0])),
    "a mosaic of other echoes": spoil_mosaic,
    "a part of the mosaic with a cell too many": edit_first(
        "logs/*.json", lambda log: log["tiles"][0].update(mosaic_cells=log["tiles"][0]["mosaic_cells"] + 1)
    ),
    "a VRT with a tile at another place": move_in_vrt,
    "an isobath too few": edit_first("tiles/*/isobaths.geojson", lambda lines: lines["features"].pop()),
    "map tiles of a map that is not there": edit(
        "map_tiles/map_tiles.json", lambda record: record["made"]["tiles"].update(more=[])
    ),
    "an item too few": edit_first("index/collection.json", lambda index: index.update(links=[])),
}


def all_fail(spoilers, original, look):
    """Every spoiled copy must be refused."""
    for name, spoil in spoilers.items():
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch) / "spoiled"
            shutil.copytree(original, folder)
            spoil(folder)
            try:
                look(folder)
            except AssertionError as error:
                print(f"{name}: {error}")
            else:
                sys.exit(f"{name} passed")


if __name__ == "__main__":
    all_fail(SPOILERS, sys.argv[1], check)
    all_fail(ARCHIVE_SPOILERS, sys.argv[2], archive.check)
