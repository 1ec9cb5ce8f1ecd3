"""`strandcli doctor`: whether all is well here."""

from __future__ import annotations

import os
import sys

import click

from ..errors import FAILED
from . import options
from .progress import Talk, printable, say

MARKS = {"ok": ("ok    ", "green"), "note": ("note  ", "yellow"), "broken": ("BROKEN", "red")}


@click.command()
@click.option("--calibrate", is_flag=True, help="Measure this machine's speed, for what 'strandcli plan' says of time.")
@options.brief
@click.pass_context
def command(ctx: click.Context, calibrate: bool, talk: Talk) -> None:
    """Check that strandcli works here: versions, threads, memory, kernel cache, extras, and a small picture, drawn and
    compared with the known one. Prints a line for each, with what to do; exit code 1 where something is broken.
    """
    from ..doctor import BROKEN, OK
    from ..doctor.examine import examine

    if calibrate:
        _calibrate(talk)
        return
    found = []
    for one in examine():
        found.append(one)
        if not talk.as_json and not (talk.quiet and one.state == OK):
            _report(*one)
        if one.check == "extras" and not talk.as_json and not talk.quiet and sys.stderr.isatty():
            say("drawing a small picture; the first time it compiles, for about a minute", err=True)
    broken = [one.check for one in found if one.state == BROKEN]
    if talk.as_json:
        talk.data({"broken": broken, "checks": [one._asdict() for one in found]})
    elif not talk.quiet:
        say(f"broken: {', '.join(broken)}" if broken else "all is well", err=True)
    if broken:
        ctx.exit(FAILED)


def _report(check: str, state: str, text: str, advice: str) -> None:
    mark, colour = MARKS[state]
    shown = False if os.environ.get("NO_COLOR") else None
    click.echo(f"{click.style(mark, fg=colour)} {printable(f'{check:<10} {text}')}", color=shown)
    if advice:
        say(f"{'':<17} {advice}")


def _calibrate(talk: Talk) -> None:
    """Measure, keep and tell the speed of this machine."""
    from .. import calibration
    from ..compiling import runtime
    from ..compiling.folder import cache

    runtime.start(1)
    with talk.progress(1, "calibration") as progress:
        found = calibration.measure(progress.note)
    stored = calibration.write(found)
    if talk.as_json:
        talk.data({"factor": found.factor, "measured": found.measured, "kept": stored})
    elif not talk.quiet:
        say(
            f"frames take {found.factor:.2f} times as long here as where they were measured for docs/speed.md", err=True
        )
        if not stored:
            say(f"warning: that cannot be stored: {cache.trouble}", err=True)
