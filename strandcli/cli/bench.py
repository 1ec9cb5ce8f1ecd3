"""`strandcli bench`: the time of every stage, with the errors that go with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import click
from click.core import ParameterSource

from ..common.counted import counted
from ..errors import UsageError
from . import options
from .progress import Talk

OWN = {
    "emitter.strands": "--strands", "emitter.particles": "--particles", "image.size": "--size", "solver": "--solver",
    "quality": "--quality", "time.frames": "--frames",
}  # fmt: skip
"""Settings that have options of their own here."""


CHANGED = {"strands": "emitter.strands", "particles": "emitter.particles", "solver": "solver"}
"""Options with defaults of the headline scene, with the setting of a preset that each changes where it is given."""
FRAMES, FRAMES_OF_A_PRESET = 60, 3
AGREE = 0.8, 1.25
"""How many times as long a step may take within frames as alone, for both to count as the same."""


@click.command()
@click.argument("preset", required=False)
@click.option(
    "--strands",
    type=options.COUNT_STRANDS,
    default=10_000,
    metavar="N",
    help="Strands.  [default: 10,000, of PRESET its own]",
)
@click.option(
    "--particles", type=options.COUNT_PARTICLES, default=10, metavar="N",
    help="Particles a strand.  [default: 10, of PRESET its own]",
)  # fmt: skip
@click.option(
    "--frames", type=options.Whole(1, 100_000), metavar="N",
    help=f"Frames to time.  [default: {FRAMES}, of PRESET {FRAMES_OF_A_PRESET}]",
)  # fmt: skip
@click.option("--size", type=options.SIZE, default="800x600", show_default=True, help="Picture.")
@click.option(
    "--solver", default="thesis", metavar="NAME", help="How strands move.  [default: thesis, of PRESET its own]"
)
@click.option(
    "--quality",
    type=click.Choice(("preset", "draft", "default", "best")),
    default="preset",
    show_default=True,
    help="How finely the scene is drawn; preset: as it is written.",
)
@options.overrides
@click.option("--growth", is_flag=True, help="Simulate alone: what a particle costs as strands and particles grow.")
@click.option("--cpu", is_flag=True, help="Of PRESET: the processor's time of all threads, where other programs run.")
@options.threads
@options.talk("Say what is compiled, where stderr is no terminal too.")
@click.pass_context
def command(
    ctx: click.Context,
    preset: str | None,
    strands: int,
    particles: int,
    frames: int | None,
    size: tuple[int, int],
    solver: str,
    quality: str,
    overrides: tuple[str, ...],
    growth: bool,
    cpu: bool,
    threads: int | None,
    talk: Talk,
) -> None:
    """Time every stage on the thesis's headline scene: six rules, smoothing, Marschner, shadow map.

    --set changes it: with image.resolver=sorted, material.model=chiang, material.width=0.0014 and
    lights.0.shadow.model=opacity strands are .2 pixels wide, sorted, and under an opacity map.

    Of PRESET: each stage of its own frames, drawn one by one, and what it works on.

    Compile time is reported apart. Compare times of one sitting only.
    """
    given = {name for name in ctx.params if ctx.get_parameter_source(name) is ParameterSource.COMMANDLINE}
    refuse_contradictions(preset, given, overrides)
    frames = frames or (FRAMES if preset is None else FRAMES_OF_A_PRESET)
    from ..compiling import runtime

    with talk.progress(frames, "bench") as progress:
        runtime.start(threads, progress.note)
        from ..study import bench

        if preset is not None:
            from ..study import bench_preset

            wishes = {"strands": strands, "particles": particles, "solver": solver}
            changes = {path: wishes[name] for name, path in CHANGED.items() if name in given}
            data = bench_preset.run(preset, frames, size, threads, quality, overrides, progress.note, cpu, changes)
        elif growth:
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
    shown = stage_table if preset is not None else growth_table if growth else table
    talk.result(data, lambda: shown(data))
    talk.warn_if_busy(data["busy"], "times are longer than they would be, so repeat this when it is idle")


def refuse_contradictions(preset: str | None, given: set[str], overrides: Sequence[str]) -> None:
    """Raise `UsageError` for options and settings that say the same, or that do not go together."""
    for text in overrides:
        path = text.partition("=")[0].strip()
        free = preset is not None and path in {*CHANGED.values(), "time.frames"}
        if path in OWN and not (free and not any(path == CHANGED.get(name) for name in given)):
            raise UsageError(f"--set {path}: write {OWN[path]} for it")
    if preset is None:
        if "cpu" in given:
            raise UsageError("--cpu: is of a preset; name one, such as strandcli bench hair --cpu")
        return
    if "growth" in given:
        raise UsageError(f"--growth: is of the headline scene, not of {preset}; leave out one of them")


def stage_table(data: Mapping[str, Any]) -> str:
    """A row a stage: what it takes, and what it works on."""
    wide, high = data["size"]
    lines = [
        f"{data['preset']}, {wide}x{high}, {counted(data['frames'], 'frame')} one by one, "
        f"{counted(data['threads'], 'thread')}" + (", the processor's time of all" if data["clock"] == "cpu" else ""),
        "",
        f"{'stage':<10}{'median ms':>10}{'least ms':>10}{'elements':>14} {'each a':<24}{'ns':>8}",
    ]
    for name, row in data["stages"].items():
        line = f"{name:<10}{_ms(row['median_ms']):>10}{_ms(row['min_ms']):>10}"
        if row["element"] is not None:
            line += f"{row['count']:>14,} {row['element']:<24}{row['element_ns']:>8.3g}"
        lines.append(line)
    frame = data["frame"]
    lines += [f"{'frame':<10}{_ms(frame['median_ms']):>10}{_ms(frame['min_ms']):>10}", ""]
    lines.append(f"compiling took {data['compile_seconds']:.1f} s, not counted above")
    return "\n".join(lines)


def table(data: Mapping[str, Any]) -> str:
    """The figures for people: a row a stage, then what they add up to."""
    wide, high = data["size"]
    at_once = data.get("frames_at_once", 1)
    lines = [
        f"{counted(data['strands'], 'strand')} x {data['particles']} particles, {wide}x{high}, "
        f"{counted(data['frames'], 'frame')}, {counted(data['threads'], 'thread')}",
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
    lines.append(f"{'a step of a frame':<20}{step_words(data)}")
    for name, value in data["error"].items():
        if value is not None:
            lines.append(f"{name:<20}{value:>14.3g}")
    lines.append(f"compiling took {data['compile_seconds']:.1f} s, not counted above")
    return "\n".join(lines)


def step_words(data: Mapping[str, Any]) -> str:
    """How many times as long a step takes within frames as alone, and where that is not about once, why."""
    from ..study.busy import busy_words

    ratio = data["particle_step_ns"] / data["steps"]["particle_step_ns"]
    words = f"{ratio:>11.2f} times as long as alone"
    if AGREE[0] <= ratio <= AGREE[1]:
        return words
    at_once, threads = data["frames_at_once"], data["threads"]
    slow = ratio > 1
    why = [f"it has {threads // at_once} of {threads} threads, beside those that draw"] if slow and at_once > 1 else []
    why += [f"alone it waits for the slowest of {threads} threads"] if not slow and threads > 1 else []
    why += ["the machine was busy"] if busy_words(data["busy"]) else []
    return f"{words}: {'; '.join(why) or 'frames leave other data in the caches'}"


def growth_table(data: Mapping[str, Any]) -> str:
    """A row a size: what a step takes, and a particle of it; then the exponents of the cost."""
    lines = [f"{data['solver']}, {counted(data['machine']['threads'], 'thread')}", ""]
    lines.append(f"{'strands':>10}{'particles':>12}{'ms a step':>12}{'ns a particle':>16}")
    for row in data["growth"]:
        lines.append(f"{row['strands']:>10,}{row['particles']:>12,}{row['ms']:>12.2f}{row['particle_step_ns']:>16.1f}")
    found = [f"{grows} ** {power:.3f}" for grows, power in data["exponents"].items() if power is not None]
    if found:
        lines += ["", f"cost grows as {' and as '.join(found)}; ** 1 is linear"]
    return "\n".join(lines)


def _ms(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"
