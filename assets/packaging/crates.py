#!/usr/bin/env python3
"""Lists the crates that are in the program for a target.

    crates.py notices TARGET     their licences with their texts, each text once: what the licences ask a package to carry
    crates.py sbom TARGET        a software bill of materials: CycloneDX 1.5 in JSON

The date in the bill is SOURCE_DATE_EPOCH, and its serial number is computed from its content: the same commit makes the same bytes.
"""

import datetime
import json
import os
import re
import subprocess
import sys
import uuid
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NAMES = ("license", "licence", "copying", "notice", "unlicense")
# A package of a registry in Cargo.lock. tomllib is in Python 3.11 only.
LOCKED = re.compile(r'name = "(.*)"\nversion = "(.*)"\nsource = ".*"\nchecksum = "(.*)"')


def cargo(*words):
    return subprocess.run(["cargo", *words, "--locked"], capture_output=True, text=True, check=True, cwd=ROOT).stdout


def shipped(target):
    """What the program itself depends on, and what that depends on, but nothing for tests or builds.

    Returns the packages, the program first and then the others by name, and for each package's id the ids of those that it depends on.
    """
    metadata = json.loads(cargo("metadata", "--format-version", "1", "--filter-platform", target))
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    packages = {package["id"]: package for package in metadata["packages"]}
    # The graph of `cargo metadata` has the optional crates that tests alone ask for too; `cargo tree` leaves these out.
    tree = cargo("tree", "--edges", "normal", "--target", target, "--prefix", "none", "--format", "{p}")
    built = {tuple(line.split()[:2]) for line in tree.splitlines() if line}
    inside = {one for one, package in packages.items() if (package["name"], f"v{package['version']}") in built}
    root = metadata["resolve"]["root"]
    linked, to_see = {}, [root]
    while to_see:
        this = to_see.pop()
        if this not in linked:
            normal = [dep["pkg"] for dep in nodes[this]["deps"] if any(kind["kind"] is None for kind in dep["dep_kinds"])]
            linked[this] = [one for one in normal if one in inside]
            to_see.extend(linked[this])
    return sorted((packages[one] for one in linked), key=lambda package: (package["id"] != root, package["name"], package["version"])), linked


def texts(package):
    folder = Path(package["manifest_path"]).parent
    files = [path for path in sorted(folder.iterdir()) if path.is_file() and path.name.lower().startswith(NAMES)]
    return [path.read_text(errors="replace").strip() for path in files]


def notices(target):
    users = {}
    print("Bathyscope contains these crates:\n")
    for package in shipped(target)[0]:
        if not package["source"]:
            continue  # The crates of this repository have the licence of the program.
        name = f"{package['name']} {package['version']}"
        print(f"{name}: {package['license'] or 'see its text below'}")
        for text in texts(package):
            users.setdefault(text, []).append(name)
    for text, names in users.items():
        print(f"\n{'-' * 80}\n{', '.join(names)}\n{'-' * 80}\n\n{text}")


def purl(package):
    return f"pkg:cargo/{package['name']}@{package['version']}"


def component(package, checksums):
    kind = "application" if package["name"] == "bathyscope" else "library"
    this = {"type": kind, "bom-ref": purl(package), "name": package["name"], "version": package["version"], "purl": purl(package)}
    if package["source"]:
        this["hashes"] = [{"alg": "SHA-256", "content": checksums[package["name"], package["version"]]}]
    if package["license"]:
        # Some crates still have the old sign for OR.
        this["licenses"] = [{"expression": re.sub(r"\s*/\s*", " OR ", package["license"])}]
    return this


def sbom(target):
    (program, *crates), linked = shipped(target)
    purls = {package["id"]: purl(package) for package in [program, *crates]}
    checksums = {(name, version): checksum for name, version, checksum in LOCKED.findall((ROOT / "Cargo.lock").read_text())}
    date = datetime.datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), datetime.timezone.utc)
    bill = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {
            "timestamp": date.strftime("%Y-%m-%dT%H:%M:%SZ"),
            "component": component(program, checksums),
            "properties": [{"name": "target", "value": target}],
        },
        "components": [component(package, checksums) for package in crates],
        "dependencies": [{"ref": purls[one], "dependsOn": sorted({purls[other] for other in linked[one]})} for one in purls],
    }
    bill["serialNumber"] = f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, json.dumps(bill))}"
    print(json.dumps(bill, indent=1))


{"notices": notices, "sbom": sbom}[sys.argv[1]](sys.argv[2])
