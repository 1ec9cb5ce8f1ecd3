"""`strandcli convert`: one file of strands into another."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..common.counted import counted
from ..errors import UsageError
from . import options
from .progress import Talk, say
from .values import FRAMES, FrameRange

if TYPE_CHECKING:
    from ..exchange.edits import Change, Step
    from ..exchange.strands import Strands

AXIS = click.Choice(("x", "y", "z", "-x", "-y", "-z"))


class FiniteType(click.FloatRange):
    """A number within bounds, which NaN and infinity are not."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        found = float(super().convert(value, param, ctx))
        if not abs(found) < float("inf"):
            self.fail(f"'{value}' is no finite number", param, ctx)
        return found


@click.command()
@click.argument("source", type=options.PathType(), metavar="IN")
@click.argument("target", type=options.PathType(), metavar="OUT")
@options.reading
@click.option(
    "-f", "--frames", type=FRAMES, metavar="RANGE",
    help="Moments of a file of strands that move, the first is 1: 1-48 or 1-100x5.  [default: all]",
)  # fmt: skip
@click.option("--fix", is_flag=True, help="Leave out strands that are not finite, have no length or repeat another.")
@click.option("--reverse", is_flag=True, help="Turn all strands around: roots come first.")
@click.option("--up", type=AXIS, help="The up axis of IN, to be turned to that of OUT.")
@click.option("--to-up", type=AXIS, default="y", show_default=True, help="The up axis of OUT, with --up.")
@click.option("--scale", type=FiniteType(min=0, min_open=True), metavar="X", help="Multiply lengths: .01 for cm to m.")
@click.option("--min-length", type=FiniteType(min=0), metavar="X", help="Leave out strands shorter than this.")
@click.option("--max-length", type=FiniteType(min=0), metavar="X", help="Leave out strands longer than this.")
@click.option(
    "--strands", type=options.COUNT_STRANDS, metavar="N", help="Select so many by --seed, fewer of them in more."
)
@click.option("--seed", type=options.Whole(0, 2**63 - 1), default=0, show_default=True, metavar="N", help="Seed.")
@click.option("--resample", type=options.Whole(2, 65_536), metavar="N", help="N points a strand, by arc length.")
@click.option(
    "--simplify", type=FiniteType(min=0), metavar="X",
    help="Leave out points that lie within X of the strand without them.",
)  # fmt: skip
@options.overwrite
@options.brief
def command(
    source: Path, target: Path, stride: int | None, array: str | None, objects: tuple[str, ...],
    frames: FrameRange | None, overwrite: bool, talk: Talk, **edits: Any,
) -> None:  # fmt: skip
    """Write the strands of the file IN as the file OUT, in the format that its name ends in.

    Edits are made in the order in which they stand below; lengths are those of OUT.
    """
    from ..exchange import files
    from ..exchange.edits import edited
    from ..exchange.strands import TimeSample

    _check(edits)
    writer = files.writer_of(target)
    options.refuse_existing(target, overwrite)
    how = files.ReadOptions(stride, array, lenient=edits["fix"], objects=objects)
    strands, moving = files.read_first(source, how)
    there = 1 if moving is None else moving.clock.size
    chosen = _moments(source, there, frames, getattr(writer, "moving", False))
    if moving is not None and chosen[0] > 1:
        strands = moving.read(float(moving.clock[chosen[0] - 1]))
    skipped, before = dict(strands.source.skipped), strands.count
    strands, changes, again = edited(strands, _edits(edits), len(chosen) > 1)
    samples = None
    if again is not None and moving is not None:
        samples = (TimeSample(one.seconds, again(one.points)) for one in moving.samples(chosen))
    lost = files.write(target, strands, samples)
    if frames is None and len(chosen) < there:
        lost.append(f"{writer.name} has one moment: the first of {there:,} is written, --frames chooses another")
    _report(source, target, (before, strands), skipped, changes, lost, talk)


def _moments(source: Path, there: int, frames: FrameRange | None, moving: bool) -> tuple[int, ...]:
    """Numbers of the moments that are written of so many, from 1. Raises `UsageError` for those that are not there, and
    for several where one can be written."""
    if frames is None:
        return tuple(range(1, there + 1)) if moving else (1,)
    if frames.last > there:
        raise UsageError(f"--frames asks for moment {frames.last:,}, {source} has {there:,}")
    found = frames.numbers()
    if len(found) > 1 and not moving:
        raise UsageError("--frames: asks for several moments, the format of OUT has one; write .abc or .usd")
    return found


def _check(edits: dict[str, Any]) -> None:
    """Raise `UsageError` for options that exclude each other."""
    options.exclusive(resample=edits["resample"] is not None, simplify=edits["simplify"] is not None)
    if edits["to_up"] != "y" and edits["up"] is None:
        raise UsageError("--to-up: give the up axis of IN with --up as well")


def _edits(chosen: dict[str, Any]) -> list[Step]:
    """What is to be done, in order."""
    from ..exchange import edits, resample
    from ..exchange.edits import Step

    least, most = chosen["min_length"], chosen["max_length"]
    bounds = None if least is None and most is None else (least or 0.0, float("inf") if most is None else most)
    asked: list[tuple[Any, Callable[[Strands, Any], Any], bool]] = [
        (chosen["fix"] or None, lambda strands, _: edits.fixed(strands), True),
        (chosen["reverse"] or None, lambda strands, _: edits.reversed_all(strands), True),
        (chosen["up"], lambda strands, up: edits.turned(strands, up, chosen["to_up"]), False),
        (chosen["scale"], edits.scaled, False),
        (bounds, lambda strands, ends: resample.between(strands, *ends), True),
        (chosen["strands"], lambda strands, count: resample.some(strands, count, chosen["seed"]), True),
        (chosen["resample"], resample.resampled, False),
        (chosen["simplify"], resample.simplified, True),
    ]
    return [
        Step(lambda strands, do=do, given=given: do(strands, given), chooses=chooses)  # type: ignore[misc]
        for given, do, chooses in asked
        if given is not None
    ]


def _report(
    source: Path, target: Path, strands: tuple[int, Strands], skipped: dict[str, int], changes: list[Change],
    lost: list[str], talk: Talk,
) -> None:  # fmt: skip
    """Say what was done; ``strands``: how many were read, and what was written."""
    from ..exchange.splines import note_of

    before, after = strands
    note = note_of(after.source.facts)
    if talk.as_json:
        talk.data({
            "in": str(source), "out": str(target), "strands_read": before, "skipped": skipped,
            "strands": after.count, "points": after.points.shape[0], "lost": lost,
            "basis": after.source.facts.get("basis"),
            "edits": [{"edit": one.edit, "text": one.text, **one.facts} for one in changes],
        })  # fmt: skip
        return
    for why, count in skipped.items():
        say(f"{source}: {counted(count, 'strand')} of {why} skipped", err=True)
    for line in ([f"{source}: {note}"] if note else []) + [one.text for one in changes] + lost:
        talk.note(line)
    talk.note(f"{target}: {counted(after.count, 'strand')}, {after.points.shape[0]:,} points")
