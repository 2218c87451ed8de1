#!/usr/bin/env python3
"""Makes a wheel that carries the program: `pip install` puts it onto the path of the environment, without any Python code.

A wheel of this kind is a zip of the program, four short files and their hashes. The standard library writes it; maturin, which others use
for it, would have to build the program once more by itself.

    wheel.py PROGRAM THIRD-PARTY GLIBC FOLDER
"""

import base64
import hashlib
import os
import platform
import stat
import sys
import time
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[2]


def main(program, notices, glibc, folder):
    package = tomllib.loads((ROOT / "Cargo.toml").read_text())["package"]
    name, version = package["name"], package["version"]
    tag = f"py3-none-manylinux_{glibc.replace('.', '_')}_{platform.machine()}"
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
        (f"{name}-{version}.data/scripts/{name}", Path(program).read_bytes(), 0o755),
        (f"{info}/METADATA", "\n".join(metadata).encode(), 0o644),
        (f"{info}/WHEEL", "\n".join(wheel).encode(), 0o644),
        *((f"{info}/licenses/{path.name}", path.read_bytes(), 0o644) for path in licences),
    ]
    record = [f"{path},{digest(content)},{len(content)}" for path, content, _ in files]
    record += [f"{info}/RECORD,,", ""]
    files.append((f"{info}/RECORD", "\n".join(record).encode(), 0o644))
    date = time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", time.time())))[:6]
    with zipfile.ZipFile(Path(folder) / f"{name}-{version}-{tag}.whl", "w") as archive:
        for path, content, mode in files:
            entry = zipfile.ZipInfo(path, date)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (stat.S_IFREG | mode) << 16
            archive.writestr(entry, content, compresslevel=9)


def digest(content):
    """A hash as RECORD has it."""
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()


main(*sys.argv[1:])
