#!/usr/bin/env python3
"""Writes golden.json: where a transducer is under an antenna, and where metres of some systems lie, by pyproj (3.7.2 then)."""
import json
import math
import pathlib

from pyproj import CRS, Geod, Transformer, __version__

geod = Geod(ellps="WGS84")
arms = []
for lon, lat, heading, forward, right in [
    (-82.110, 29.410, 0.0, 3.2, -1.1), (-82.110, 29.410, 37.0, 3.2, -1.1), (-82.110, 29.410, 123.5, -6.0, 0.4),
    (10.3951, 63.4305, 251.0, 12.0, 2.5), (151.2093, -33.8688, 310.25, -0.8, -0.35), (-179.99999, 5.0, 270.0, 4.0, 0.0)]:
    azimuth = heading + math.degrees(math.atan2(right, forward))
    x, y, _ = geod.fwd(lon, lat, azimuth, math.hypot(forward, right))
    arms.append(dict(lon=lon, lat=lat, heading_deg=heading, forward_m=forward, right_m=right, to_lon=x, to_lat=y))
metres = []
for epsg, x, y in [(32618, 606900.0, 4732000.0), (32633, 412000.0, 5730000.0), (32756, 334000.0, 6252000.0), (25832, 691000.0, 5334000.0), (26918, 606900.0, 4732000.0), (2193, 1750000.0, 5425000.0), (3857, -8203600.0, 5271000.0)]:
    lon, lat = Transformer.from_crs(epsg, CRS(epsg).geodetic_crs, always_xy=True).transform(x, y)
    metres.append(dict(epsg=epsg, east_m=x, north_m=y, lon=lon, lat=lat))
text = json.dumps(dict(pyproj=__version__, arms=arms, metres=metres), indent=1)
pathlib.Path(__file__).with_name("golden.json").write_text(text + "\n")
