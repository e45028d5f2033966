"""The command line: crowquill STYLE PICTURE OUT..., with options generated from the style's signature."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType
from typing import NoReturn

STOPPED = 130  # exit code after Ctrl-C
ENDED = 143  # exit code after TERM


class Ended(BaseException):
    """Raised in the main thread by SIGTERM, so that files under way are removed on the way out."""


def _end(_signal: int, _frame: FrameType | None) -> NoReturn:
    raise Ended


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line and returns its exit code: 0, 2 for what was refused, 130 or 143 when stopped."""
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        from crowquill.commands import Halted, application, refused

        try:
            return application(arguments)
        except MemoryError:
            return refused("not enough memory; use a smaller picture or fewer dots")
        except (ValueError, OSError) as error:
            return refused(error)
        except Halted as stop:
            sys.stderr.write(f"crowquill: {stop}\n")
            return STOPPED
    except KeyboardInterrupt:
        sys.stderr.write("crowquill: stopped; nothing was written\n")
        return STOPPED
    except Ended:
        return ENDED


def run() -> NoReturn:
    """The entry point of the console script. Signals are taken care of before anything heavy is imported."""
    signal.signal(signal.SIGTERM, _end)
    for handle in (0, 1, 2):  # closed by who started us: a file of ours must not take its place
        try:
            os.fstat(handle)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    sys.stdout = sys.stdout or open(1, "w", closefd=False)  # noqa: SIM115
    sys.stderr = sys.stderr or open(2, "w", closefd=False)  # noqa: SIM115
    sys.exit(main())


if __name__ == "__main__":
    run()
