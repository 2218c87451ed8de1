#!/usr/bin/env python3
"""Writes the icon as macOS has it, of the pictures for Linux and Windows: `icon.py FILE.icns`."""

import struct
import sys
from pathlib import Path

DESKTOP = Path(__file__).resolve().parents[2] / "desktop"


def main(path):
    windows = (DESKTOP / "bathyscope.ico").read_bytes()
    # The last picture of the .ico is the only PNG in it, 256 pixels wide.
    pictures = [(b"ic07", (DESKTOP / "bathyscope.png").read_bytes()), (b"ic08", windows[windows.index(b"\x89PNG") :])]
    content = b"".join(kind + struct.pack(">I", 8 + len(png)) + png for kind, png in pictures)
    Path(path).write_bytes(b"icns" + struct.pack(">I", 8 + len(content)) + content)


main(*sys.argv[1:])
