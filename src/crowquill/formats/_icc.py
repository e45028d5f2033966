"""ICC profiles of presses: other people's, checked, and one of black ink alone, made here."""

from __future__ import annotations

import io
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crowquill.vector import contents

CHANNELS = {"GRAY": 1, "CMYK": 4}
HEAD = 132  # bytes: the header, and the number of tags
GAMMA = 2.2  # of our own: as screens show shares of black; no press is claimed
D50 = (0.9642, 1.0, 0.8249)
DATE = (2000, 1, 1, 0, 0, 0)  # fixed: the same drawing gives the same bytes


@dataclass(frozen=True)
class Profile:
    """A profile of an output device: its bytes, colour space GRAY or CMYK, what it is called, and its version, 2 or 4."""

    data: bytes
    space: str
    name: str
    version: int = 2

    @property
    def channels(self) -> int:
        """Numbers to a colour."""
        return CHANNELS[self.space]


def read(path: str) -> Profile:
    """The profile in a file. Raises ValueError for one that is damaged, cut short, not a press's, or of other colours than ink."""
    from PIL import ImageCms

    data = contents(Path(path))
    if len(data) < HEAD or data[36:40] != b"acsp":
        raise ValueError(f"{path}: is not an ICC profile; give the .icc of the press")
    (size,) = struct.unpack(">I", data[:4])
    if size != len(data):
        raise ValueError(f"{path}: is {len(data)} bytes of {size}, so damaged or cut short; fetch the profile again")
    kind, space, version = data[12:16], data[16:20].decode("latin-1").strip(), data[8]
    if kind != b"prtr":
        raise ValueError(f"{path}: is a profile of class {_said(kind)}, not of a press (prtr); give the .icc of the press")
    if space not in CHANNELS:
        raise ValueError(f"{path}: is a profile for {_said(data[16:20])}; give one for CMYK, or for GRAY where black is the only ink")
    try:
        opened: Any = ImageCms.getOpenProfile(io.BytesIO(data))
        name = " ".join(str(ImageCms.getProfileDescription(opened)).split())
        mode = "L" if space == "GRAY" else "CMYK"
        ImageCms.buildTransform(opened, ImageCms.createProfile("LAB"), mode, "LAB", ImageCms.Intent.RELATIVE_COLORIMETRIC)
    except (ImageCms.PyCMSError, OSError, ValueError) as error:
        said = " ".join(str(error).split())[:80]
        raise ValueError(f"{path}: no colours can be made with this profile ({said}); fetch it again") from None
    return Profile(data, space, "".join(letter for letter in name if letter.isprintable()) or Path(path).stem, version)


def grey() -> Profile:
    """A profile of black ink alone, made here: for viewing, with a gamma of 2.2. It describes no press."""
    name = "Black ink, gamma 2.2 (crowquill)"
    text = name.encode("ascii") + b"\0"
    tags = {
        b"desc": b"desc" + struct.pack(">II", 0, len(text)) + text + bytes(4 + 4 + 2 + 1 + 67),  # no Unicode, no Macintosh name
        b"cprt": b"text" + bytes(4) + b"Public domain\0",
        b"wtpt": b"XYZ " + bytes(4) + _fixed(*D50),
        b"kTRC": b"curv" + struct.pack(">IIH", 0, 1, round(GAMMA * 256)),
    }
    at, table, body = HEAD + 12 * len(tags), b"", b""
    for tag, value in tags.items():
        table += tag + struct.pack(">II", at + len(body), len(value))
        body += value + bytes(-len(value) % 4)
    head = struct.pack(">I4sI4s4s4s6H4s", at + len(body), bytes(4), 0x02100000, b"prtr", b"GRAY", b"XYZ ", *DATE, b"acsp")
    head += bytes(28) + _fixed(*D50)  # of no platform, maker or model; perceptual
    return Profile(head.ljust(128, b"\0") + struct.pack(">I", len(tags)) + table + body, "GRAY", name)


def _fixed(*numbers: float) -> bytes:
    return struct.pack(f">{len(numbers)}i", *(round(number * 65536) for number in numbers))


def _said(name: bytes) -> str:
    return repr(name.decode("latin-1").strip())
