"""What the checks share."""

import numpy
import pyproj


def system(record):
    """The coordinate reference system of a record."""
    return pyproj.CRS.from_epsg(record["crs"]["epsg"])


def into(record, lon, lat):
    """Places in the system of a record, by PROJ."""
    bring = pyproj.Transformer.from_crs(4326, system(record), always_xy=True)
    return numpy.array(bring.transform(numpy.asarray(lon), numpy.asarray(lat))).T


def tolerance(record, metres):
    """Metres, in the unit of a record."""
    return metres / 90_000 if record["crs"]["unit"] == "degree" else metres


def check_extent(name, record, least, most, metres):
    """The extent of a record against the least and most x, y that were found."""
    extent = record["extent"]
    said = [extent[side] for side in ("west", "south", "east", "north")]
    worst = numpy.abs(numpy.array(said) - [*least, *most]).max()
    assert worst <= tolerance(record, metres), f"{name}: the extent is off by {worst}"


def check_count(name, record, what, count):
    """The count of a record."""
    assert record["count"] == {what: count}, f"{name}: {count} {what}, not {record['count']}"


def check_values(name, record, least, most, metres):
    """The range of values of a record."""
    values = record["values"]
    off = max(abs(values["least"] - least), abs(values["most"] - most))
    assert off <= metres, f"{name}: values from {least} to {most}, not {values}"


def same(name, found, expected, most):
    off = numpy.abs(numpy.asarray(found) - expected).max()
    assert off <= most, f"{name} is off by {off}"
