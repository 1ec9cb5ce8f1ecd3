"""How much a command says, and where: data on stdout, what people should know on stderr."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import click

from .progress import Progress
from .say import json_text, say


class Talk(NamedTuple):
    """What --json, --quiet, --verbose and --no-progress ask for; a command may have some of them."""

    as_json: bool = False
    quiet: bool = False
    verbose: bool = False
    no_progress: bool = False

    def progress(self, total: int, label: str, *, each: str = "frame", lines: bool = False) -> Progress:
        """A progress line; see `Progress`."""
        hidden = self.no_progress or self.quiet
        return Progress(total, label, hidden=hidden, verbose=self.verbose, each=each, lines=lines)

    def data(self, data: Any) -> None:
        """Print machine data, alone on stdout, if it is asked for."""
        if self.as_json:
            print_json(data)

    def result(self, data: Any, text: Callable[[], str]) -> None:
        """Print machine data, or else text for people."""
        if self.as_json:
            print_json(data)
        elif not self.quiet:
            say(text())

    def note(self, text: str) -> None:
        """Say what a person should know."""
        if not self.quiet:
            say(text, err=True)

    def warn_if_busy(self, busy: Mapping[str, float] | None, advice: str) -> None:
        """Warn where other programs took the processor while something was timed (`study.busy`)."""
        from ..study.busy import busy_words

        if words := busy_words(busy):
            self.note(f"warning: {words}; {advice}")


def print_json(data: Any) -> None:
    """Machine data alone on stdout."""
    click.echo(json_text(data))
