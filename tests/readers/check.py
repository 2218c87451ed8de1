#!/usr/bin/env python3
"""Opens every product in a folder of `bathyscope process` with independent readers; fails on the first that disagrees."""

import hashlib
import json
import sys
from pathlib import Path

import clouds
import meshes
import packages
import rasters
import tables
import tiles
import vectors

# Of the run as a whole.
OF_THE_RUN = ("program", "run", "inputs", "preset", "settings", "statement", "start_unix_s")


def records(folder):
    """What the manifest says of each file that holds something, by its name without the folder: it names all files, and no other."""
    manifest = json.loads((folder / "manifest.json").read_text())
    there = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()} - {"manifest.json"}
    named = {file["file"]: file for file in manifest["files"]}
    assert there == set(named), f"the manifest and the folder differ in {there ^ set(named)}"
    for name, file in named.items():
        content = (folder / name).read_bytes()
        assert len(content) == file["bytes"], f"{name}: {len(content)} bytes, not {file['bytes']}"
        assert hashlib.sha256(content).hexdigest() == file["sha256"], f"{name}: another hash than the manifest"
        assert "what" in file or file["belongs_to"], f"{name}: nothing says what it is"
    common = {key: manifest[key] for key in OF_THE_RUN}
    return {Path(name).name: common | file for name, file in named.items() if "count" in file}


def check(folder):
    """All checks of a folder; how many products were opened."""
    report = json.loads((folder / "report.json").read_text())
    made = records(folder)
    for key in OF_THE_RUN:
        assert made["cloud.csv"][key] == report[key], f"{key} is not as in the report"
    points = tables.check(folder, report, made)
    clouds.check(folder, made, points)
    rasters.check(folder, made, points.kept())
    meshes.check(folder, made)
    tiles.check(folder, made)
    vectors.check(folder, made, points.kept())
    packages.check(folder, made, points.kept())
    tables.check_found(folder, made)
    return len(made)


if __name__ == "__main__":
    print(f"{check(Path(sys.argv[1]))} products agree with the manifest, the report and cloud.csv")
