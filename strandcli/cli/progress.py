"""What a person sees while a run goes on: one line on stderr, redrawn in place on a terminal; elsewhere plain lines,
where a command asks for them. And how much a command says, data on stdout, what people should know on stderr: nothing
from a preset or the name of a file reaches a terminal as a control."""

from __future__ import annotations

import json
import os
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import TracebackType
from typing import Any, NamedTuple, Self, TextIO

import click

from ..compiling.clock import clock
from ..errors import one_line
from . import signals

_TICK = 0.2
_LONG, _AGAIN = 2.0, 10.0
"""Seconds of compiling from which on a run that draws no line says so, and between two such lines."""
_SILENT = 30.0
"""Seconds without a line after which a run of lines says that it goes on."""
COMPILING = "(only on first use)"
"""Ends each line that tells of compiling."""


def printable(text: str) -> str:
    """``text`` with everything escaped that does not print, such as terminal escapes and marks of writing direction;
    ends of lines stay."""
    return text if text.isprintable() else "\n".join(one_line(line) for line in text.split("\n"))


def say(text: str, *, err: bool = False, nl: bool = True) -> None:
    """Print ``text``, escaped where it would not print, on stdout, or with ``err`` on stderr."""
    click.echo(printable(text), err=err, nl=nl)


def print_json(data: Any) -> None:
    """Machine data alone on stdout, as indented JSON, in which what does not print is escaped."""
    text = json.dumps(data, indent=2, allow_nan=False, ensure_ascii=False)
    if not text.replace("\n", "").isprintable():
        text = "".join(c if c == "\n" or c.isprintable() else json.dumps(c)[1:-1] for c in text)
    click.echo(text)


class Progress:
    """A line with a bar, frames a second and time left; while kernels compile, how long that has taken.

    Nothing is drawn where stderr is no terminal, or with ``hidden``: but for lines where kernels take long to compile.
    With ``verbose`` notes are printed as lines then.
    A thread redraws the line, so that it moves during a long compilation too. ``each`` is what is counted. With
    ``lines`` a run that takes minutes is heard of where nothing is drawn as well: each step that has a text is a line,
    and so is every tenth part of steps that have none; a step that takes long is reported by itself.
    """

    def __init__(
        self, total: int, label: str, *, hidden: bool = False, verbose: bool = False, each: str = "frame",
        lines: bool = False,
    ) -> None:  # fmt: skip
        self.total = total
        self.label = printable(label)
        self.each = each
        self.stream: TextIO = sys.stderr
        self.live = not hidden and self.stream.isatty() and os.environ.get("TERM") != "dumb"
        self.verbose = verbose
        self.hidden = hidden
        self.lines = lines and not hidden and not self.live
        self.done = 0
        self._note = ""
        self._note_since = self._first = self._stepped = 0.0
        self._compiling_since = self._heard = 0.0
        self._lock = threading.RLock()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def __enter__(self) -> Self:
        self._first = self._heard = time.monotonic()
        if not self.hidden:
            self._thread = threading.Thread(target=self._tick, name="progress", daemon=True)
            self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
            self._clear()

    def note(self, text: str) -> None:
        """Tell what is going on: compiling, pre-roll. An empty text ends it. Handed to the pipeline as ``notify``."""
        now = time.monotonic()
        with self._lock:
            if _kind(text) != _kind(self._note):
                self._first += self._pause(now)
                self._note_since = now
                self._compiling_since = now if _kind(text) == "compiling" else 0.0
            self._note = printable(text)
        if text and self.verbose and not self.live:
            say(text, err=True)

    def step(self, text: str = "", count: int = 1) -> None:
        """One more frame is done, or ``count`` more; ``text`` is its line for --verbose."""
        now = time.monotonic()
        with self._lock:
            self._first += self._pause(now)
            self._note, self._compiling_since = "", 0.0
            self._stepped = now
            before, self.done = self.done, self.done + count
        if text and (self.verbose or self.lines):
            self.line(f"{self.label}: {self.done}/{self.total} {text}" if self.lines else text)
        elif self.lines and 10 * self.done // max(1, self.total) > 10 * before // max(1, self.total):
            self.line(f"{self.label}: {self.done:,} of {self.total:,} {self.each}s{self._left(now)}")

    def begin(self, total: int) -> None:
        """There will be so many steps, none of which is done."""
        self.total, self.done = max(1, total), 0

    def checked_step(self, text: str) -> None:
        """One more is done; ends here if the user wants so."""
        self.step(text)
        signals.check()

    def _pause(self, now: float) -> float:
        """Seconds of the present note that are no work on a frame, such as compiling and pre-roll."""
        return now - self._note_since if self._note and _kind(self._note) != "drawing" else 0.0

    def line(self, text: str) -> None:
        """Print a line above the progress line."""
        with self._lock:
            self._clear()
            self._heard = time.monotonic()
            say(text, err=True)

    def _tick(self) -> None:
        """Redraw the line; or say now and again, where there is none, what takes long."""
        while not self._stop.wait(_TICK):
            with self._lock:
                now = time.monotonic()
                if self.live:
                    columns = shutil.get_terminal_size().columns
                    self.stream.write("\r\x1b[K" + self.text(now)[: max(1, columns - 1)])
                    self.stream.flush()
                elif self._compiling_since and now - self._compiling_since > _LONG and not self.verbose:
                    self._compiling_since = now + _AGAIN - _LONG
                    self.line(f"{self.label}: {compiling()} {COMPILING}")
                elif self.lines and now - self._heard > _SILENT:
                    self.line(f"{self.label}: at work on {self.each} {self.done + 1:,} of {self.total:,}")

    def _clear(self) -> None:
        if self.live:
            self.stream.write("\r\x1b[K")
            self.stream.flush()

    def text(self, now: float) -> str:
        """The line as it stands at the time ``now``."""
        if self._note:
            seconds = f"{now - self._note_since:.1f} s"
            if _kind(self._note) == "compiling":
                kernel = self._note.removeprefix("compiling").strip()
                return f"{self.label}: {compiling()} ... {seconds} {COMPILING} {kernel}".rstrip()
            return f"{self.label}: {self._note} ... {seconds}"
        width = 24
        filled = width * self.done // max(1, self.total)
        bar = "#" * filled + "." * (width - filled)
        counts = f"{self.label}: [{bar}] {self.done}/{self.total}"
        elapsed = self._stepped - self._first
        if not self.done or elapsed <= 0:
            return counts
        return f"{counts} {pace(self.done, elapsed, self.each)}{self._left(now)}"

    def _left(self, now: float) -> str:
        """The time left at the time ``now``, where something is done. It counts down between two steps, and stands
        where a step takes longer than those before it did on average."""
        elapsed = self._stepped - self._first
        if not self.done or elapsed <= 0:
            return ""
        each, rest = elapsed / self.done, self.total - self.done
        return f", {duration(rest * each - min(now - self._stepped, each if rest else 0.0))} left"


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

    @contextmanager
    def compiled(
        self, total: int, label: str, threads: int | None, *, each: str = "frame", lines: bool = False
    ) -> Iterator[Progress]:
        """A progress line of what runs kernels on so many threads; it tells of those that are compiled."""
        from ..compiling import runtime

        with self.progress(total, label, each=each, lines=lines) as progress:
            runtime.start(threads, progress.note)
            yield progress

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
        """Warn where other programs took the processor while something was timed (`study.bench`)."""
        from ..study.bench import busy_words

        if words := busy_words(busy):
            self.note(f"warning: {words}; {advice}")


def compiling() -> str:
    """How far compiling is, as far as that is known: ``compiling 12 of 64 kernels, 20 s left``."""
    number, total, left = clock.progress()
    return f"compiling {number} of {total} kernels, {duration(left)} left" if total else f"compiling kernel {number}"


def warner(
    progress: Progress, quiet: bool, *more: Callable[[str], None], heard: set[str] | None = None
) -> Callable[[str], None]:
    """Says warnings above a progress line, unless all is quiet, and hands them on; each once, and none of ``heard``."""
    heard = set() if heard is None else heard

    def warn(text: str) -> None:
        if text in heard:
            return
        heard.add(text)
        for hear in more:
            hear(text)
        if not quiet:
            progress.line(f"warning: {text}")

    return warn


def pace(done: int, seconds: float, each: str = "frame") -> str:
    """How fast ``done`` pieces of work went: ``12.5 frames/s``, or ``3.2 s a frame`` where that is below one."""
    rate = done / seconds
    return f"{rate:.1f} {each}s/s" if rate >= 1 else f"{1 / rate:.1f} s a {each}"


def _kind(text: str) -> str:
    return text.split(" ", 1)[0]


def duration(seconds: float) -> str:
    """A time for people: ``8 s``, ``3:05``, ``2:03:05``."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    minutes, rest = divmod(whole, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
