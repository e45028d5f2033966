"""Make many drawings at once: from recipes and drawings that hold one, or with --style from pictures; here or on a Dask cluster.

What is made is not made again: after a stop, the same command goes on. One that fails is said by name, and the others are made.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence, Set
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from crowquill import cluster, kernel, making, options
from crowquill.batch import Batch, Job
from crowquill.cluster import GoneError
from crowquill.commands import Halted, _drawing
from crowquill.commands._running import Run
from crowquill.commands._telling import Told
from crowquill.recipe import PICTURE, TABLES, Recipe, files_of, takes_of

RUN = options.RUN


def add(app: typer.Typer) -> None:
    """Adds the command."""
    app.command("batch", help=__doc__, no_args_is_help=True, cls=_Styled)(_signed(""))


class _Styled(TyperCommand):
    """The command with the options of the style that its arguments name."""

    def make_context(self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any) -> Any:
        """The context of the command of that style."""
        pairs = [word for argument in args for word in argument.split("=", 1)]
        style = pairs[pairs.index("--style") + 1] if "--style" in pairs[:-1] else ""
        if not style:
            return super().make_context(info_name, args, parent, **extra)
        app = typer.Typer(add_completion=False, context_settings={"help_option_names": ["-h", "--help"]})
        app.command("batch", help=__doc__)(_signed(style))
        command = typer.main.get_command(app)
        self.params = command.params  # what refusals spell
        return command.make_context(info_name, args, parent, **extra)


def _batch(
    files: Annotated[list[Path], typer.Argument(help="Recipes and drawings, or pictures.", show_default=False, metavar="FILE")],
    *,
    out: Annotated[Path, typer.Option(help="The folder for the drawings.", show_default=False, metavar="DIR")],
    style: Annotated[
        str | None, typer.Option(help="Draw pictures in this style; --style NAME --help shows its options.", metavar="NAME")
    ] = None,
    format: Annotated[
        list[str] | None, typer.Option(help="A format to write; may be given again.", show_default="svg", metavar="KIND")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(help="Drawings at a time; one a core when left out.", rich_help_panel=RUN, min=1, max=1024, metavar="N")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(help="Draw on the cluster of this Dask scheduler.", rich_help_panel=RUN, metavar="ADDRESS")
    ] = None,
    report: Annotated[
        Path | None, typer.Option(help="Write what came of each, as .csv or .json; - prints it.", rich_help_panel=RUN, metavar="FILE")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress and no table.", rich_help_panel=RUN)] = False,
    overwrite: Annotated[bool, typer.Option(help="Replace files that are there.", rich_help_panel=RUN)] = True,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what would be drawn, and write nothing.", rich_help_panel=RUN)] = False,
) -> None:
    """Only its signature is used: the options that do not depend on a style."""


def _signed(style: str) -> Callable[..., int]:
    """The command for Typer to read, with the options of a style where one is named."""
    first, *rest = inspect.signature(_batch, eval_str=True).parameters.values()
    if style:
        return options.styled(style, _from_pictures, [first, *rest[:3]], rest[3:])

    def called(**values: Any) -> int:
        return _from_recipes(**values)

    return options.signed(called, [first, *rest])


def _from_pictures(wanted: Recipe, *, files: list[Path], out: Path, format: list[str] | None, typed: Set[str], **more: Any) -> int:
    del more["style"], more["recipe"]
    run = Run(_out(files[0], out, format), None, True, True, False, None, None)
    wanted = _drawing.suited(wanted, typed, run)

    def found(picture: Path, _: Path) -> tuple[Recipe, Mapping[str, Path]]:
        paths = {PICTURE: picture, **{key: Path(value) for key, value in files_of(wanted).items()}}
        return making.named(wanted, paths), paths

    spelling = [key for table in TABLES for key in takes_of(table, wanted.style)]
    jobs = [Job(str(path), tuple(_out(path, out, format)), partial(found, path)) for path in files]
    return _made(jobs, out, spelling=spelling, **more)


def _from_recipes(*, files: list[Path], out: Path, format: list[str] | None, style: None, **more: Any) -> int:  # noqa: ARG001
    def found(file: Path, folder: Path) -> tuple[Recipe, Mapping[str, Path]]:
        wanted, kept = making.read(file)
        if PICTURE not in wanted.sources:
            raise ValueError(f"{file}: its recipe names no picture; give pictures, with --style {wanted.style} --recipe {file}")
        return making.located(wanted, kept, file, {}, folder)

    Run(_out(files[0], out, format), None, True, True, False, None, None).suit({})
    jobs = [Job(str(file), tuple(_out(file, out, format)), partial(found, file), (file,)) for file in files]
    return _made(jobs, out, **more)


def _out(file: Path, folder: Path, kinds: list[str] | None) -> list[Path]:
    """The files that a recipe or a picture becomes."""
    return [folder / f"{file.stem}.{kind.lower().removeprefix('.')}" for kind in kinds or ["svg"]]


def _made(
    jobs: list[Job],
    out: Path,
    *,
    workers: int | None,
    scheduler: str | None,
    report: Path | None,
    quiet: bool,
    overwrite: bool,
    dry_run: bool,
    spelling: Sequence[str] = (),
) -> int:
    """Has the jobs done, says what became of each, and gives the exit code; `spelling` are options that refusals may speak of."""
    if scheduler is not None and workers is not None:
        raise ValueError("--workers are of this machine, and a scheduler has its own; leave out one")
    if not out.is_dir():
        raise ValueError(f"{out}: {'is no folder; give one' if out.exists() else 'there is no such folder; make it first'}")
    told = Told(jobs, report, quiet, spelling)
    told.check(overwrite, [path for job in jobs for path in job.of])
    batch = Batch(jobs, out, overwrite=overwrite, note=told.note)
    if dry_run:
        for outcome in batch.plan():
            told.add(outcome)
        return told.end()
    try:
        with told.live(batch.tokens) as heard, cluster.workers(scheduler, workers or min(len(jobs), kernel.CORES), heard) as pool:
            for outcome in batch.outcomes(pool):
                told.add(outcome)
    except GoneError as error:
        told.line(f"{error}; then the same command goes on")
    except KeyboardInterrupt:
        raise Halted(f"stopped; {batch.made} of {len(jobs)} drawings are made, and the same command goes on") from None
    return told.end()
