#!/usr/bin/env python3
"""A COPC file by laspy: whole, where somebody looks, and from coarse to fine. `make` writes points for it, an even bed of more points than one node
of an octree holds."""

import sys

import laspy
import lazrs
import numpy
from laspy.copc import Bounds, CopcReader

SIDE, STEP_M = 500, 0.5


def make(path):
    x, y = (axis.ravel() * STEP_M for axis in numpy.meshgrid(numpy.arange(SIDE), numpy.arange(SIDE)))
    z = -3 - numpy.sin(x / 20) - 0.01 * y
    bed = numpy.array([x + 5e5, y + 4e6, z]).T
    numpy.savetxt(path, bed, fmt="%.3f", delimiter=",", header="x,y,z", comments="")


def places(points):
    """Coordinates, the same points in the same order whatever order they were read in."""
    xyz = numpy.array([points.x, points.y, points.z]).T
    return xyz[numpy.lexsort(xyz.T)]


def within(points, bounds, more):
    """Points in a box that is made larger by so much on all sides."""
    west, south, east, north = bounds
    x, y = points[:, 0], points[:, 1]
    inside = (x >= west - more) & (x <= east + more) & (y >= south - more) & (y <= north + more)
    return set(map(tuple, points[inside]))


def check(path):
    """How many levels the octree has."""
    every = places(laspy.read(path))
    with CopcReader.open(path) as reader:
        assert reader.copc_info.spacing > 0 and len(every) == reader.header.point_count
        try:
            by_nodes = reader.query()
        except lazrs.LazrsError as error:
            raise AssertionError(f"a node cannot be unpacked: {error}") from error
        assert numpy.array_equal(places(by_nodes), every), "COPC and LAZ hold other points"
        least, most = reader.header.mins, reader.header.maxs
        (west, south), (east, north) = (0.6 * least + 0.4 * most)[:2], (0.3 * least + 0.7 * most)[:2]
        looked_at = reader.query(bounds=Bounds(mins=numpy.array([west, south]), maxs=numpy.array([east, north])))
        # The reader rounds the edges of the part to units of the file.
        unit = reader.header.scales[:2].max()
        found = set(map(tuple, places(looked_at)))
        surely, perhaps = (within(every, [west, south, east, north], by) for by in (-2 * unit, 2 * unit))
        assert surely <= found <= perhaps and surely, "a part holds other points"
        levels, seen = 0, 0
        while seen < len(every):
            points = reader.query(level=levels)
            assert len(points), f"level {levels} is empty, and points are missing"
            seen, levels = seen + len(points), levels + 1
        assert seen == len(every), "a point is in two levels"
        return levels


def check_made(path):
    """Level by level the bed of `make` is twice as dense, and evenly."""
    assert check(path) > 1, "all points are in the root"
    with CopcReader.open(path) as reader:
        spacing = reader.copc_info.spacing
        root = places(reader.query(level=0))
        cells = numpy.unique(numpy.floor((root[:, :2] - root[:, :2].min(axis=0)) / (4 * spacing)), axis=0)
        assert abs(len(root) / len(cells) - 16) < 2, "the root is not even"
        assert len(root) < len(reader.query(resolution=spacing / 2)) < SIDE**2


if __name__ == "__main__":
    {"make": make, "check": check_made}[sys.argv[1]](sys.argv[2])
