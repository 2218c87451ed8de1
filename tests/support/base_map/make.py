"""Writes the pictures of this folder with GDAL, and the colours that it reads from them again.

rasterio 1.4.4 (GDAL 3.10.3), pyproj 3.7.2, numpy; run in this folder.
"""
import json

import numpy as np
import rasterio
from pyproj import Transformer
from rasterio.enums import ColorInterp, Resampling
from rasterio.transform import Affine, from_origin

random = np.random.default_rng(7)
# The demo survey's first fix.
LON, LAT = -82.11, 29.41


def corner(epsg, columns, rows, pixel):
    x, y = Transformer.from_crs(4326, epsg, always_xy=True).transform(LON, LAT)
    return from_origin(x - columns / 2 * pixel, y + rows / 2 * pixel, pixel, pixel)


def picture(columns, rows, bands):
    """Smooth enough to pack, different everywhere."""
    column, row = np.meshgrid(np.arange(columns), np.arange(rows))
    waves = [(column * 3 + row) % 256, (row * 5) % 256, 255 - (column + row * 2) % 256, np.full_like(row, 255)]
    return np.stack(waves[:bands]).astype(np.uint8)


def write(name, data, epsg, pixel, palette=None, overviews=(), transform=None, interpretation=None, late=False, mask=None, **options):
    bands, rows, columns = data.shape
    transform = transform or corner(epsg or 32617, columns, rows, pixel)
    profile = dict(driver="GTiff", width=columns, height=rows, count=bands, dtype=data.dtype, transform=transform)
    if epsg:
        profile["crs"] = f"EPSG:{epsg}"
    with rasterio.Env(GDAL_TIFF_INTERNAL_MASK=True), rasterio.open(name, "w", **profile, **options) as file:
        if palette and not late:
            file.write_colormap(1, palette)
        file.write(data)
        if mask is not None:
            file.write_mask(mask)
        if palette and late:
            file.write_colormap(1, palette)
        if interpretation:
            file.colorinterp = interpretation
        if overviews:
            file.build_overviews(overviews, Resampling.average)


def colours(name, epsg, count=40):
    """Position and colour of some pixels, as GDAL reads them."""
    with rasterio.open(name) as file:
        data, place = file.read(), file.transform
        palette = file.colormap(1) if file.colorinterp[0] == ColorInterp.palette else None
        nodata = file.nodata
        seen = file.dataset_mask()
        has_alpha = ColorInterp.alpha in file.colorinterp
    to_degrees = Transformer.from_crs(epsg, 4326, always_xy=True)
    found = []
    for _ in range(count):
        row, column = random.integers(data.shape[1]), random.integers(data.shape[2])
        lon, lat = to_degrees.transform(*(place * (column + 0.5, row + 0.5)))
        values = [int(value) for value in data[:, row, column]]
        if palette:
            colour = [*palette[values[0]][:3], 255]
        elif len(values) == 1:
            colour = [values[0]] * 3 + [255]
        else:
            colour = values[:3] + [values[3] if has_alpha else 255]
        if colour[3] == 0 or seen[row, column] == 0 or nodata is not None and all(value == nodata for value in values):
            colour = [0, 0, 0, 0]
        found.append([lon, lat, colour])
    return found


tiled = dict(tiled=True, blockxsize=64, blockysize=64)
write("utm_rgb.tif", picture(200, 150, 3), 32617, 0.3, compress="deflate", predictor=2, overviews=(2, 4), **tiled)
grey = picture(90, 70, 1)
grey[:, 20:30, 10:60] = 0
write("degrees_grey.tif", grey, 4326, 4e-6, compress="lzw", nodata=0)
palette = {index: (index, 255 - index, index * 7 % 256, 255) for index in range(256)}
write("mercator_palette.tif", picture(80, 60, 1), 3857, 0.7, palette=palette, tiled=True, blockxsize=32, blockysize=32)
write("late_palette.tif", picture(40, 30, 1), 32617, 0.7, palette=palette, late=True, compress="deflate")
write("infrared.tif", picture(60, 40, 4), 32617, 0.6, compress="deflate", photometric="rgb", alpha="no")
write("bands.tif", picture(60, 40, 4), 32617, 0.6, compress="deflate", photometric="minisblack", alpha="no")
rgba = picture(60, 50, 4)
rgba[3, 10:20, 10:40] = 0
write("nad83_rgba.tif", rgba, 26917, 0.5, compress="deflate",
      interpretation=[ColorInterp.red, ColorInterp.green, ColorInterp.blue, ColorInterp.alpha])
soft = np.stack([np.outer(np.linspace(a, b, 128), np.linspace(1, 0.6, 128)) for a, b in [(40, 220), (200, 60), (90, 120)]])
write("jpeg.tif", soft.astype(np.uint8), 32617, 0.5, compress="jpeg", photometric="ycbcr", jpeg_quality=92, **tiled)
wide = np.repeat(np.repeat(picture(130, 16, 3), 40, axis=2), 40, axis=1)
write("wide.tif", wide, 32617, 0.02, compress="deflate", tiled=True, blockxsize=256, blockysize=256)
write("lambert.tif", picture(60, 40, 3), 2154, 0.5, compress="deflate", transform=from_origin(652000, 6862000, 0.5, 0.5))
seen = np.hypot(*np.meshgrid(np.linspace(-1, 1, 210), np.linspace(-1, 1, 150))) < 0.8
write("masked_grey.tif", picture(210, 150, 1), 32617, 0.3, compress="deflate", overviews=(2,), mask=seen, **tiled)
# Refused.
write("heights.tif", picture(20, 20, 1).astype(np.float32), 32617, 0.5)
write("nowhere.tif", picture(20, 20, 3), None, 0.5)
write("british.tif", picture(20, 20, 3), 27700, 0.5, transform=from_origin(530000, 180000, 0.5, 0.5))
write("turned.tif", picture(20, 20, 3), 32617, 0.5, transform=Affine(0.5, 0.1, 392300, 0.1, -0.5, 3253950))

cases = [("utm_rgb.tif", 32617), ("degrees_grey.tif", 4326), ("mercator_palette.tif", 3857),
         ("late_palette.tif", 32617), ("lambert.tif", 2154), ("infrared.tif", 32617), ("bands.tif", 32617),
         ("nad83_rgba.tif", 26917), ("jpeg.tif", 32617), ("wide.tif", 32617), ("masked_grey.tif", 32617)]
with open("colours.json", "w") as file:
    json.dump({name: colours(name, epsg) for name, epsg in cases}, file, indent=None)
