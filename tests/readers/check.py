#!/usr/bin/env python3
"""Opens every product in a folder of `bathyscope process` with independent readers; fails on the first that disagrees."""

import json
import sys
from pathlib import Path

import clouds
import rasters
import tables
import vectors

# What describes other files, is for people, or belongs to something with a record.
WITHOUT_RECORD = {"report.json", "report.html", "chips"}
COMPANIONS = {".shx", ".dbf", ".prj", ".cpg", ".qml"}


def records(folder):
    """The record of each product, all products having one and all records a product."""
    found = {}
    for path in sorted(folder.iterdir()):
        if path.name in WITHOUT_RECORD or path.suffix in COMPANIONS:
            continue
        if path.suffix == ".json" and (folder / path.stem).is_file():
            continue
        record = path.with_name(path.name + ".json")
        assert record.is_file(), f"{path.name} has no record"
        found[path.name] = json.loads(record.read_text())
        assert found[path.name]["product"] == path.name
    return found


def check(folder):
    """All checks of a folder; how many products were opened."""
    report = json.loads((folder / "report.json").read_text())
    made = records(folder)
    for name, record in made.items():
        assert record["inputs"] == report["inputs"], f"{name}: other inputs than the report"
        assert record["statement"] == report["statement"], f"{name}: another statement than the report"
        for key, value in record["settings"].items():
            assert report["settings"][key] == value, f"{name}: {key} is not as in the report"
    points = tables.check(folder, report, made)
    clouds.check(folder, made, points)
    rasters.check(folder, made, points)
    vectors.check(folder, made, points)
    tables.check_found(folder, made)
    return len(made)


if __name__ == "__main__":
    print(f"{check(Path(sys.argv[1]))} products agree with their records, the report and cloud.csv")
