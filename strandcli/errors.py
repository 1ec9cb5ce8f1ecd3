"""Every way in which a run can end other than well, with the exit code that tells it to a shell.

A message is written for the person who has to act on it: where, what, and what to do. The command line prints it as
one line and never shows a traceback for these.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

DONE = 0
FAILED = 1
USAGE = 2
MISMATCH = 3
REFUSED = 4
HUNG_UP = 129
INTERRUPTED = 130
TERMINATED = 143


class StrandError(Exception):
    """Base of all errors that strandcli raises on purpose; ``exit_code`` is what the command line ends with."""

    exit_code = FAILED
    file: tuple[str, str] | None = None
    """Kind and path of the file that it is about, as `about` has them."""


class UsageError(StrandError):
    """The command was asked for something that makes no sense (exit code 2)."""

    exit_code = USAGE


class MismatchError(StrandError):
    """A check was carried out and did not match (exit code 3)."""

    exit_code = MISMATCH


class RefusedError(StrandError):
    """Refused or stopped for want of disk, memory or permission (exit code 4)."""

    exit_code = REFUSED


class SimulationError(StrandError):
    """A run has gone wrong: names the frame, the strand, the rule or constraint, and a remedy (exit code 1).

    ``trouble`` is what is known of it, a `strandcli.simulate.health.Trouble`, or None.
    """

    def __init__(self, message: str, trouble: Any = None) -> None:
        super().__init__(message)
        self.trouble = trouble


@contextmanager
def about(kind: str, path: Any) -> Iterator[None]:
    """Mark errors as those of a file, unless they are those of another that is read meanwhile. ``kind``: what it is
    read as, as `strandcli.scene.specs.FileSpec` has it; ``path`` as the setting has it that names it."""
    try:
        yield
    except StrandError as error:
        error.file = error.file or (kind, str(Path(path)))
        raise


def said(error: object) -> str:
    """What a library says of an error, on one line and without the full stop at its end, so that ours goes on."""
    words = (isinstance(error, OSError) and error.strerror) or str(error)
    return one_line(" ".join(words.split())).rstrip(". ")


def one_line(text: str) -> str:
    """``text`` with everything that does not print on one line escaped, so that a message stays one line."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)
