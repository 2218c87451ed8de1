"""Makes isobaths.json: what contourpy and GDAL draw through two grids.

    pip install numpy==2.4.6 contourpy==1.3.3 rasterio==1.4.4
    python make_isobaths.py > isobaths.json

GDAL is the library inside rasterio's wheel (3.10.3), called through its C interface: GDALContourGenerate is what the program
gdal_contour calls. Lengths are in cells; both take values at the centres of cells, as Bathyscope does.

The paraboloid is the one on which a popular library also returns the frame of the grid. GDAL continues open lines by half a
cell to the edge of the outermost pixels, so the hills stand in a rim of shallow cells, which closes every line. The noise is full
of saddles: there GDAL cuts all the same way, contourpy by the mean of the corners.
"""
import ctypes as c
import glob
import json
import os

import contourpy
import numpy as np
import rasterio

GDAL = c.CDLL(glob.glob(os.path.join(os.path.dirname(rasterio.__file__), "..", "rasterio.libs", "libgdal*"))[0])
for name in ["GDALGetDriverByName", "GDALCreate", "GDALGetRasterBand", "GDALDatasetCreateLayer", "OGR_L_GetNextFeature",
             "OGR_F_GetGeometryRef", "OGR_Fld_Create"]:
    getattr(GDAL, name).restype = c.c_void_p
GDAL.OGR_G_Length.restype = c.c_double
GDAL.OGR_F_GetFieldAsDouble.restype = c.c_double


def gdal_lines(z, levels):
    """Length and number of lines of each level."""
    rows, columns = z.shape
    GDAL.GDALAllRegister()
    driver = c.c_void_p(GDAL.GDALGetDriverByName(b"MEM"))
    raster = c.c_void_p(GDAL.GDALCreate(driver, b"", columns, rows, 1, 7, None))
    transform = (c.c_double * 6)(0, 1, 0, rows, 0, -1)
    GDAL.GDALSetGeoTransform(raster, transform)
    band = c.c_void_p(GDAL.GDALGetRasterBand(raster, 1))
    z = np.ascontiguousarray(z, dtype=np.float64)
    GDAL.GDALRasterIO(band, 1, 0, 0, columns, rows, z.ctypes.data_as(c.c_void_p), columns, rows, 7, 0, 0)
    memory = c.c_void_p(GDAL.GDALGetDriverByName(b"Memory"))
    vectors = c.c_void_p(GDAL.GDALCreate(memory, b"", 0, 0, 0, 0, None))
    layer = c.c_void_p(GDAL.GDALDatasetCreateLayer(vectors, b"lines", None, 2, None))
    for field, kind in [(b"id", 0), (b"z", 2)]:
        definition = c.c_void_p(GDAL.OGR_Fld_Create(field, kind))
        GDAL.OGR_L_CreateField(layer, definition, 1)
    fixed = (c.c_double * len(levels))(*levels)
    failed = GDAL.GDALContourGenerate(band, c.c_double(0), c.c_double(0), len(levels), fixed, 0, c.c_double(0), layer, 0, 1,
                                      None, None)
    assert failed == 0
    found = {level: [0.0, 0] for level in levels}
    GDAL.OGR_L_ResetReading(layer)
    while feature := GDAL.OGR_L_GetNextFeature(layer):
        feature = c.c_void_p(feature)
        level = GDAL.OGR_F_GetFieldAsDouble(feature, 1)
        nearest = min(levels, key=lambda one: abs(one - level))
        found[nearest][0] += GDAL.OGR_G_Length(c.c_void_p(GDAL.OGR_F_GetGeometryRef(feature)))
        found[nearest][1] += 1
    return [{"length": length, "lines": lines} for length, lines in found.values()]


def length(line):
    return float(np.hypot(*np.diff(line, axis=0).T).sum())


def ring_area(ring):
    x, y = ring.T
    return 0.5 * float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))


def contourpy_lines(z, levels):
    drawn = contourpy.contour_generator(z=z, name="serial", corner_mask=False)
    return [{"length": sum(map(length, lines)), "lines": len(lines)} for lines in map(drawn.lines, levels)]


def contourpy_areas(z, levels):
    """Area and number of polygons between each level and the next."""
    drawn = contourpy.contour_generator(z=z, name="serial", corner_mask=False, fill_type="OuterOffset")
    areas = []
    for low, high in zip(levels, levels[1:]):
        points, offsets = drawn.filled(low, high)
        rings = [polygon[a:b] for polygon, offset in zip(points, offsets) for a, b in zip(offset, offset[1:])]
        areas.append({"area": abs(sum(map(ring_area, rings))), "polygons": len(points), "rings": len(rings)})
    return areas


def case(name, z, levels, gdal):
    decimal = z
    z = z.astype(np.float32).astype(np.float64)
    return {
        "name": name,
        "rows": z.shape[0],
        "columns": z.shape[1],
        "depth_m": [None if np.isnan(value) else round(float(value), 4) for value in decimal.ravel()],
        "levels_m": levels,
        "contourpy": contourpy_lines(np.ma.masked_invalid(z), levels),
        "areas": contourpy_areas(np.ma.masked_invalid(z), levels),
        "gdal": gdal_lines(z, levels) if gdal else None,
    }


def smooth_noise(rng, rows, columns, passes):
    z = rng.normal(size=(rows, columns))
    for _ in range(passes):
        z[1:-1, 1:-1] = (z[1:-1, 1:-1] + z[:-2, 1:-1] + z[2:, 1:-1] + z[1:-1, :-2] + z[1:-1, 2:]) / 5
    return (3 + 2 * z / z.std()).round(4)


def main():
    rng = np.random.default_rng(4)
    side = np.linspace(-1, 1, 101)
    paraboloid = side[None, :] ** 2 + side[:, None] ** 2
    hills = np.zeros((42, 62))
    hills[1:-1, 1:-1] = 5 + smooth_noise(rng, 40, 60, 60)
    saddles = 9 + rng.normal(size=(30, 40)).round(4)
    holes = smooth_noise(rng, 40, 60, 3)
    holes[12:17, 20:31] = np.nan
    holes[rng.random(holes.shape) < 0.02] = np.nan
    cases = [
        case("paraboloid", paraboloid.round(4), [0.25, 0.5], True),
        case("hills", hills, [7.1012, 8.1012, 9.1012], True),
        case("saddles", saddles, [8.0512, 9.0512, 10.0512], False),
        case("holes", holes, [1.0101, 2.0101, 3.0101, 4.0101, 5.0101], False),
    ]
    print(json.dumps(cases).replace("], ", "],\n").replace("}, ", "},\n"))


main()
