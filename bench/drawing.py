"""One drawing in a process of its own, and what each of its stages took: python drawing.py '{"picture": ..., "out": ..., "dots": ...}'.

picture     a picture file; out, a file to write, compact where it is a PDF; without it there is no drawing
dots        how many; iterations, as many as the style's default unless given
repeats     single iterations timed before it, the least of which is told
processors  how many to use, all unless given

Prints JSON: seconds by stage, wall and processors' seconds in all, an iteration's seconds, and VmHWM in MB.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

# functions that their callers look up anew each time, and the stage that each is; reading and writing are timed as they are called,
# placing is the style's own measure, and what is left of the whole is "other"
STAGES = (
    ("styles.stipple", "planned", "start"),
    ("relax", "scatter", "start"),
    ("cells", "triangulated", "triangulation"),
    ("cells", "_clipped", "clipping"),
    ("moments", "of_tone", "moments"),
)
WHOLE = "start"  # coarser levels are relaxed in it, which is no stage by itself
LIGHT = {"tone": "grey", "width": 180.0, "max_pixels": 1 << 40}
ORDER = ("read", "start", "triangulation", "clipping", "moments", "placing", "writing", "other")


class Stopwatch:
    """Seconds by stage; of stages inside each other the inner one's are its own, but in a start all is the start's."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.open: list[float] = []
        self.names: list[str] = []
        self.missing: list[str] = []

    def watch(self, module: str, name: str, stage: str) -> None:
        """Times every call of a function of crowquill, or notes that there is none of that name."""
        holder = import_module(f"crowquill.{module}")
        if hasattr(holder, name):
            setattr(holder, name, self.timed(getattr(holder, name), stage))
        else:
            self.missing.append(f"{module}.{name}")

    def timed(self, work: Callable[..., Any], stage: str) -> Callable[..., Any]:
        """The function, its time added to a stage."""

        def call(*args: Any, **kwargs: Any) -> Any:
            if WHOLE in self.names:
                return work(*args, **kwargs)
            self.names.append(stage)
            began = time.perf_counter()
            self.open.append(0.0)
            try:
                return work(*args, **kwargs)
            finally:
                taken = time.perf_counter() - began
                self.names.pop()
                self.seconds[stage] = self.seconds.get(stage, 0.0) + taken - self.open.pop()
                if self.open:
                    self.open[-1] += taken

        return call


def peak() -> float:
    """The most memory that this process held, MB."""
    status = Path("/proc/self/status")
    if status.exists():
        return next(int(line.split()[1]) for line in status.read_text().splitlines() if line.startswith("VmHWM")) / 1024
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20  # of a Mac, which counts in bytes


def iterated(wanted: dict[str, Any]) -> dict[str, float]:
    """The least of some single iterations, and the most memory held until then, the picture and the first sites included."""
    import numpy as np

    from crowquill import relax
    from crowquill.tone import Tone

    tone = Tone.load(wanted["picture"], **LIGHT)
    states, laps = relax.lloyd(relax.scatter(tone, wanted["dots"], np.random.default_rng(0)), tone), []
    next(states)
    for _ in range(wanted["repeats"]):
        began, spent = time.perf_counter(), time.process_time()
        next(states)
        laps.append((time.perf_counter() - began, time.process_time() - spent))
    return {"iteration": min(laps)[0], "iteration_cpu": min(laps)[1], "iteration_memory": peak()}


def drawn(wanted: dict[str, Any]) -> dict[str, Any]:
    """The whole drawing, and its stages."""
    import crowquill
    from crowquill.tone import Tone

    watch = Stopwatch()
    for stage in STAGES:
        watch.watch(*stage)
    steps = {} if wanted.get("iterations") is None else {"iterations": wanted["iterations"]}
    compact = {"compact": True} if wanted["out"].endswith(".pdf") else {}
    began, spent = time.perf_counter(), time.process_time()
    tone = watch.timed(Tone.load, "read")(wanted["picture"], **LIGHT)
    sheet = crowquill.draw("stipple", tone, dots=wanted["dots"], **steps)
    watch.timed(crowquill.save, "writing")(sheet, wanted["out"], **compact)
    seconds, cpu = time.perf_counter() - began, time.process_time() - spent
    stages = {**watch.seconds, "placing": sheet.report["seconds"]["measure"]}
    stages["other"] = max(0.0, seconds - sum(stages.values()))
    return {"seconds": seconds, "cpu": cpu, "memory": peak(), "marks": len(sheet.marks), "iterations": sheet.report["iterations"],
            "stages": stages, "missing": watch.missing}  # fmt: skip


def main(wanted: dict[str, Any]) -> dict[str, Any]:
    """Iterations where any are asked for, which take less memory than the drawing that follows, where there is a file for it."""
    if wanted.get("processors"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: wanted["processors"]])  # before crowquill counts them
    import numpy as np

    import crowquill
    from crowquill.tone import Tone

    crowquill.draw("stipple", Tone(np.ones((20, 20)) / 2, (10, 10)), dots=300, iterations=2)  # compiled before the clock runs
    return {**(iterated(wanted) if wanted.get("repeats") else {}), **(drawn(wanted) if wanted.get("out") else {})}


if __name__ == "__main__":
    print(json.dumps(main(json.loads(sys.argv[1]))))
