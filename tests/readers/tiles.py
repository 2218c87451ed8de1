"""MBTiles and PMTiles by sqlite3, GDAL and the `pmtiles` package, compared with the depth map."""

import io
import json
import sqlite3

import numpy
import pyproj
import rasterio
from common import check_count, check_extent, check_values
from PIL import Image
from pmtiles.reader import MemorySource, Reader, all_tiles
from pmtiles.tile import TileType

SIDE = 256
HALF_M = numpy.pi * 6378137


def rgba(content):
    picture = Image.open(io.BytesIO(content))
    assert picture.format == "PNG" and picture.size == (SIDE, SIDE) and picture.mode == "RGBA"
    return numpy.asarray(picture).astype("int64")


def elevations(picture):
    """Terrarium; NaN where the picture is clear."""
    red, green, blue, opacity = numpy.moveaxis(picture, -1, 0)
    assert set(numpy.unique(opacity)) <= {0, 255}
    return numpy.where(opacity == 255, red * 256 + green + blue / 256 - 32768, numpy.nan)


def places(zoom, x, y):
    """Web Mercator of the middles of a tile's pixels."""
    metres = 2 * HALF_M / SIDE / 2**zoom
    steps = numpy.arange(SIDE) + 0.5
    return numpy.meshgrid((x * SIDE + steps) * metres - HALF_M, HALF_M - (y * SIDE + steps) * metres)


def open_pmtiles(path):
    """Header, metadata and the pictures by zoom, x and y."""
    content = path.read_bytes()
    reader = Reader(MemorySource(content))
    header = reader.header()
    assert header["version"] == 3 and header["clustered"] and header["tile_type"] == TileType.PNG
    tiles = dict(all_tiles(MemorySource(content)))
    assert header["addressed_tiles_count"] == header["tile_entries_count"] == len(tiles), f"{path.name}: {len(tiles)} tiles"
    assert header["tile_data_offset"] + header["tile_data_length"] == len(content)
    zooms = [zoom for zoom, _, _ in tiles]
    assert [min(zooms), max(zooms)] == [header["min_zoom"], header["max_zoom"]], f"{path.name}: zooms {min(zooms)} to {max(zooms)}"
    for place in list(tiles)[:: max(1, len(tiles) // 20)]:
        assert reader.get(*place) == tiles[place], f"{path.name}: {place}"
    return header, reader.metadata(), tiles


def open_mbtiles(path):
    """Metadata and the pictures by zoom, x and y."""
    with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as base:
        assert base.execute("pragma integrity_check").fetchall() == [("ok",)]
        assert base.execute("pragma application_id").fetchone() == (0x4D504258,)
        plan = base.execute("explain query plan select tile_data from tiles where zoom_level=1 and tile_column=1 and tile_row=1").fetchall()
        assert "USING INDEX" in plan[0][3], plan
        metadata = dict(base.execute("select name, value from metadata"))
        rows = base.execute("select zoom_level, tile_column, tile_row, tile_data from tiles").fetchall()
    return metadata, {(zoom, x, 2**zoom - 1 - y): content for zoom, x, y, content in rows}


def check_depths(tiles, finest, depth_at):
    """Depths of the finest tiles against the raster that they were drawn from; how many pixels."""
    off, missing, count = [], 0, 0
    for (zoom, x, y), content in tiles.items():
        if zoom == finest:
            found = -elevations(rgba(content))
            expected = depth_at(*places(zoom, x, y))
            count += numpy.isfinite(found).sum()
            missing += (numpy.isfinite(found) != numpy.isfinite(expected)).sum()
            off.append(numpy.abs(found - expected)[numpy.isfinite(found - expected)])
    off = numpy.concatenate(off)
    assert count > 1000 and missing < 0.002 * count, f"{missing} of {count} pixels have a depth in one of the two only"
    median, most = numpy.quantile(off, [0.5, 0.99])
    # Pixels are interpolated between cells; the nearest cell is off by the relief within half of it.
    assert median < 0.02 and most < 0.35, f"depths are off by {median} and {most} m"
    return count


def check_coarser(tiles, coarsest):
    """Each pixel of a coarser tile is the mean of those that it is made of."""
    for (zoom, x, y), content in tiles.items():
        if zoom == coarsest:
            continue
        parent = elevations(rgba(tiles[zoom - 1, x // 2, y // 2]))
        half = parent[y % 2 * 128 :, x % 2 * 128 :][:128, :128]
        four = elevations(rgba(content)).reshape(128, 2, 128, 2)
        with numpy.errstate(invalid="ignore"):
            mean = numpy.nansum(four, axis=(1, 3)) / numpy.isfinite(four).sum(axis=(1, 3))
        assert (numpy.isfinite(half) == numpy.isfinite(mean)).all(), f"{zoom}/{x}/{y}"
        assert not numpy.isfinite(mean).any() or numpy.nanmax(numpy.abs(half - mean)) < 0.02, f"{zoom}/{x}/{y}"


def check_set(folder, depth_at):
    """The archives of a folder agree with each other and with the depths; header, and how many tiles and pixels."""
    header, metadata, colours = open_pmtiles(folder / "depth.pmtiles")
    other, said, values = open_pmtiles(folder / "depth_values.pmtiles")
    assert said["encoding"] == "terrarium" and "encoding" not in metadata
    named, chart = open_mbtiles(folder / "depth.mbtiles")
    assert colours.keys() == values.keys() == chart.keys(), "the archives hold different tiles"
    for key in ("min_zoom", "max_zoom", "min_lon_e7", "min_lat_e7", "max_lon_e7", "max_lat_e7"):
        assert header[key] == other[key], key
    assert named["format"] == "png" and named["type"] == "overlay" and named["name"] == metadata["name"]
    assert [int(named["minzoom"]), int(named["maxzoom"])] == [header["min_zoom"], header["max_zoom"]]
    bounds = [header[key] / 1e7 for key in ("min_lon_e7", "min_lat_e7", "max_lon_e7", "max_lat_e7")]
    assert numpy.abs(numpy.array(named["bounds"].split(","), dtype=float) - bounds).max() < 2e-7
    count = check_depths(values, header["max_zoom"], depth_at)
    check_coarser(values, header["min_zoom"])
    drawn = 0
    for place, content in colours.items():
        lit, lined = rgba(content), rgba(chart[place])
        known = numpy.isfinite(elevations(rgba(values[place])))
        assert ((lit[..., 3] == 255) == known).all(), f"{place}: colours where no depth is, or none where one is"
        drawn += (lit != lined).any(axis=-1).sum()
    assert drawn > 0, "no isobath is drawn"
    check_gdal(folder / "depth.mbtiles", chart, header["max_zoom"])
    page = (folder / "index.html").read_text()
    assert page.count("https://") == 1 and "http://" not in page.replace("https://", "")
    return header, len(colours), count


def check_gdal(path, tiles, finest):
    """GDAL opens the file at its finest zoom and sees the same pictures."""
    with rasterio.open(path) as raster:
        assert raster.driver == "MBTiles" and raster.crs.to_epsg() == 3857 and raster.count == 4
        assert abs(raster.res[0] - 2 * HALF_M / SIDE / 2**finest) < 1e-6
        zoom, x, y = next(place for place in tiles if place[0] == finest)
        xs, ys = places(zoom, x, y)
        row, column = raster.index(xs[0, 0], ys[0, 0])
        window = rasterio.windows.Window(column, row, SIDE, SIDE)
        found = numpy.moveaxis(raster.read(window=window, boundless=True, fill_value=0), 0, -1)
    expected = rgba(tiles[zoom, x, y])
    inside = (found != 0).any(axis=-1)
    assert inside.any() and (found[inside] == expected[inside]).all(), "GDAL sees another picture"


def sampler(path):
    """Depths of the cells of a raster at Web Mercator places."""
    with rasterio.open(path) as raster:
        depth, transform, crs = raster.read(1), ~raster.transform, raster.crs
        nodata = raster.nodata
    bring = pyproj.Transformer.from_crs(3857, crs, always_xy=True)

    def depth_at(xs, ys):
        columns, rows = transform * bring.transform(xs, ys)
        columns, rows = numpy.floor(columns).astype(int), numpy.floor(rows).astype(int)
        inside = (columns >= 0) & (rows >= 0) & (columns < depth.shape[1]) & (rows < depth.shape[0])
        found = depth[numpy.clip(rows, 0, depth.shape[0] - 1), numpy.clip(columns, 0, depth.shape[1] - 1)]
        return numpy.where(inside & (found != nodata), found, numpy.nan)

    return depth_at


def check(folder, made):
    """The tiles of a run."""
    if "depth.mbtiles" not in made:
        return
    header, tiles, _ = check_set(folder / "map_tiles", sampler(folder / "depth/depth.tif"))
    to_metres = pyproj.Transformer.from_crs(4326, 3857, always_xy=True)
    least, most = [
        to_metres.transform(header[f"{end}_lon_e7"] / 1e7, header[f"{end}_lat_e7"] / 1e7) for end in ("min", "max")
    ]
    depths = made["depth.tif"]["values"]
    for name in ("depth.mbtiles", "depth.pmtiles", "depth_values.pmtiles"):
        assert made[name]["crs"]["epsg"] == 3857
        check_count(name, made[name], "tiles", tiles)
        check_extent(name, made[name], least, most, 0.02)
        check_values(name, made[name], depths["least"], depths["most"], 1e-5)


def check_opens_on(header, paths):
    """The map of the web is said to lie where the depths are, within a few cells: a page opens on them."""
    boxes = []
    for path in paths:
        with rasterio.open(path) as raster:
            rows, columns = numpy.nonzero(~numpy.ma.getmaskarray(raster.read(1, masked=True)))
            west, north = raster.transform @ (columns.min(), rows.min())
            east, south = raster.transform @ (columns.max() + 1, rows.max() + 1)
            turn = pyproj.Transformer.from_crs(raster.crs, 4326, always_xy=True)
            boxes.append(turn.transform_bounds(west, south, east, north))
            cell_deg = raster.res[0] / 111e3 / numpy.cos(numpy.radians(boxes[-1][1]))
    west, south, east, north = numpy.array(boxes).T
    extent = numpy.array([-west.min(), -south.min(), east.max(), north.max()])
    said = numpy.array([-header["min_lon_e7"], -header["min_lat_e7"], header["max_lon_e7"], header["max_lat_e7"]]) / 1e7
    assert (said > extent).all() and (said < extent + 4.0 * cell_deg).all(), f"{said} for {extent}"


def check_archive(folder):
    """The joined tiles of an archive against the maps of its tiles."""
    rasters = [sampler(path) for path in sorted(folder.glob("tiles/*/depth.tif"))]

    def depth_at(xs, ys):
        layers = numpy.array([depth_at(xs, ys) for depth_at in rasters])
        known = numpy.isfinite(layers)
        return numpy.where(known.any(axis=0), numpy.take_along_axis(layers, known.argmax(axis=0)[None], axis=0)[0], numpy.nan)

    header, tiles, count = check_set(folder / "map_tiles", depth_at)
    check_opens_on(header, sorted(folder.glob("tiles/*/depth.tif")))
    made = json.loads((folder / "map_tiles/map_tiles.json").read_text())["made"]["tiles"]
    maps = [json.loads(path.read_text()) for path in folder.glob("tiles/*/tile.json")]
    assert len(made) == sum(bool(one["cells"]) for one in maps), f"made of {len(made)} maps"
    return tiles, count
