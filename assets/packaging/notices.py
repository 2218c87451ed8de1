#!/usr/bin/env python3
"""The licences of the crates that are in the program, with their texts, each text once: what their licences ask a package to carry.

The target that the program is built for is the first argument, or else this computer.
"""

import json
import subprocess
import sys
from pathlib import Path

NAMES = ("license", "licence", "copying", "notice", "unlicense")


def shipped(metadata):
    """The packages that are linked in: what the program depends on itself, and what that depends on, but nothing for tests or builds."""
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    packages = {package["id"]: package for package in metadata["packages"]}
    root = metadata["resolve"]["root"]
    seen, to_see = set(), [root]
    while to_see:
        this = to_see.pop()
        if this in seen:
            continue
        seen.add(this)
        linked = [dep["pkg"] for dep in nodes[this]["deps"] if any(kind["kind"] is None for kind in dep["dep_kinds"])]
        to_see.extend(linked)
    return sorted((packages[one] for one in seen - {root}), key=lambda package: (package["name"], package["version"]))


def texts(package):
    folder = Path(package["manifest_path"]).parent
    files = [path for path in sorted(folder.iterdir()) if path.is_file() and path.name.lower().startswith(NAMES)]
    return [path.read_text(errors="replace").strip() for path in files]


def main():
    host = subprocess.run(["rustc", "-vV"], capture_output=True, text=True, check=True).stdout
    targets = sys.argv[1:] + [line.split()[1] for line in host.splitlines() if line.startswith("host:")]
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", targets[0]]
    metadata = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    users = {}
    print("Bathyscope contains these crates:\n")
    for package in shipped(metadata):
        name = f"{package['name']} {package['version']}"
        print(f"{name}: {package['license'] or 'see its text below'}")
        for text in texts(package):
            users.setdefault(text, []).append(name)
    for text, names in users.items():
        print(f"\n{'-' * 80}\n{', '.join(names)}\n{'-' * 80}\n\n{text}")


main()
