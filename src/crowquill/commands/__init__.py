"""The command line: one command a style, and one a file of this folder; a refusal is one line."""

from __future__ import annotations

import ast
import errno
import importlib
import os
import re
import sys
import unicodedata
from pathlib import Path
from typing import Annotated

import typer

from crowquill import styles

REFUSED = 2
STOPPED = 130
LONGEST = 280  # characters of a refusal
REMEDIES = {
    errno.ENOENT: "check the name",
    errno.EACCES: "check its permissions",
    errno.EPERM: "check its permissions",
    errno.EROFS: "choose another folder",
    errno.ENOSPC: "free some space",
    errno.EDQUOT: "free some space",
    errno.ENAMETOOLONG: "give a shorter name",
    errno.EISDIR: "give a file name in it",
    errno.ENOTDIR: "check the path",
    errno.ELOOP: "check the path",
}


def application(arguments: list[str]) -> int:
    """Runs the command line; usage errors are refused in one line like any other."""
    chosen = next((a for a in arguments if not a.startswith("-")), None)
    command = typer.main.get_command(_application(chosen))
    try:
        code = command(args=arguments, prog_name="crowquill", standalone_mode=False)
    except typer.Exit as stop:
        code = stop.exit_code
    except typer.TyperException as error:
        message = error.format_message() if hasattr(error, "format_message") else str(error)
        if not message:  # no arguments: the help has been shown
            return REFUSED
        message = message.rstrip(".").replace(". Did you mean", "; did you mean")
        return refused(message if "; " in message else f"{message}; --help shows what there is")
    except typer.Abort:
        raise KeyboardInterrupt from None
    except ValueError as error:
        taken = getattr(command, "commands", {}).get(chosen)
        return refused(spelt(str(error), [parameter.name for parameter in taken.params] if taken else []))
    if code == STOPPED:  # what Typer makes of Ctrl-C
        raise KeyboardInterrupt
    return code if isinstance(code, int) else 0


class Halted(BaseException):
    """Work was stopped by Ctrl-C, and this is to be said of it."""


def refused(error: Exception | str) -> int:
    """One line on stderr: the file, the cause, the remedy. Returns the exit code."""
    sys.stderr.write(f"crowquill: {line(error)}\n")
    return REFUSED


def line(error: Exception | str) -> str:
    """An error in one line: the file, the cause, the remedy."""
    if isinstance(error, OSError) and error.errno:
        name = f"{os.fsdecode(error.filename)}: " if error.filename else ""
        error = f"{name}{(error.strerror or 'failed').lower()}; {REMEDIES.get(error.errno, 'try another file or folder')}"
    text = plain(str(error))
    if len(text) > LONGEST:  # a name can be long: its beginning, the cause and the remedy are what helps
        text = f"{text[: LONGEST // 2]} ... {text[-LONGEST // 2 :]}"
    return text


def spelt(message: str, options: list[str]) -> str:
    """The message with keywords as they are typed: those of several words wherever they stand, others where it begins with them.

    Names of files, which end in a suffix or a colon, and of what is said in one are left alone.
    """
    for option in options:
        typed = "--" + option.replace("_", "-")
        message = re.sub(rf"^{option}(?= is |: length )", typed, message)
        if "_" in option:
            message = re.sub(rf"(?<![\w./\\-])(?<!: ){option}(?![\w./\\:])", typed, message)
    return message


def note(text: str) -> None:
    """A line on stderr that is no refusal."""
    sys.stderr.write(f"crowquill: note: {plain(text)}\n")


def say(text: str) -> None:
    """Lines on stdout, letters that it has not as question marks; where nobody listens any more, or nothing fits, the work goes on."""
    code = sys.stdout.encoding or "utf-8"
    try:
        sys.stdout.write(f"{text.encode(code, 'replace').decode(code)}\n")
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        note(f"what came of it could not be printed ({(error.strerror or 'failed').lower()})")


def plain(text: str) -> str:
    """The text in one line that no terminal can misread: control and bidirectional characters become a question mark."""
    return "".join("?" if unicodedata.category(letter) in ("Cc", "Cf", "Cs", "Zl", "Zp") else letter for letter in text)


def names() -> list[str]:
    """The commands that are no styles: files of this folder."""
    return sorted(path.stem for path in Path(__file__).parent.glob("[a-z]*.py"))


def _application(chosen: str | None) -> typer.Typer:
    """The command line; only what is chosen is imported for its options, all else shows its first line."""
    app = typer.Typer(
        name="crowquill",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )

    @app.callback(epilog="Try: crowquill stipple photo.jpg plate.pdf plate.svg --pen 0.3mm --paper a4")
    def about(  # its options are what it is for
        version: Annotated[bool, typer.Option("--version", is_eager=True, callback=_version, help="Print the version.")] = False,
    ) -> None:
        """Pictures become drawings of dots at true size: SVG to edit, PDF to print."""

    for name in styles.names():
        function = importlib.import_module("crowquill.commands._drawing").command(name) if name == chosen else lambda: None
        app.command(name, help=styles.summary(name), no_args_is_help=True, rich_help_panel="Styles")(function)
    for name in names():
        if name == chosen:
            importlib.import_module(f"crowquill.commands.{name}").add(app)
        else:
            app.command(name, help=_summary(name), rich_help_panel="More")(lambda: None)
    return app


def _summary(name: str) -> str:
    """The first line of a command's module, read without importing it."""
    text = (Path(__file__).parent / f"{name}.py").read_text(encoding="utf-8")
    return (ast.get_docstring(ast.parse(text)) or name).splitlines()[0]


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        say(f"crowquill {version('crowquill')}")
        raise typer.Exit
