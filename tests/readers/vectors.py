"""GeoJSON by GEOS, KMZ by lxml, GPX by gpxpy, shapefiles by pyshp; places and areas by PROJ."""

import datetime
import json
import zipfile

import gpxpy
import numpy
import pyproj
import rasterio
import shapefile
import shapely.geometry
from common import check_count, check_extent, check_values, into, system, tolerance
from lxml import etree

GEOD = pyproj.Geod(ellps="WGS84")
KML = "{http://www.opengis.net/kml/2.2}"


def check(folder, made, points):
    if "isobaths.geojson" in made:
        check_lines(folder, made, "isobaths")
        check_levels(folder, made)
        check_areas(folder, made)
    if "track.geojson" in made:
        check_lines(folder, made, "track")
        check_track(folder, made, points)
    if "footprint.geojson" in made:
        check_footprint(folder, made)


def features(path):
    return json.loads(path.read_text())["features"]


def bounds(lines):
    every = numpy.concatenate(lines)
    return every.min(axis=0), every.max(axis=0)


def kml(path):
    """The document of a KMZ."""
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None and archive.namelist() == ["doc.kml"]
        return etree.fromstring(archive.read("doc.kml"))


def coordinates(element):
    return numpy.array([[float(part) for part in place.split(",")] for place in element.text.split()])


def check_lines(folder, made, name):
    """The lines of a GeoJSON are those of the KMZ and the shapefile beside it."""
    found = features(folder / name / f"{name}.geojson")
    lines = [numpy.array(feature["geometry"]["coordinates"]) for feature in found]
    assert all(shapely.geometry.shape(feature["geometry"]).is_valid for feature in found)
    record = made[f"{name}.geojson"]
    check_count(name, record, "lines", len(lines))
    if not lines:
        return
    check_extent(name, record, *bounds(lines), 0.001)

    # Each line by itself: a geometry of several kinds is no layer of lines for QGIS. Labels lie in a folder beside them.
    placemarks = kml(folder / name / f"{name}.kmz").findall(f"{KML}Document/{KML}Placemark")
    check_count(f"{name}.kmz", made[f"{name}.kmz"], "lines", len(placemarks))
    for line, placemark in zip(lines, placemarks, strict=True):
        drawn = coordinates(placemark.find(f"{KML}LineString/{KML}coordinates"))
        assert drawn.shape == line.shape and numpy.abs(drawn - line).max() < 1.1e-8, f"{name}.kmz"

    record = made[f"{name}.shp"]
    crs = pyproj.CRS.from_wkt((folder / name / f"{name}.prj").read_text())
    assert crs.to_epsg() == record["crs"]["epsg"] and crs.equals(system(record), ignore_axis_order=True), crs
    with shapefile.Reader(str(folder / name / f"{name}.shp")) as reader:
        assert reader.shapeType == shapefile.POLYLINE
        shapes, rows = reader.shapes(), [row.as_dict() for row in reader.records()]
        box = reader.bbox
    check_count(f"{name}.shp", record, "lines", len(shapes))
    check_extent(f"{name}.shp", record, box[:2], box[2:], 0.0001)
    for line, shape, row, feature in zip(lines, shapes, rows, found, strict=True):
        # Places that are the same once rounded are one in the GeoJSON.
        expected, drawn = into(record, *line.T), numpy.array(shape.points)
        nearest = [numpy.hypot(*(drawn - place).T).min() for place in expected]
        assert max(nearest) < tolerance(record, 0.003), f"{name}.shp is {max(nearest)} off"
        for key in set(row) & set(feature["properties"]) - {"label"}:
            assert abs(row[key] - feature["properties"][key]) < 0.001, key
        length_m = GEOD.line_length(*line.T)
        assert abs(row["length_m"] - length_m) < 0.02 + 0.002 * length_m, (row["length_m"], length_m)


def check_levels(folder, made):
    """Along an isobath the map has its depth: between the centres of four cells, linear along their edges."""
    found = features(folder / "isobaths/isobaths.geojson")
    if "depth.tif" not in made or not found:
        return
    depths = [feature["properties"]["depth_m"] for feature in found]
    check_values("isobaths.geojson", made["isobaths.geojson"], min(depths), max(depths), 1e-9)
    settings = made["isobaths.geojson"]["settings"]["isobaths"]
    for feature in found:
        said = feature["properties"]
        unit_m = {"m": 1.0, "ft": 0.3048, "fm": 1.8288}[said["unit"]]
        assert abs(said["depth"] * unit_m - said["depth_m"]) < 1e-4 and float(said["label"]) == said["depth"], said
    if settings["shoal_safe"]:
        return
    assert not settings["smooth"], "the check is for lines as measured"
    with rasterio.open(folder / "depth/depth.tif") as raster:
        grid, to_cell = raster.read(1).astype(float), ~raster.transform
    worst = 0.0
    for feature, depth_m in zip(found, depths):
        places = into(made["depth.tif"], *numpy.array(feature["geometry"]["coordinates"]).T)
        found_m, step_m = along_edges(grid, numpy.array([to_cell * tuple(place) for place in places]) - 0.5)
        # Places are rounded to a millimetre: up to a hundredth of the smallest cells that are checked here.
        off = numpy.abs(found_m - depth_m) - 0.01 * step_m
        assert numpy.isfinite(off).mean() > 0.9, f"the isobath of {depth_m} m leaves the map"
        worst = max(worst, numpy.nanquantile(off, 0.99))
    assert worst < 0.02, f"an isobath is {worst} m off the map"


def along_edges(grid, places):
    """Depths at places on the edges between the centres of cells, and the steps across these edges; NaN beyond the map.

    Places are given in cells from the first centre.
    """
    from_line = numpy.abs(places - places.round())
    on_column = from_line[:, 0] < from_line[:, 1]
    column = numpy.where(on_column, places[:, 0].round(), numpy.floor(places[:, 0])).astype(int)
    row = numpy.where(on_column, numpy.floor(places[:, 1]), places[:, 1].round()).astype(int)
    share = numpy.where(on_column, places[:, 1] - row, places[:, 0] - column)
    known = numpy.pad(numpy.where(grid > -9999, grid, numpy.nan), ((0, 1), (0, 1)), constant_values=numpy.nan)
    first, last = known[row, column], known[row + on_column, column + ~on_column]
    # At a centre the cell beyond it may be unknown.
    at_first, at_last = numpy.isnan(last) & (share < 0.02), numpy.isnan(first) & (share > 0.98)
    first, last = numpy.where(at_last, last, first), numpy.where(at_first, first, last)
    return first + share * (last - first), numpy.abs(last - first)


def check_areas(folder, made):
    """Bands are valid, do not overlap, and are as large as they say and as the map."""
    found = features(folder / "isobaths/depth_areas.geojson")
    shapes = [shapely.geometry.shape(feature["geometry"]) for feature in found]
    for shape, feature in zip(shapes, found):
        assert shape.is_valid, (feature["properties"], shapely.is_valid_reason(shape))
        area_m2 = abs(GEOD.geometry_area_perimeter(shape)[0])
        said_m2 = feature["properties"]["area_m2"]
        assert abs(area_m2 - said_m2) < 0.05 + 0.002 * said_m2, (area_m2, said_m2)
        assert feature["properties"]["from_m"] < feature["properties"]["to_m"]
    record = made["depth_areas.geojson"]
    check_count("depth_areas.geojson", record, "areas", len(found))
    least = numpy.min([shape.bounds[:2] for shape in shapes], axis=0)
    most = numpy.max([shape.bounds[2:] for shape in shapes], axis=0)
    check_extent("depth_areas.geojson", record, least, most, 0.001)
    for one, other in zip(shapes, shapes[1:]):
        common_m2 = abs(GEOD.geometry_area_perimeter(one.intersection(other))[0])
        assert common_m2 < 0.05, f"two bands share {common_m2} m2"


def check_track(folder, made, points):
    """Every point of the GPX is the place of a ping, in order of time; its length is that of the lines."""
    with open(folder / "track/track.gpx") as file:
        track = gpxpy.parse(file).tracks[0]
    lines = features(folder / "track/track.geojson")
    assert len(track.segments) == len(lines)
    every = [point for segment in track.segments for point in segment.points]
    check_count("track.gpx", made["track.gpx"], "points", len(every))
    places = numpy.array([[point.longitude, point.latitude] for point in every])
    check_extent("track.gpx", made["track.gpx"], places.min(axis=0), places.max(axis=0), 0.001)
    pings = {(round(float(row["lon"]), 8), round(float(row["lat"]), 8)) for row in points.pings if row["lon"]}
    strange = [place for place in places if not near(pings, place)]
    assert not strange, f"{len(strange)} points of the track are no ping's place"
    times = [point.time for point in every]
    if made["track.gpx"]["start_unix_s"] is not None:
        assert all(times) and times == sorted(times)
        zero = datetime.datetime.fromtimestamp(made["track.gpx"]["start_unix_s"], datetime.timezone.utc)
        first_s = float(points.pings[lines[0]["properties"]["ping_from"]]["time_s"])
        assert abs((times[0] - zero).total_seconds() - first_s) < 0.01
    for line in lines:
        length_m = GEOD.line_length(*numpy.array(line["geometry"]["coordinates"]).T)
        said_m = line["properties"]["length_m"]
        assert abs(length_m - said_m) < 0.05 + 0.001 * said_m, (length_m, said_m)


def near(pings, place):
    """Whether a place is a ping's, to the last digit of either."""
    steps = (-1e-8, 0.0, 1e-8)
    lon, lat = place
    return any((round(lon + east, 8), round(lat + north, 8)) in pings for east in steps for north in steps)


def check_footprint(folder, made):
    """The insonified ground: valid, as large as it says, and the ground that the mosaic shows."""
    (feature,) = features(folder / "track/footprint.geojson")
    shape = shapely.geometry.shape(feature["geometry"])
    assert shape.is_valid, shapely.is_valid_reason(shape)
    said_m2 = feature["properties"]["area_m2"]
    area_m2 = abs(GEOD.geometry_area_perimeter(shape)[0])
    assert abs(area_m2 - said_m2) < 0.002 * said_m2, (area_m2, said_m2)
    check_extent("footprint.geojson", made["footprint.geojson"], shape.bounds[:2], shape.bounds[2:], 0.001)
    check_values("footprint.geojson", made["footprint.geojson"], said_m2, said_m2, 0.1)
    outlines = kml(folder / "track/footprint.kmz").findall(f".//{KML}Polygon/{KML}outerBoundaryIs")
    assert len(outlines) == len(shape.geoms)
    drawn = [coordinates(outline.find(f".//{KML}coordinates")) for outline in outlines]
    check_extent("footprint.kmz", made["footprint.kmz"], *bounds(drawn), 0.001)
    if "mosaic.tif" in made:
        check_covers(folder, made["mosaic.tif"], shape)


def check_covers(folder, record, shape):
    """What the mosaic shows lies within the footprint, but for its last half metre."""
    with rasterio.open(folder / "mosaic/mosaic.tif") as raster:
        rows, columns = numpy.nonzero(raster.dataset_mask())
        chosen = numpy.random.default_rng(1).choice(len(rows), 4000)
        places = [raster.xy(rows[one], columns[one]) for one in chosen]
    back = pyproj.Transformer.from_crs(system(record), 4326, always_xy=True)
    lon, lat = back.transform(*numpy.array(places).T)
    inside = shapely.contains_xy(shape, lon, lat).mean()
    assert inside > 0.97, f"only {inside:.1%} of the mosaic lies within the footprint"
