"""Print text of any origin: nothing from a preset or the name of a file reaches a terminal as a control. And whether
tracebacks are shown."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import click

from ..errors import one_line


def printable(text: str) -> str:
    """``text`` with everything escaped that does not print, such as terminal escapes and marks of writing direction;
    ends of lines stay."""
    return text if text.isprintable() else "\n".join(one_line(line) for line in text.split("\n"))


def say(text: str, *, err: bool = False, nl: bool = True) -> None:
    """Print ``text``, escaped where it would not print, on stdout, or with ``err`` on stderr."""
    click.echo(printable(text), err=err, nl=nl)


def json_text(data: Any) -> str:
    """``data`` as indented JSON, in which what does not print is escaped."""
    text = json.dumps(data, indent=2, allow_nan=False, ensure_ascii=False)
    if text.replace("\n", "").isprintable():
        return text
    return "".join(c if c == "\n" or c.isprintable() else json.dumps(c)[1:-1] for c in text)


def print_json(data: Any) -> None:
    """Machine data alone on stdout."""
    click.echo(json_text(data))


@dataclass(slots=True)
class State:
    """What outlives the commands: whether the traceback of an unexpected error is wanted."""

    debug: bool = False


def set_debug(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    """Callback of every ``--debug``."""
    if value:
        ctx.ensure_object(State).debug = True


debug = click.option(
    "--debug", is_flag=True, expose_value=False, is_eager=True, callback=set_debug, hidden=True, help="Show tracebacks."
)
