"""The CSV tables against each other and the report; they are what the other products are compared with."""

import copy
import csv
import json

import gpxpy
import lxml.html
import numpy
import plyfile
from common import check_count, check_extent, check_values

SOURCES = {"downscan": 0, "port": 1, "starboard": 2}


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


class Points:
    """cloud.csv: all points, and the confidence of the first return that each is (-1 for a sounding, whose level is 0)."""

    def __init__(self, folder):
        all_rows = rows(folder / "points/cloud.csv")
        self.source = numpy.array([SOURCES[row["source"]] for row in all_rows])
        self.ping = numpy.array([int(row["ping"]) for row in all_rows])
        self.classes = numpy.array([int(row["class"]) for row in all_rows])
        assert all((row["kept"] == "1") == (row["class"] == "40") for row in all_rows), "kept says other than class"
        column = lambda name: numpy.array([float(row[name]) for row in all_rows])
        self.lon, self.lat = column("lon"), column("lat")
        self.local = numpy.array([column("east_m"), column("north_m"), column("z_m")]).T
        self.z = self.local[:, 2]
        self.range = column("range_m")
        assert all((row["level"] == "") == (row["source"] == "downscan") for row in all_rows), "a level where there is none"
        self.level = numpy.array([int(row["level"] or 0) for row in all_rows])
        self.pings = rows(folder / "points/first_returns.csv")
        names = {1: "port_confidence", 2: "starboard_confidence"}
        confidence = lambda source, ping: float(self.pings[ping][names[source]]) if source else -1.0
        self.confidence = numpy.array([confidence(*pair) for pair in zip(self.source, self.ping)])

    def only(self, chosen):
        """Those of a mask or an order."""
        some = copy.copy(self)
        for name in ("source", "ping", "classes", "lon", "lat", "local", "z", "range", "level", "confidence"):
            setattr(some, name, getattr(self, name)[chosen])
        return some

    def kept(self):
        """Those that count for the depth map."""
        return self.only(self.classes == 40)


def check(folder, report, made):
    points = Points(folder)
    counts = report["counts"]
    assert len(points.z) == counts["points"], "cloud.csv has not as many points as the report"
    classes, numbers = numpy.unique(points.classes, return_counts=True)
    assert dict(zip(map(str, classes), numbers)) == counts["classes"], "cloud.csv has other classes than the report"
    assert counts["kept"] == counts["classes"].get("40", 0)
    assert counts["outliers_removed"] == sum(counts["classes"].get(noise, 0) for noise in ("7", "18"))
    assert len(points.pings) == counts["pings"], "first_returns.csv has not as many pings as the report"
    record = made["cloud.csv"]
    check_count("cloud.csv", record, "points", len(points.z))
    places = numpy.array([points.lon, points.lat]).T
    check_extent("cloud.csv", record, places.min(axis=0), places.max(axis=0), 0.001)
    check_values("cloud.csv", record, points.z.min(), points.z.max(), 0.0001)
    check_count("first_returns.csv", made["first_returns.csv"], "pings", len(points.pings))
    for side in ("port", "starboard"):
        found = sum(bool(row[f"{side}_sample"]) for row in points.pings)
        assert found == counts[f"{side}_first_returns"], f"{found} first returns to {side}"
    if "residuals.json" in made:
        comparisons = json.loads((folder / "quality/residuals.json").read_text())["comparisons"]
        check_count("residuals.json", made["residuals.json"], "comparisons", len(comparisons))
        assert all(one["n"] > 0 for one in comparisons)
    if "storage.csv" in made:
        table = [[float(value) for value in row.values()] for row in rows(folder / "isobaths/storage.csv")]
        check_count("storage.csv", made["storage.csv"], "levels", len(table))
        assert all(numpy.all(numpy.diff(column) <= 0) for column in list(zip(*table))[1:])
    return points


def check_shapes(path, record, found):
    """The bodies of the objects against the sizes that the table of their boxes states."""
    read = plyfile.PlyData.read(path)
    corners = read["vertex"]
    places = numpy.array([corners["x"], corners["y"], corners["z"]]).T
    shapes = {int(row["object"]): row for row in found if row["shape"]}
    assert set(shapes) == set(corners["object"]), "other objects than the table has"
    check_count("shapes.ply", record, "objects", len(shapes))
    if not shapes:
        return
    check_extent("shapes.ply", record, places[:, :2].min(axis=0), places[:, :2].max(axis=0), 0.001)
    check_values("shapes.ply", record, places[:, 2].min(), places[:, 2].max(), 0.001)
    for number, row in shapes.items():
        body = places[corners["object"] == number]
        heading = numpy.radians(float(row["shape_heading_deg"] or 0.0))
        axes = numpy.array([[numpy.sin(heading), numpy.cos(heading)], [numpy.cos(heading), -numpy.sin(heading)]])
        along, across = (body[:, :2] @ axes.T).T
        sizes = [numpy.ptp(along), numpy.ptp(across), numpy.ptp(body[:, 2])]
        stated = [float(row[f"shape_{name}_m"]) for name in ("length", "width", "height")]
        # The sides stand in squares of a fortieth, and the heading is whole degrees in the table.
        for size, said in zip(sizes, stated):
            assert abs(size - said) <= 0.02 + 0.06 * said + 0.01 * stated[0], f"object {number}: {size}, not {said}"
    assert max(max(face) for face in read["face"]["vertex_indices"]) < len(places)


def check_found(folder, made):
    """The detector's boxes, and the page, where they were made."""
    if (folder / "objects/detections.csv").is_file():
        found = rows(folder / "objects/detections.csv")
        features = json.loads((folder / "objects/detections.geojson").read_text())["features"]
        listed = rows(folder / "objects/objects.csv")
        with open(folder / "objects/detections.gpx") as file:
            waypoints = gpxpy.parse(file).waypoints
        check_count("detections.csv", made["detections.csv"], "boxes", len(found))
        # A point for each object, at the mean of the places of its boxes.
        for name, count in (("detections.geojson", len(features)), ("detections.gpx", len(waypoints)), ("objects.csv", len(listed))):
            check_count(name, made[name], "objects", count)
        objects = {}
        for box in found:
            if box["object"]:
                objects.setdefault(int(box["object"]), []).append([float(box["lon"]), float(box["lat"])])
        assert 0 < len(waypoints) == len(features) == len(listed) == len(objects)
        for waypoint, feature, row in zip(waypoints, features, listed):
            boxes = numpy.array(objects[int(row["number"])])
            at = numpy.array([float(row["lon"]), float(row["lat"])])
            assert feature["properties"]["number"] == int(row["number"])
            assert numpy.allclose(at, feature["geometry"]["coordinates"], atol=1e-8)
            assert numpy.allclose(at, [waypoint.longitude, waypoint.latitude], atol=1e-8)
            assert (boxes.min(axis=0) - 1e-8 <= at + 1e-5).all() and (at - 1e-5 <= boxes.max(axis=0) + 1e-8).all()
        assert len(list((folder / "objects/chips").glob("*.png"))) == len(found), "a box without a chip"
        check_shapes(folder / "objects/shapes.ply", made["shapes.ply"], found)
    page = folder / "report.html"
    if page.is_file():
        tree = lxml.html.fromstring(page.read_bytes())
        outside = [link for _, _, link, _ in tree.iterlinks() if not link.startswith(("data:", "#"))]
        assert not outside, f"report.html leans on {outside}"
