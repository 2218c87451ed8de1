"""The bottom for 3D programs by trimesh, and as points by laspy, against the depth map by GDAL."""

import laspy
import numpy
import octree
import rasterio
import trimesh
from common import check_count, check_extent, check_values, same, tolerance

# Means over larger cells lie between what they are made of; the file has heights as 32-bit floats.
ROUNDING_M = 0.001


def check(folder, made):
    if "bottom.glb" not in made:
        return
    scene = trimesh.load(folder / "depth/bottom.glb")
    (mesh,) = scene.geometry.values()
    record = made["bottom.glb"]
    up = mesh.vertices[:, 1]
    check_count("bottom.glb", record, "cells", len(mesh.vertices))
    check_values("bottom.glb", record, -up.max(), -up.min(), ROUNDING_M)
    faces = mesh.faces.astype(int)
    assert faces.max() < len(mesh.vertices) and len(faces) > 0, "a triangle without a corner"
    a, b, c = (mesh.vertices[faces[:, corner]] for corner in range(3))
    upward = numpy.cross(b - a, c - a)[:, 1]
    assert (upward > 0).all(), "a triangle of the bottom faces down"
    normals = mesh.vertex_normals
    assert numpy.allclose(numpy.linalg.norm(normals, axis=1), 1, atol=1e-4) and (normals[:, 1] > 0).all(), "normals"
    picture = mesh.visual.material.baseColorTexture
    assert picture is not None and picture.size[0] > 1, "no picture"
    check_heights(folder, mesh)
    check_points(folder, made["bottom.copc.laz"])


def check_heights(folder, mesh):
    """Every corner against the cells of the depth map that it stands for. Pictures run over whole cells, so they say which those are."""
    with rasterio.open(folder / "depth/depth.tif") as raster:
        depths = raster.read(1, masked=True).filled(numpy.nan)
    picture = mesh.visual.material.baseColorTexture
    columns, rows = picture.size
    times = max(1, -(-max(depths.shape[1], depths.shape[0]) // max(columns, rows)))
    assert (-(-depths.shape[1] // times), -(-depths.shape[0] // times)) == (columns, rows), "the picture has not the map's cells"
    # trimesh counts v from below.
    u, v = mesh.visual.uv.T
    column, row = (u * columns - 0.5).round().astype(int), ((1 - v) * rows - 0.5).round().astype(int)
    padded = numpy.full((rows * times, columns * times), numpy.nan)
    padded[: depths.shape[0], : depths.shape[1]] = depths
    blocks = padded.reshape(rows, times, columns, times)
    with numpy.errstate(invalid="ignore"):
        known = ~numpy.isnan(blocks).all((1, 3))
    mean = numpy.nanmean(numpy.where(known[:, None, :, None], blocks, 0), axis=(1, 3))
    assert known.sum() == len(mesh.vertices) and known[row, column].all(), "other cells than those of the map"
    off = numpy.abs(mean[row, column] + mesh.vertices[:, 1]).max()
    assert off <= ROUNDING_M, f"bottom.glb: heights are off by {off} m"
    # East and south, one cell apart.
    for axis, place in (("east", column), ("south", row)):
        metres = mesh.vertices[:, 0 if axis == "east" else 2]
        spacing = numpy.ptp(metres) / max(numpy.ptp(place), 1)
        worst = numpy.abs(metres - metres.min() - (place - place.min()) * spacing).max()
        assert worst <= ROUNDING_M, f"bottom.glb: corners are not evenly apart towards the {axis}, by {worst} m"


def check_points(folder, record):
    """Every known cell of the rasters, at its middle, and no other; what was not measured says so."""
    path = folder / "depth/bottom.copc.laz"
    octree.check(path)
    las = laspy.read(path)
    xyz = numpy.array([las.x, las.y, las.z]).T
    check_count("bottom.copc.laz", record, "cells", len(xyz))
    check_extent("bottom.copc.laz", record, xyz[:, :2].min(axis=0), xyz[:, :2].max(axis=0), 0.001)
    check_values("bottom.copc.laz", record, xyz[:, 2].min(), xyz[:, 2].max(), 0.001)
    assert las.header.parse_crs().to_epsg() == record["crs"]["epsg"], las.header.parse_crs()
    with rasterio.open(folder / "depth/depth.tif") as raster:
        rows, columns = numpy.nonzero(~numpy.ma.getmaskarray(raster.read(1, masked=True)))
        middles = numpy.array(raster.xy(rows, columns)).T
        found = [numpy.asarray(cells) for cells in rasterio.transform.rowcol(raster.transform, xyz[:, 0], xyz[:, 1])]
        order = numpy.lexsort((found[1], found[0]))
    las, xyz = las[order], xyz[order]
    same("x, y of bottom.copc.laz", xyz[:, :2], middles, tolerance(record, 0.001))
    for name, values, within in (("depth", -xyz[:, 2], 0.00051), ("source", las.source, 0), ("distance", las.distance_m, 0)):
        with rasterio.open(folder / f"depth/{name}.tif") as raster:
            same(f"{name} of bottom.copc.laz", values, raster.read(1)[rows, columns], within)
    with rasterio.open(folder / "depth/uncertainty.tif") as raster:
        expected = raster.read(1, masked=True).filled(-1)[rows, columns]
    same("sigma of bottom.copc.laz", las.sigma_m, expected, 0)
    same("synthetic of bottom.copc.laz", las.synthetic, las.source < 3, 0)
