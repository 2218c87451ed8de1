"""Makes strips.tif, tiles.tif and degrees.tif with GDAL: rows and columns of a tilted plane, one cell without a value.

    pip install rasterio==1.4.4 numpy==2.4.6
    python rasters.py
"""
import pathlib

import numpy as np
import rasterio
from rasterio.transform import from_origin

HERE = pathlib.Path(__file__).parent
row, column = np.mgrid[0:9, 0:12]
plane = -(2 + 0.01 * column + 0.003 * row)
plane[4, 5] = -9999

UTM = dict(crs="EPSG:32617", transform=from_origin(392000, 3254000, 0.5, 0.5))
DEGREES = dict(crs="EPSG:4326", transform=from_origin(-82.11, 29.41, 1e-5, 1e-5))
for name, kind, options in [
    ("strips.tif", "float32", dict(compress="deflate", predictor=3, blockysize=4, **UTM)),
    ("tiles.tif", "float32", dict(compress="lzw", tiled=True, blockxsize=16, blockysize=16, **UTM)),
    ("degrees.tif", "float64", dict(**DEGREES)),
]:
    with rasterio.open(HERE / name, "w", driver="GTiff", height=9, width=12, count=1, dtype=kind, nodata=-9999, **options) as file:
        file.write(plane.astype(kind), 1)
