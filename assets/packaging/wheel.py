#!/usr/bin/env python3
"""Makes a wheel that carries the program: `pip install` puts it onto the path of the environment, without any Python code.

A wheel of this kind is a zip of the program, four short files and their hashes. The standard library writes it; maturin, which others use
for it, would have to build the program once more by itself.

    wheel.py PROGRAM THIRD-PARTY GLIBC ARCHITECTURE FOLDER
"""

import base64
import hashlib
import json
import subprocess
import sys
from pathlib import Path

import zip_files

ROOT = Path(__file__).parents[2]


def main(program, notices, glibc, architecture, folder):
    command = ["cargo", "metadata", "--format-version", "1", "--no-deps"]
    members = json.loads(subprocess.run(command, capture_output=True, check=True, cwd=ROOT).stdout)["packages"]
    (package,) = [member for member in members if member["name"] == "bathyscope"]
    name, version = package["name"], package["version"]
    tag = f"py3-none-manylinux_{glibc.replace('.', '_')}_{architecture}"
    info = f"{name}-{version}.dist-info"
    licences = [ROOT / "LICENSE-MIT", ROOT / "LICENSE-APACHE", Path(notices)]
    metadata = [
        "Metadata-Version: 2.4",
        f"Name: {name}",
        f"Version: {version}",
        f"Summary: {package['description']}",
        f"License-Expression: {package['license']}",
        *(f"License-File: {path.name}" for path in licences),
        "Requires-Python: >=3.7",
        "Description-Content-Type: text/markdown",
        "",
        (ROOT / "README.md").read_text(),
    ]
    wheel = ["Wheel-Version: 1.0", "Generator: bathyscope", "Root-Is-Purelib: false", f"Tag: {tag}", ""]
    files = [
        (f"{name}-{version}.data/scripts/{name}", Path(program).read_bytes(), True),
        (f"{info}/METADATA", "\n".join(metadata).encode(), False),
        (f"{info}/WHEEL", "\n".join(wheel).encode(), False),
        *((f"{info}/licenses/{path.name}", path.read_bytes(), False) for path in licences),
    ]
    record = [f"{path},{digest(content)},{len(content)}" for path, content, _ in files]
    record += [f"{info}/RECORD,,", ""]
    files.append((f"{info}/RECORD", "\n".join(record).encode(), False))
    zip_files.write(Path(folder) / f"{name}-{version}-{tag}.whl", files)


def digest(content):
    """A hash as RECORD has it."""
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()


main(*sys.argv[1:])
