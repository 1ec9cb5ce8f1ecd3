"""What `strandcli render` says of a run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..common.counted import counted
from .progress import duration, pace
from .say import say

if TYPE_CHECKING:
    from ..output.frames import FrameWriter


def interrupted(writer: FrameWriter, besides: str = "") -> str:
    """Say that a run was interrupted, and how many frames stay."""
    from ..output.files import count_there

    there = count_there(writer.directory / one.file for one in writer.written.values())
    finished = counted(there, "finished frame")
    return f"{writer.directory}: interrupted; {besides}{finished} stay, --resume continues"


def frame_line(number: int, report: Mapping[str, Any]) -> str:
    """The line of a frame for --verbose: milliseconds of its stages, and its errors."""
    stages = [f"{name} {1000 * value:.1f}" for name, value in report.get("seconds", {}).items() if value is not None]
    errors = [f"{name} {value:.2g}" for name, value in report.get("error", {}).items() if value is not None]
    return f"frame {number}: {', '.join(stages)} ms; {', '.join(errors)}"


def tell(data: Mapping[str, Any], writer: FrameWriter, made: list[Path]) -> None:
    """Print what a run made, how long it took and what it kept."""
    drawn = len(writer.wanted)
    kept = len(writer.written) - drawn
    totals = data["totals"]
    words = f"{writer.directory}: {counted(drawn, 'frame')} in {_seconds(totals['seconds'])}"
    compiling = data["compile_seconds"] or 0.0
    if compiling:
        words += f", of which {compiling:.1f} s compiling (only on first use)"
    drawing = totals["seconds"] - compiling
    if drawn > 1 and drawing > 0:
        words += f": {pace(drawn, drawing)}"
    if kept:
        words += f"; {kept} kept"
    for path in made:
        words += f"; {path.name}"
    say(f"{words}; {_written(writer, made)}", err=True)


def _written(writer: FrameWriter, made: list[Path]) -> str:
    """What the frames' files take, kept ones too, with their layers and the animations."""
    from ..output.files import megabytes
    from ..output.layers import layer_files

    names = [one.file for one in writer.written.values()]
    names += [name for frame in writer.written for name in layer_files(frame, writer.layers, writer.exr)]
    paths = [*(writer.directory / name for name in names), *made]
    return megabytes(sum(path.stat().st_size for path in paths if path.exists()))


def _seconds(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < 60 else duration(seconds)
