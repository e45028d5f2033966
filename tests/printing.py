"""What tests of print share: drawings in several inks, a press's profile made by hand, and PDFBox's check of PDF/A."""

from __future__ import annotations

import os
import struct
import subprocess
import tempfile
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from drawings import marks
from rendering import LIMIT, require

from crowquill.lettering import Words
from crowquill.paths import Paths
from crowquill.sheet import Bitmap, Ink, Layer, Sheet

SILVER = Ink("PANTONE 877 C", (0, 0, 0, 0.4), spot=True)
GOLD = Ink("Gold (warm)", (0, 0.2, 0.6, 0.2), spot=True, overprint=True)
JARS = ("preflight", "pdfbox2", "xmpbox", "fontbox2", "commons-logging", "bcprov", "javax.activation", "jaxb-api")
JAVA = Path("/usr/share/java")  # where Debian has them


def square(x: float, y: float, width: float, height: float) -> Paths:
    return Paths.of([[(x, y), (x + width, y), (x + width, y + height), (x, y + height)]])


def black(width: float = 100, height: float = 80) -> Sheet:
    """Dots, words and pixels in black alone."""
    pixels = np.random.default_rng(1).random((120, 200)) < 0.3
    layers = (
        Layer(Ink(), marks(300, width - 30, height - 30)),
        Layer(Ink("grey", (0, 0, 0, 0.3), 0.2), square(12, 12, width - 24, height - 24)),
        Layer(Ink(), Words.of([("Möwe & Ente, 12 µm", 5, height - 8)], size=5)),
        Layer(Ink(), Bitmap.of(pixels, 300, (width - 30, 5))),
    )
    return Sheet((width, height), layers, {"style": "stipple"})


def inked(width: float = 100, height: float = 80) -> Sheet:
    """The same over a spot ink that hangs out of the page, and one that overprints it."""
    below = (Layer(SILVER, square(-5, -5, 65, 55)), Layer(GOLD, square(40, 30, 65, 55)))
    return Sheet((width, height), below + black(width, height).layers, {"style": "stipple"})


def profile(*, kind: bytes = b"prtr", space: bytes = b"CMYK", version: int = 2, broken: bool = False) -> bytes:
    """A small ICC profile of a press that is no press: its ink darkens what there is, and has no hue."""
    channels = 4
    grid = bytes(
        value
        for inks in product((0, 1), repeat=channels)
        for value in (round(255 * float(np.prod([1 - 0.7 * ink for ink in inks]))), 128, 128)
    )
    straight = bytes(range(256))
    unit = struct.pack(">9i", *(65536 * (k % 4 == 0) for k in range(9)))
    table = b"mft1" + bytes(4) + bytes([channels, 3, 2, 0]) + unit + straight * channels + grid + straight * 3
    back = b"mft1" + bytes(4) + bytes([3, channels, 2, 0]) + unit + straight * 3 + bytes(8 * channels) + straight * channels
    name = b"A press by hand\0"
    tags = {
        b"desc": b"desc" + struct.pack(">II", 0, len(name)) + name + bytes(78),
        b"cprt": b"text" + bytes(4) + b"Public domain\0",
        b"wtpt": b"XYZ " + bytes(4) + struct.pack(">3i", 63190, 65536, 54061),
        b"A2B0": b"none" + bytes(40) if broken else table,
        b"A2B1": b"none" + bytes(40) if broken else table,
        b"B2A0": back,
    }
    at, index, body = 132 + 12 * len(tags), b"", b""
    for tag, value in tags.items():
        index += tag + struct.pack(">II", at + len(body), len(value))
        body += value + bytes(-len(value) % 4)
    head = struct.pack(">I4sI4s4s4s6H4s", at + len(body), b"", version << 24, kind, space, b"Lab ", 2000, 1, 1, 0, 0, 0, b"acsp")
    head += bytes(28) + struct.pack(">3i", 63190, 65536, 54061)
    return head.ljust(128, b"\0") + struct.pack(">I", len(tags)) + index + body


def preflight(data: bytes) -> str:
    """What PDFBox says of a file as PDF/A-1b. Where it is missing the test is reported as not run, and on CI it fails."""
    java = require("java")
    missing = [jar for jar in JARS if not (JAVA / f"{jar}.jar").exists()]
    if missing:
        reason = f"NOT RUN: {missing[0]}.jar is not in {JAVA}"
        (pytest.fail if os.environ.get("CI") else pytest.skip)(reason)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "a.pdf").write_bytes(data)
        path = ":".join(str(JAVA / f"{jar}.jar") for jar in JARS)
        call = [java, "-cp", path, "org.apache.pdfbox.preflight.Validator_A1b", "a.pdf"]
        return subprocess.run(call, cwd=folder, capture_output=True, text=True, timeout=LIMIT).stdout


def check_archived(data: bytes) -> None:
    """Raises AssertionError unless PDFBox finds a valid PDF/A-1b file."""
    said = preflight(data)
    assert "is a valid PDF/A-1b file" in said, said[:2000]
