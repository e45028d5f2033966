"""How much memory a program takes at its worst, for tests that promise it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

# Linux hands a program the peak of the process that started it, so that getrusage() tells of the tests' own memory;
# VmHWM begins anew with each program. A Mac has no such file, and counts in bytes.
PEAK = """
def peak():
    import resource, sys
    if sys.platform == "darwin":
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmHWM"))
"""


def taken(code: str, *arguments: str) -> tuple[list[int], int]:
    """The whole numbers that a program prints, and the most kilobytes that it held; it may import test modules."""
    folders = [str(Path(__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    environ = {**os.environ, "PYTHONPATH": os.pathsep.join(folders)}
    program = [sys.executable, "-c", f"{PEAK}\n{code}\nprint(peak())", *arguments]
    done = subprocess.run(program, capture_output=True, text=True, env=environ, check=True)
    *numbers, kilobytes = map(int, done.stdout.split())
    return numbers, kilobytes
