"""cloud.copc.laz by laspy, as LAZ and as COPC, cloud.ply by plyfile, cloud.xyz by numpy, against cloud.csv."""

import laspy
import numpy
import octree
import plyfile
from common import check_count, check_extent, check_values, into, same, system, tolerance

COLOURS = numpy.array([[0, 0, 0], [0, 0, 255], [255, 0, 0]])


def check(folder, made, points):
    if "cloud.copc.laz" in made:
        check_laz(folder / "points/cloud.copc.laz", made["cloud.copc.laz"], points)
        check_ply(folder / "points/cloud.ply", made["cloud.ply"], points)
        check_xyz(folder / "points/cloud.xyz", made["cloud.xyz"], points.kept())


def check_record(name, record, xyz):
    check_count(name, record, "points", len(xyz))
    check_extent(name, record, xyz[:, :2].min(axis=0), xyz[:, :2].max(axis=0), 0.001)
    check_values(name, record, xyz[:, 2].min(), xyz[:, 2].max(), 0.001)


def check_laz(path, record, points):
    las = laspy.read(path)
    header = las.header
    octree.check(path)
    # By side and ping, of which no two are the same: COPC has an order of its own.
    points, las = points.only(numpy.lexsort((points.ping, points.source))), las[numpy.lexsort((las.ping, las.side))]
    assert (header.version.major, header.version.minor) == (1, 4)
    assert header.global_encoding.wkt, "the bit for WKT is not set"
    assert header.parse_crs().to_epsg() == record["crs"]["epsg"], header.parse_crs()
    assert not system(record).is_geographic == (record["crs"]["unit"] == "metre")
    xyz = numpy.array([las.x, las.y, las.z]).T
    check_record("cloud.copc.laz", record, xyz)
    same("x, y of cloud.copc.laz", xyz[:, :2], into(record, points.lon, points.lat), tolerance(record, 0.002))
    same("z of cloud.copc.laz", las.z, points.z, 0.0011)
    same("colour of cloud.copc.laz", numpy.array([las.red, las.green, las.blue]).T // 257, COLOURS[points.source], 0)
    assert list(header.point_format.extra_dimension_names) == ["source", "ping", "side", "confidence", "range_m"]
    same("source of cloud.copc.laz", las.source, points.source > 0, 0)
    same("ping of cloud.copc.laz", las.ping, points.ping, 0)
    same("side of cloud.copc.laz", las.side, points.source, 0)
    # A first return above the recorded depth that counts as bottom all the same has the confidence of bottom, which is higher.
    raised = las.confidence > points.confidence + 0.00051
    assert (points.classes[raised] != 64).all(), "an above-bottom return with the confidence of bottom"
    same("confidence of cloud.copc.laz", las.confidence[~raised], points.confidence[~raised], 0.00051)
    same("range of cloud.copc.laz", las.range_m, points.range, 0.00051)
    check_classes(las, points)
    check_intensity(las, points)
    check_time(las, record, points)
    no_data = header.point_format.dimension_by_name("confidence").no_data
    assert no_data is None or no_data[0] == -1.0, no_data


def check_classes(las, points):
    """The class of each point, its name in the header, and the flag of those that no map is made of."""
    same("classes of cloud.copc.laz", las.classification, points.classes, 0)
    same("withheld of cloud.copc.laz", las.withheld, points.classes != 40, 0)
    names = las.header.vlrs.get("ClassificationLookupVlr")[0].lookups
    assert names[40] == "bathymetric" and names[64] == "above bottom", names
    assert all(names[code] for code in numpy.unique(points.classes)), "a class without a name"


def check_intensity(las, points):
    """Echo levels of one byte in the upper range of two; soundings have none."""
    intensity = numpy.asarray(las.intensity)
    of_side_scan = intensity[points.source > 0]
    same("intensity of cloud.copc.laz", intensity, 257 * points.level, 0)
    assert (of_side_scan > 0).mean() > 0.99 and len(numpy.unique(of_side_scan)) > 20, "the intensity says nothing"


def check_time(las, record, points):
    """Adjusted standard GPS time where the log knows the time; soundings are not in the table of pings."""
    start = record["start_unix_s"]
    assert las.header.global_encoding.gps_time_type == laspy.header.GpsTimeType.STANDARD if start else True
    of_ping = points.source > 0
    times = numpy.array([float(points.pings[ping]["time_s"]) for ping in points.ping[of_ping]])
    if start:
        leaps = 15 + sum(start >= since for since in (1341100800, 1435708800, 1483228800))
        times += start - 315964800 + leaps - 1e9
    same("GPS time of cloud.copc.laz", las.gps_time[of_ping], times, 0.00051)


def check_ply(path, record, points):
    vertices = plyfile.PlyData.read(path)["vertex"]
    xyz = numpy.array([vertices[axis] for axis in "xyz"]).T
    check_record("cloud.ply", record, xyz)
    same("x, y, z of cloud.ply", xyz, points.local, 0.000051)
    colours = numpy.array([vertices[name] for name in ("red", "green", "blue")]).T
    same("colour of cloud.ply", colours.astype(int), COLOURS[points.source], 0)
    same("level of cloud.ply", vertices["intensity"], points.level, 0)
    same("classes of cloud.ply", vertices["classification"], points.classes, 0)
    same("range of cloud.ply", vertices["range_m"], points.range, 0.00051)


def check_xyz(path, record, points):
    xyz = numpy.loadtxt(path, ndmin=2)
    check_record("cloud.xyz", record, xyz)
    same("x, y of cloud.xyz", xyz[:, :2], into(record, points.lon, points.lat), tolerance(record, 0.001))
    same("z of cloud.xyz", xyz[:, 2], points.z, 0.00051)
