"""Styles learned from scans, kept in the user's cache folder by what the scan holds, so that none is learned twice.

A style that was kept, and one learned anew, are the same to the last bit: both have been through a file's rounding.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import secrets
from importlib.metadata import version
from pathlib import Path

from crowquill.exemplar import learning, stylefile
from crowquill.exemplar.style import Style

MOST = 50  # styles kept, of some 300 kB each; the oldest go


def place(scan: Path, dpi: float | None) -> Path | None:
    """The file for the style of a scan at a dpi, or at its own, as this version learns it; None where there is no home for it."""
    what = hashlib.sha256(f"{learning.digest(scan)} {dpi} {version('crowquill')} {stylefile.SCHEMA}".encode()).hexdigest()
    try:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:
        return None
    return base / "crowquill" / f"{what}.style"


def recalled(file: Path | None) -> Style | None:
    """The style kept in a file, None where there is none that can be read."""
    with contextlib.suppress(OSError, ValueError):
        return stylefile.load(file) if file else None
    return None


def kept(style: Style, file: Path | None) -> Style:
    """The style as it is read back, and kept in the file where one can be written; a folder that is full loses its oldest."""
    data = stylefile.to_bytes(style)
    if file:
        with contextlib.suppress(OSError):
            file.parent.mkdir(parents=True, exist_ok=True)
            part = file.with_name(f"{file.name}.{secrets.token_hex(6)}.part")
            try:
                part.write_bytes(data)
                part.replace(file)
            finally:
                part.unlink(missing_ok=True)
            for old in sorted(file.parent.glob("*.style"), key=lambda each: each.stat().st_mtime)[:-MOST]:
                old.unlink(missing_ok=True)
    return stylefile.parsed(data, style.name)
