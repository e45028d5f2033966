"""Edit a picture, a drawing or an SVG of objects by hand, in the browser: brushes, relaxation step by step, an endless undo.

Every change is written at once to a log beside the file, FILE.edits; the file itself is never changed. What was edited before goes on
where it ended, by states kept in FILE.edits.states, which may be deleted. `crowquill replay FILE.edits OUT` draws the same again.
"""

from __future__ import annotations

import contextlib
import inspect
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crowquill import layout, options
from crowquill.commands import note, say
from crowquill.commands._running import silence
from crowquill.knobs import of
from crowquill.recipe import Recipe

if TYPE_CHECKING:
    from crowquill.editor.session import Session

STYLE = "stipple"  # whose settings of paper and tone are asked for: those of all styles


def add(app: typer.Typer) -> None:
    """Adds the command."""
    tables = {"paper": of(layout.placed), "tone": of(layout.lit)}
    own = list(inspect.signature(_edited, eval_str=True).parameters.values())[:-1]

    def edited(context: typer.Context, **values: Any) -> int:
        given = {name for name in values if getattr(context.get_parameter_source(name), "name", "") == "COMMANDLINE"}
        settings: dict[str, Any] = {table: {key: values.pop(key) for key in takes} for table, takes in tables.items()}
        asked = any(key in given for takes in tables.values() for key in takes)
        return _edited(**values, settings=Recipe(STYLE, **settings) if asked else None)

    every = [options.option(knob, table) for table, takes in tables.items() for knob in takes.values()]
    context = inspect.Parameter("context", inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context)
    app.command("edit", help=__doc__, no_args_is_help=True)(options.signed(edited, [context, *own, *every]))


def _edited(
    file: Annotated[Path, typer.Argument(help="A picture, a drawing's SVG, any SVG of objects.", show_default=False, metavar="FILE")],
    port: Annotated[int, typer.Option(help="Of this machine; 0 takes any free one.", min=0, max=65535)] = 0,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Print the address, and open nothing.")] = False,
    settings: Recipe | None = None,
) -> int:
    try:
        from crowquill.editor.server import Server, listening
    except ModuleNotFoundError as error:
        raise ValueError(f"the editor needs {error.name}, which is not installed; install crowquill[editor]") from None

    with listening(port) as listener:
        session = _opened(file, settings)
        server = Server(session, listener)
        for text in session.notes:
            note(text)
        try:
            say(server.address)
            if not no_browser:
                webbrowser.open(server.address)
        except BaseException:
            session.close()
            raise
        try:
            with contextlib.suppress(KeyboardInterrupt):  # how an editor is left
                server.serve_until_stopped()
        finally:
            _tell(server.session)
    return 0


def _tell(session: Session) -> None:
    """Says where the edits are; those that found no room go elsewhere."""
    journal = session.journal
    if journal.waiting:
        try:
            note(f"{session.path} could not be written ({journal.error}); all edits are in {session.rescued()}, put it in its place")
        except OSError:
            note(f"{journal.waiting} edits could not be written ({journal.error}) and are lost")
    elif session.history.entries:
        say(f"{len(session.history.entries)} edits are in {session.path}")


def _opened(file: Path, settings: Recipe | None) -> Session:
    """The session of a file, with a progress bar on a terminal while its log is done again."""
    from rich.console import Console
    from rich.progress import Progress

    from crowquill.editor.session import Session

    console = Console(stderr=True)
    with silence(), Progress(console=console, transient=True, disable=not console.is_terminal) as bars:
        shown = bars.add_task("recover", visible=False)
        return Session(file, settings, lambda done, total: bars.update(shown, completed=done, total=total, visible=True))
