"""`strandcli bench`: the time of every stage, with the errors that go with it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click

from ..errors import UsageError
from . import options
from .progress import Progress
from .say import say

OWN = {
    "emitter.strands": "--strands", "emitter.particles": "--particles", "image.size": "--size", "solver": "--solver",
    "quality": "--quality", "time.frames": "--frames",
}  # fmt: skip
"""Settings that have options of their own here."""


@click.command()
@click.option("--strands", type=options.COUNT_STRANDS, default=10_000, show_default=True, metavar="N", help="Strands.")
@click.option(
    "--particles", type=options.COUNT_PARTICLES, default=10, show_default=True, metavar="N", help="Particles a strand."
)
@click.option(
    "--frames", type=options.Whole(1, 100_000), default=20, show_default=True, metavar="N", help="Frames to time."
)
@click.option("--size", type=options.SizeType(), default="800x600", show_default=True, help="Picture.")
@click.option("--solver", default="thesis", show_default=True, metavar="NAME", help="How strands move.")
@click.option(
    "--quality",
    type=click.Choice(("preset", "draft", "default", "best")),
    default="preset",
    show_default=True,
    help="How finely the scene is drawn; preset: as it is written.",
)
@options.overrides
@click.option("--growth", is_flag=True, help="Simulate alone: what a particle costs as strands and particles grow.")
@options.threads
@options.talk("Say what is compiled, where stderr is no terminal too.")
def command(
    strands: int,
    particles: int,
    frames: int,
    size: tuple[int, int],
    solver: str,
    quality: str,
    overrides: tuple[str, ...],
    growth: bool,
    threads: int | None,
    as_json: bool,
    quiet: bool,
    verbose: bool,
    no_progress: bool,
) -> None:
    """Time every stage on the thesis's headline scene: six rules, smoothing, Marschner, shadow map.

    --set changes it: with image.resolver=sorted, material.model=chiang, material.width=0.0014 and
    lights.0.shadow.model=opacity strands are .2 pixels wide, sorted, and under an opacity map.

    Compiling is told apart. Times are of this machine as it is now: compare within one sitting only.
    """
    for text in overrides:
        path = text.partition("=")[0].strip()
        if path in OWN:
            raise UsageError(f"--set {path}: write {OWN[path]} for it")
    from .. import runtime

    with Progress(frames, "bench", hidden=no_progress or quiet, verbose=verbose) as progress:
        runtime.start(threads, progress.note)
        from ..study import bench

        if growth:
            grown = bench.time_growth(solver, overrides, progress.note)
            data = {"solver": solver, **grown, "machine": runtime.machine()}
        else:
            data = bench.run(
                strands=strands,
                particles=particles,
                frames=frames,
                size=size,
                threads=threads,
                solver=solver,
                quality=quality,
                overrides=overrides,
                notify=progress.note,
            )
    if as_json:
        options.print_json(data)
    elif not quiet:
        say(growth_table(data) if growth else table(data))


def table(data: Mapping[str, Any]) -> str:
    """The figures for people: a row a stage, then what they add up to."""
    wide, high = data["size"]
    at_once = data.get("frames_at_once", 1)
    lines = [
        f"{data['strands']:,} strands x {data['particles']} particles, {wide}x{high}, {data['frames']} frames, "
        f"{data['threads']} {'thread' if data['threads'] == 1 else 'threads'}",
        "",
        f"{'stage':<12}{'median ms':>12}{'min ms':>12}{'max ms':>12}"
        + (f"   {at_once} frames at once, each on its share of threads" if at_once > 1 else ""),
    ]
    for name, times in data["stages"].items():
        lines.append(f"{name:<12}{_ms(times['median_ms']):>12}{_ms(times['min_ms']):>12}{_ms(times['max_ms']):>12}")
    frame = data["frame"]
    lines += [f"{'frame':<12}{_ms(frame['median_ms']):>12}   {frame['fps']:.1f} frames/s", ""]
    for name, value in data["counts"].items():
        lines.append(f"{name:<20}{value:>14,}")
    for name in ("particle_step_ns", "segment_ns"):
        if data.get(name) is not None:
            lines.append(f"{name:<20}{data[name]:>14.3g}")
    step = ("particle_step_ns", "a particle and step")
    alone = (("steps", *step), ("rules", *step), ("lines", "fragment_ns", "a fragment"))
    for name, unit, of in alone:
        if name in data:
            lines.append(f"{name + ' alone':<20}{data[name]['ms']:>11.2f} ms   {data[name][unit]:.2f} ns {of}")
    for name, value in data["error"].items():
        if value is not None:
            lines.append(f"{name:<20}{value:>14.3g}")
    lines.append(f"compiling took {data['compile_seconds']:.1f} s, not counted above")
    return "\n".join(lines)


def growth_table(data: Mapping[str, Any]) -> str:
    """A row a size: what a step takes, and a particle of it; then the exponents of the cost."""
    lines = [f"{data['solver']}, {data['machine']['threads']} threads", ""]
    lines.append(f"{'strands':>10}{'particles':>12}{'ms a step':>12}{'ns a particle':>16}")
    for row in data["growth"]:
        lines.append(f"{row['strands']:>10,}{row['particles']:>12,}{row['ms']:>12.2f}{row['particle_step_ns']:>16.1f}")
    found = [f"{grows} ** {power:.3f}" for grows, power in data["exponents"].items() if power is not None]
    if found:
        lines += ["", f"cost grows as {' and as '.join(found)}; ** 1 is linear"]
    return "\n".join(lines)


def _ms(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"
