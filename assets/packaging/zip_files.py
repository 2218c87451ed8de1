#!/usr/bin/env python3
"""Writes zip files whose bytes depend on names, content and SOURCE_DATE_EPOCH alone.

    zip_files.py FOLDER FILE.zip     a folder with all that is in it
"""

import os
import stat
import sys
import time
import zipfile
from pathlib import Path


def write(path, files):
    """Files as (name, content, whether it can be run), in the order that they get in the zip file."""
    date = time.gmtime(int(os.environ["SOURCE_DATE_EPOCH"]))[:6]
    with zipfile.ZipFile(path, "w") as archive:
        for name, content, program in files:
            entry = zipfile.ZipInfo(name, date)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (stat.S_IFREG | (0o755 if program else 0o644)) << 16
            archive.writestr(entry, content, compresslevel=9)


def main(folder, path):
    folder = Path(folder).resolve()
    files = sorted(file for file in folder.rglob("*") if file.is_file())
    write(path, [(file.relative_to(folder.parent).as_posix(), file.read_bytes(), os.access(file, os.X_OK)) for file in files])


if __name__ == "__main__":
    main(*sys.argv[1:])
