"""What `isobaths.clip` leaves of lines, areas and spot soundings, against what GEOS leaves of those of a run without it.

clips.py make WHOLE SHORE    writes a shoreline with an island across the map of a run
clips.py check WHOLE CLIPPED SHORE
"""

import json
import math
import sys
from collections import defaultdict
from pathlib import Path

import numpy
import shapely
from shapely.geometry import shape

# Coordinates have eight digits, about a millimetre.
APART_M = 0.003
EARTH_M = 111_320.0


def features(folder, name):
    return json.loads((Path(folder) / "isobaths" / name).read_text())["features"]


def in_metres(geometry, middle_deg):
    scale = [EARTH_M * math.cos(math.radians(middle_deg)), EARTH_M]
    return shapely.transform(geometry, lambda places: places[:, :2] * scale)


def make(whole, shore):
    """A shore of many corners about the middle of the longest isobath, and an island in it."""
    areas = [shape(feature["geometry"]) for feature in features(whole, "depth_areas.geojson")]
    west, south, east, north = shapely.union_all([area.envelope for area in areas]).bounds
    width, height = east - west, north - south
    longest = max((shape(feature["geometry"]) for feature in features(whole, "isobaths.geojson")), key=lambda line: line.length)
    middle = longest.interpolate(0.5, normalized=True)
    turns = numpy.linspace(0.0, 2.0 * math.pi, 400, endpoint=False)

    def ring(across, up, size, waves):
        out = size * (1.0 + 0.2 * numpy.sin(waves * turns))
        places = zip(middle.x + width * (across + out * numpy.cos(turns)), middle.y + height * (up + out * numpy.sin(turns)))
        places = [[float(lon), float(lat)] for lon, lat in places]
        return [*places, places[0]]

    polygon = {"type": "Polygon", "coordinates": [ring(0.0, 0.0, 0.33, 9), ring(-0.03, 0.02, 0.1, 5)[::-1]]}
    Path(shore).write_text(json.dumps({"type": "Feature", "properties": {}, "geometry": polygon}))


def check(whole, clipped, shore):
    shore = shape(json.loads(Path(shore).read_text())["geometry"])
    middle_deg = shore.centroid.y
    area = in_metres(shore, middle_deg)
    said = [check_lines(whole, clipped, area, middle_deg), check_areas(whole, clipped, area, middle_deg)]
    soundings = [shape(feature["geometry"]) for feature in features(clipped, "spot_soundings.geojson")]
    assert soundings, "no spot sounding is left"
    out = [place for place in soundings if in_metres(place, middle_deg).distance(area) > APART_M]
    assert not out, f"{len(out)} spot soundings lie outside"
    print(f"{'; '.join(said)}; {len(soundings)} spot soundings, all within")


def check_lines(whole, clipped, area, middle_deg):
    def by_depth(folder):
        lines = defaultdict(list)
        for feature in features(folder, "isobaths.geojson"):
            lines[feature["properties"]["depth_m"]].append(in_metres(shape(feature["geometry"]), middle_deg))
        return {depth: shapely.MultiLineString(one) for depth, one in lines.items()}

    before, after = by_depth(whole), by_depth(clipped)
    all_m = ours_m = theirs_m = apart_m = 0.0
    for depth, lines in before.items():
        theirs = lines.intersection(area)
        ours = after.pop(depth, shapely.MultiLineString())
        all_m, ours_m, theirs_m = all_m + lines.length, ours_m + ours.length, theirs_m + theirs.length
        for one, other in [(ours, theirs), (theirs, ours)]:
            apart_m += one.difference(other.buffer(APART_M)).length
    assert not after, f"isobaths of {list(after)} m are new"
    assert 0.1 * all_m < theirs_m < 0.9 * all_m, "the shore cuts too little to show anything"
    # A part of less than a centimetre is left out.
    assert apart_m < 0.2 and abs(ours_m - theirs_m) < 1e-4 * theirs_m, (ours_m, theirs_m, apart_m)
    return f"isobaths {ours_m:.3f} m of {all_m:.0f} m, by GEOS {theirs_m:.3f} m, {apart_m:.4f} m apart"


def check_areas(whole, clipped, area, middle_deg):
    def by_depth(folder):
        found = features(folder, "depth_areas.geojson")
        return {feature["properties"]["from_m"]: in_metres(shape(feature["geometry"]), middle_deg) for feature in found}

    before, after = by_depth(whole), by_depth(clipped)
    ours_m2 = theirs_m2 = apart_m2 = 0.0
    for depth, one in before.items():
        ours = after.pop(depth, shapely.MultiPolygon())
        assert ours.is_valid, shapely.is_valid_reason(ours)
        theirs = shapely.make_valid(one).intersection(area)
        ours_m2, theirs_m2 = ours_m2 + ours.area, theirs_m2 + theirs.area
        apart_m2 += ours.symmetric_difference(theirs).area
    assert not after, f"areas from {list(after)} m are new"
    assert apart_m2 < 1e-3 * theirs_m2, (ours_m2, theirs_m2, apart_m2)
    return f"areas {ours_m2:.3f} m2, by GEOS {theirs_m2:.3f} m2, symmetric difference {apart_m2:.4f} m2"


if __name__ == "__main__":
    {"make": make, "check": check}[sys.argv[1]](*sys.argv[2:])
