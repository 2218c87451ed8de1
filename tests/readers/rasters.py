"""The GeoTIFFs by GDAL."""

import numpy
import rasterio
from common import check_count, check_extent, check_values, into, same, tolerance

LAYERS = ("depth.tif", "uncertainty.tif", "distance.tif")


def check(folder, made, points):
    for name in LAYERS:
        if name in made:
            check_layer(name, folder / name, made[name])
    if "depth.xyz" in made:
        check_cells(folder, made["depth.xyz"])
    if "depth.tif" in made:
        check_depths(folder / "depth.tif", made["depth.tif"], points)
    if "mosaic.tif" in made:
        check_mosaic(folder / "mosaic.tif", made["mosaic.tif"], points)


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
        values = raster.read(1, masked=True).compressed()
    check_count(name, record, "cells", len(values))
    check_values(name, record, values.min(), values.max(), 0.00001)


def check_cells(folder, record):
    """Every known cell of the raster, at its middle, and no other."""
    found = numpy.loadtxt(folder / "depth.xyz", ndmin=2)
    check_count("depth.xyz", record, "cells", len(found))
    check_extent("depth.xyz", record, found[:, :2].min(axis=0), found[:, :2].max(axis=0), 0.001)
    check_values("depth.xyz", record, found[:, 2].min(), found[:, 2].max(), 0.00051)
    with rasterio.open(folder / "depth.tif") as raster:
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
        beside = numpy.array([is_beside_a_depth(raster, place) for place in places])
    known = found != -9999
    assert beside.mean() > 0.9, f"only {beside.mean():.0%} of the soundings lie on the map or beside it"
    off = numpy.abs(found - depths)[known]
    median, most = numpy.quantile(off, [0.5, 0.95]) / numpy.ptp(depths)
    assert median < 0.04 and most < 0.25, f"half of the map is {median:.1%} of the relief off, 95 % {most:.1%}"


def is_beside_a_depth(raster, place):
    """Whether the cell of a place or one around it has a depth: a single line's hull is thinner than a cell."""
    row, column = raster.index(*place)
    window = rasterio.windows.Window(max(column - 1, 0), max(row - 1, 0), 3, 3)
    return (raster.read(1, window=window) != -9999).any()


def check_mosaic(path, record, points):
    with rasterio.open(path) as raster:
        check_raster("mosaic.tif", raster, record)
        check_count("mosaic.tif", record, "cells", raster.width * raster.height)
        assert raster.count == 4 and set(raster.dtypes) == {"uint8"}
        assert raster.colorinterp[3] == rasterio.enums.ColorInterp.alpha
        picture = raster.read()
        pings = into(record, points.lon, points.lat)[points.source > 0]
        heard = numpy.array([value[0] for value in raster.sample(pings, indexes=4)]) > 0
    assert heard.mean() > 0.9, f"only {heard.mean():.0%} of the first returns lie on the mosaic"
    opaque = picture[3] == 255
    assert set(numpy.unique(picture[3])) <= {0, 255}
    assert (picture[:3, ~opaque] == 0).all() and picture[0, opaque].std() > 5, "the mosaic shows nothing"
