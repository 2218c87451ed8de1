"""The GeoTIFFs by GDAL."""

import lxml.etree
import numpy
import rasterio
import rasterio.windows
from rio_cogeo.cogeo import cog_validate
from common import check_count, check_extent, check_values, into, same, tolerance

LAYERS = {
    "depth.tif": "depth",
    "uncertainty.tif": "standard deviation of depth",
    "shoalest.tif": "shoalest depth",
    "distance.tif": "distance to the nearest depth",
    "hardness.tif": "brightness of the bed over the median",
}


def check(folder, made, points):
    for name in LAYERS:
        if name in made:
            check_layer(name, folder / "depth" / name, made[name])
    if "source.tif" in made:
        check_source(folder, made["source.tif"], points)
    if "depth.xyz" in made:
        check_cells(folder, made["depth.xyz"])
    if "depth.tif" in made:
        check_depths(folder / "depth/depth.tif", made["depth.tif"], points)
    if "mosaic.tif" in made:
        check_mosaic(folder / "mosaic/mosaic.tif", made["mosaic.tif"], points)
    for name in (*LAYERS, "source.tif", "mosaic.tif"):
        if name in made:
            check_cloud_optimized(name, folder / ("mosaic" if name == "mosaic.tif" else "depth") / name)


def check_cloud_optimized(name, path):
    """The port of GDAL's own validator that comes with rio-cogeo; a warning counts as an error."""
    valid, errors, warnings = cog_validate(path, strict=True, quiet=True)
    assert valid and not warnings, f"{name} is no valid Cloud-Optimized GeoTIFF: {errors + warnings}"


def check_statistics(name, raster, values):
    """What the band says of itself, against numpy."""
    said = raster.tags(1)
    found = {
        "MINIMUM": values.min(),
        "MAXIMUM": values.max(),
        "MEAN": values.mean(dtype="float64"),
        "STDDEV": values.std(dtype="float64"),
        "VALID_PERCENT": 100 * values.size / (raster.width * raster.height),
    }
    for key, value in found.items():
        off = abs(float(said[f"STATISTICS_{key}"]) - value)
        assert off <= 1e-6 * max(1.0, abs(value)), f"{name}: {key} is {value}, not {said}"


def check_raster(name, raster, record):
    assert raster.crs.to_epsg() == record["crs"]["epsg"], raster.crs
    bounds = raster.bounds
    check_extent(name, record, (bounds.left, bounds.bottom), (bounds.right, bounds.top), 0.0001)
    assert raster.is_tiled and raster.compression.name == "deflate"
    large = max(raster.width, raster.height) > 256
    assert bool(raster.overviews(1)) == large, f"{name}: overviews {raster.overviews(1)}"


def check_layer(name, path, record):
    with rasterio.open(path) as raster:
        check_raster(name, raster, record)
        assert raster.dtypes == ("float32",) and raster.nodata == -9999
        assert raster.descriptions == (LAYERS[name],), raster.descriptions
        assert raster.units == ("decibel" if name == "hardness.tif" else "metre",), raster.units
        assert raster.tags(1).get("positive") == ("down" if name in ("depth.tif", "shoalest.tif") else None)
        values = raster.read(1, masked=True).compressed()
        check_statistics(name, raster, values)
        check_style(path, values)
    check_count(name, record, "cells", len(values))
    check_values(name, record, values.min(), values.max(), 0.00001)


def check_source(folder, record, points):
    """A class for each cell that has a depth; where soundings lie, that of soundings."""
    path = folder / "depth/source.tif"
    with rasterio.open(path) as raster, rasterio.open(folder / "depth/depth.tif") as depths:
        check_raster("source.tif", raster, record)
        assert raster.dtypes == ("uint8",) and raster.descriptions == ("source of the depth",)
        known = depths.read(1) != -9999
        classes, mask = raster.read(1), raster.dataset_mask()
        assert ((mask > 0) == known).all() and set(numpy.unique(classes[known])) <= {1, 2, 3, 4}
        check_statistics("source.tif", raster, classes[known])
        places = into(record, points.lon, points.lat)
        found = numpy.array([value[0] for value in raster.sample(places)])
    on_map = found > 0
    assert (found[on_map & (points.source == 0)] == 4).mean() > 0.95, "soundings in cells without"
    beside = found[on_map & (points.source > 0)]
    assert beside.size == 0 or (beside >= 3).mean() > 0.5, "first returns in cells without"
    check_count("source.tif", record, "cells", known.sum())
    entries = lxml.etree.parse(path.with_suffix(".qml")).findall(".//paletteEntry")
    assert [entry.get("value") for entry in entries] == ["4", "3", "2", "1"], entries


def check_style(path, values):
    """The colours for QGIS run from the least to the greatest value."""
    renderer = lxml.etree.parse(path.with_suffix(".qml")).find(".//rasterrenderer")
    assert renderer.get("type") == "singlebandpseudocolor" and renderer.get("band") == "1"
    stops = [float(item.get("value")) for item in renderer.iter("item")]
    same(f"{path.stem}.qml", [stops[0], stops[-1]], [values.min(), values.max()], 0.00001)
    assert (numpy.diff(stops) >= 0).all() and len(stops) > 5


def check_cells(folder, record):
    """Every known cell of the raster, at its middle, and no other."""
    found = numpy.loadtxt(folder / "depth/depth.xyz", ndmin=2)
    check_count("depth.xyz", record, "cells", len(found))
    check_extent("depth.xyz", record, found[:, :2].min(axis=0), found[:, :2].max(axis=0), 0.001)
    check_values("depth.xyz", record, found[:, 2].min(), found[:, 2].max(), 0.00051)
    with rasterio.open(folder / "depth/depth.tif") as raster:
        values = raster.read(1, masked=True)
        rows, columns = numpy.nonzero(~numpy.ma.getmaskarray(values))
        middles = numpy.array(raster.xy(rows, columns)).T
    same("x, y of depth.xyz", found[:, :2], middles, tolerance(record, 0.001))
    same("depth of depth.xyz", found[:, 2], values.data[rows, columns], 0.00051)


def check_depths(path, record, points):
    """The map lies on the soundings, but for what a cell of relief and side-scan of another opinion explain; it ends at their hull."""
    soundings = points.source == 0
    places = into(record, points.lon[soundings], points.lat[soundings])
    depths = -points.z[soundings]
    with rasterio.open(path) as raster:
        found = numpy.array([value[0] for value in raster.sample(places)])
        beside = numpy.array([is_next_to_a_depth(raster, place) for place in places])
    known = found != -9999
    assert beside.mean() > 0.9, f"only {beside.mean():.0%} of the soundings lie on the map or beside it"
    off = numpy.abs(found - depths)[known]
    median, most = numpy.quantile(off, [0.5, 0.95]) / numpy.ptp(depths)
    assert median < 0.04 and most < 0.25, f"half of the map is {median:.1%} of the relief off, 95 % {most:.1%}"


def is_next_to_a_depth(raster, place):
    """Whether the cell of a place or one around it has a depth: a single line's hull is thinner than a cell."""
    row, column = raster.index(*place)
    window = rasterio.windows.Window(max(column - 1, 0), max(row - 1, 0), 3, 3)
    return (raster.read(1, window=window) != -9999).any()


def check_mosaic(path, record, points):
    with rasterio.open(path) as raster:
        check_raster("mosaic.tif", raster, record)
        check_count("mosaic.tif", record, "cells", raster.width * raster.height)
        assert raster.count == 1 and raster.dtypes == ("uint8",) and raster.nodata is None
        assert raster.colorinterp == (rasterio.enums.ColorInterp.gray,)
        assert raster.mask_flag_enums == ([rasterio.enums.MaskFlags.per_dataset],), raster.mask_flag_enums
        assert raster.descriptions == ("echo level",)
        levels, mask = raster.read(1), raster.dataset_mask()
        check_statistics("mosaic.tif", raster, levels[mask > 0])
        pings = into(record, points.lon, points.lat)[points.source > 0]
        detected = [raster.index(*place) for place in pings]
        seen = numpy.array([mask[row, column] for row, column in detected if raster_holds(raster, row, column)]) > 0
        overviews = raster.overviews(1)
    assert seen.sum() > 0.9 * len(pings), f"only {seen.sum()} of {len(pings)} first returns lie on the mosaic"
    assert ((mask > 0) == (levels > 0)).all() and levels[mask > 0].std() > 5, "the mosaic shows nothing"
    for level in range(len(overviews)):
        with rasterio.open(path, overview_level=level) as raster:
            assert ((raster.dataset_mask() > 0) == (raster.read(1) > 0)).all(), f"the mask of overview {level} is another"


def raster_holds(raster, row, column):
    return 0 <= row < raster.height and 0 <= column < raster.width
