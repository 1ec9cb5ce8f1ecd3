"""Print text of any origin: nothing from a preset or the name of a file reaches a terminal as a control."""

from __future__ import annotations

import json
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
