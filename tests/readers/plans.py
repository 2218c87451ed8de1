#!/usr/bin/env python3
"""Opens the four files of one plan with readers that are not ours: gpxpy, lxml, pymavlink, and a schema of QGroundControl's developer guide.

Arguments: the folder that holds lines.gpx, lines.kml, lines.plan, lines.waypoints and lines.json (what the command printed).
"""

import json
import sys
from pathlib import Path

import gpxpy
import jsonschema
import numpy
import pyproj
from lxml import etree
from pymavlink import mavutil, mavwp

GEOD = pyproj.Geod(ellps="WGS84")
KML = "{http://www.opengis.net/kml/2.2}"

# https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html
NUMBER, POSITION = {"type": "number"}, {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
ITEM = {
    "type": "object",
    "required": ["type", "autoContinue", "command", "doJumpId", "frame", "params"],
    "properties": {
        "type": {"const": "SimpleItem"},
        "AMSLAltAboveTerrain": {"type": ["number", "null"]},
        "Altitude": NUMBER,
        "AltitudeMode": {"enum": [0, 1, 2, 3]},
        "autoContinue": {"type": "boolean"},
        "command": {"const": mavutil.mavlink.MAV_CMD_NAV_WAYPOINT},
        "doJumpId": {"type": "integer", "minimum": 1},
        "frame": {"const": mavutil.mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT},
        "params": {"type": "array", "items": {"type": ["number", "null"]}, "minItems": 7, "maxItems": 7},
    },
}
PLAN = {
    "type": "object",
    "required": ["version", "fileType", "groundStation", "mission"],
    "properties": {
        "version": {"const": 1},
        "fileType": {"const": "Plan"},
        "groundStation": {"type": "string"},
        "geoFence": {"type": "object", "required": ["circles", "polygons", "version"]},
        "rallyPoints": {"type": "object", "required": ["points", "version"]},
        "mission": {
            "type": "object",
            "required": ["version", "firmwareType", "cruiseSpeed", "hoverSpeed", "vehicleType", "plannedHomePosition", "items"],
            "properties": {
                "version": {"const": 2},
                "firmwareType": {"const": mavutil.mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA},
                "vehicleType": {"const": mavutil.mavlink.MAV_TYPE_SURFACE_BOAT},
                "globalPlanAltitudeMode": {"enum": [0, 1, 2, 3]},
                "cruiseSpeed": NUMBER,
                "hoverSpeed": NUMBER,
                "plannedHomePosition": POSITION,
                "items": {"type": "array", "items": ITEM, "minItems": 1},
            },
        },
    },
}


def of_gpx(path):
    """Places of the route; the waypoints are the ends of its lines, by name."""
    with open(path) as file:
        gpx = gpxpy.parse(file)
    (route,) = gpx.routes
    named = {point.name: point for point in route.points if point.name != "turn"}
    assert len(gpx.waypoints) == len(named) >= 2
    for point in gpx.waypoints:
        on_route = named[point.name]
        assert (point.latitude, point.longitude) == (on_route.latitude, on_route.longitude), point.name
    return [(point.longitude, point.latitude) for point in route.points], named


def of_kml(path):
    """Places of the way; every line is a part of it."""
    marks = etree.parse(str(path)).findall(f".//{KML}Placemark")
    places = {}
    for mark in marks:
        text = mark.find(f"{KML}LineString/{KML}coordinates").text
        places[mark.find(f"{KML}name").text] = [tuple(float(part) for part in place.split(",")) for place in text.split()]
    way = places.pop("way")
    for name, ends in places.items():
        assert ends[1] == way[way.index(ends[0]) + 1], name
    return way, len(places)


def of_plan(path):
    plan = json.loads(path.read_text())
    jsonschema.validate(plan, PLAN)
    items = plan["mission"]["items"]
    assert [item["doJumpId"] for item in items] == list(range(1, len(items) + 1))
    home = plan["mission"]["plannedHomePosition"]
    return [(item["params"][5], item["params"][4]) for item in items], (home[1], home[0]), plan["mission"]["cruiseSpeed"]


def of_waypoints(path):
    loader = mavwp.MAVWPLoader()
    count = loader.load(str(path))
    points = [loader.wp(index) for index in range(count)]
    assert [point.seq for point in points] == list(range(count))
    assert all(point.command == mavutil.mavlink.MAV_CMD_NAV_WAYPOINT and point.autocontinue for point in points)
    assert points[0].frame == mavutil.mavlink.MAV_FRAME_GLOBAL and points[0].current
    assert all(point.frame == mavutil.mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT for point in points[1:])
    places = [(point.y, point.x) for point in points]
    return places[1:], places[0]


def apart_m(one, other):
    one, other = numpy.array(one).T, numpy.array(other).T
    return GEOD.inv(*one, *other)[2].max()


def check(folder):
    printed = json.loads((folder / "lines.json").read_text())
    way, named = of_gpx(folder / "lines.gpx")
    drawn, lines = of_kml(folder / "lines.kml")
    mission, home, speed = of_plan(folder / "lines.plan")
    text, text_home = of_waypoints(folder / "lines.waypoints")
    assert lines == len(printed["lines"]) == len(named) / 2
    for number, line in enumerate(printed["lines"], 1):
        for key, end in (("start", "from"), ("end", "to")):
            point = named[f"L{number} {key}"]
            assert apart_m([(point.longitude, point.latitude)], [tuple(line[end])]) < 0.003
    # pymavlink keeps places in 32 bits, which is half a metre.
    for name, places, most_m in (("kml", drawn, 0.003), ("plan", mission, 0.003), ("waypoints", text, 1.5)):
        assert len(places) == len(way), f"{name}: {len(places)} places, not {len(way)}"
        assert apart_m(way, places) < most_m, f"{name}: {apart_m(way, places)} m off"
    assert apart_m([home], [text_home]) < 1.5 and apart_m([home], [way[0]]) < 5000
    assert abs(speed - printed["speed_mps"]) < 1e-9
    length_m = GEOD.line_length(*numpy.array(way).T)
    assert abs(length_m / printed["length_m"] - 1) < 0.02, (length_m, printed["length_m"])
    return len(way), lines


if __name__ == "__main__":
    places, lines = check(Path(sys.argv[1]))
    print(f"{lines} lines, {places} places of the way: the same in four formats")
