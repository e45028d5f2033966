"""The editor's page is what its sources make, and they are of one type throughout."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from rendering import LIMIT, require

ROOT = Path(__file__).resolve().parents[1]
WEB = ROOT / "web"
PAGE = ROOT / "src" / "crowquill" / "editor" / "page"


def npm(*command: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """What an npm script of the page says. Where Node or its packages are missing the test is reported as not run, and on CI it fails."""
    program = require("npm")
    if not (WEB / "node_modules").is_dir():
        reason = "NOT RUN: web/node_modules is missing; make page installs it"
        if os.environ.get("CI"):
            pytest.fail(reason)
        pytest.skip(reason)
    whole = [program, "run", "--silent", *command]
    return subprocess.run(whole, cwd=WEB, env={**os.environ, **environment}, capture_output=True, text=True, timeout=LIMIT)


def test_the_page_is_what_its_sources_make(tmp_path: Path) -> None:
    built = npm("build", OUT=str(tmp_path))
    assert built.returncode == 0, built.stderr
    names = {file.name for file in tmp_path.iterdir()}
    assert names == {file.name for file in PAGE.iterdir()} == {"index.html", "editor.css", "editor.js", "notebook.js"}
    for name in names:
        assert (tmp_path / name).read_bytes() == (PAGE / name).read_bytes(), f"{name} is not what web/src makes; make page"


def test_the_sources_are_typed_strictly() -> None:
    checked = npm("types")
    assert checked.returncode == 0, checked.stdout


def test_the_page_asks_nothing_of_other_hosts() -> None:
    for file in PAGE.iterdir():
        text = file.read_text(encoding="utf-8").replace("\\\n", "")  # long strings go on in the next line
        text = text.replace("http://www.w3.org/2000/svg", "")
        assert "http://" not in text and "https://" not in text, file.name
