"""`strandcli bench`: the time of every stage, with the errors that go with it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click

from ..common.counted import counted
from ..errors import UsageError
from . import options
from .progress import Talk

OWN = {
    "emitter.strands": "--strands", "emitter.particles": "--particles", "solver": "--solver", "image.size": "--size",
}  # fmt: skip
"""Settings that have options of their own here."""
USUAL = {"emitter.strands": 10_000, "emitter.particles": 10, "solver": "thesis"}
"""Those of the headline scene."""
FRAMES, FRAMES_OF_A_PRESET = 60, 3
AGREE = 0.8, 1.25
"""How many times as long a step may take within frames as alone, for both to count as the same."""


@click.command()
@click.argument("preset", required=False)
@click.option(
    "--strands", type=options.COUNT_STRANDS, metavar="N", help="Strands.  [default: 10,000, of PRESET its own]"
)
@click.option(
    "--particles", type=options.COUNT_PARTICLES, metavar="N",
    help="Particles a strand.  [default: 10, of PRESET its own]",
)  # fmt: skip
@click.option(
    "--frames", type=options.Whole(1, 100_000), metavar="N",
    help=f"Frames to time.  [default: {FRAMES}, of PRESET {FRAMES_OF_A_PRESET}]",
)  # fmt: skip
@click.option("--size", type=options.SIZE, default="800x600", show_default=True, help="Picture.")
@click.option("--solver", metavar="NAME", help="How strands move.  [default: thesis, of PRESET its own]")
@options.overrides
@click.option("--growth", is_flag=True, help="Simulate alone: what a particle costs as strands and particles grow.")
@click.option("--cpu", is_flag=True, help="Of PRESET: the processor's time of all threads, where other programs run.")
@options.threads
@options.talk("Say what is compiled, where stderr is no terminal too.")
def command(
    preset: str | None, strands: int | None, particles: int | None, frames: int | None, size: tuple[int, int],
    solver: str | None, overrides: tuple[str, ...], growth: bool, cpu: bool, threads: int | None, talk: Talk,
) -> None:  # fmt: skip
    """Time every stage on the thesis's headline scene: six rules, smoothing, Marschner, shadow map.

    --set changes it: with image.resolver=sorted, material.model=chiang, material.width=0.0014 and
    lights.0.shadow.model=opacity strands are .2 pixels wide, sorted, and under an opacity map.

    Of PRESET: each stage of its own frames, drawn one by one, and what it works on.

    Compile time is reported apart. Compare times of one sitting only.
    """
    for path in (text.partition("=")[0].strip() for text in overrides):
        if path in OWN:
            raise UsageError(f"--set {path}: write {OWN[path]} for it")
    if cpu and preset is None:
        raise UsageError("--cpu: is of a preset; name one, such as strandcli bench hair --cpu")
    if growth and preset is not None:
        raise UsageError(f"--growth: is of the headline scene, not of {preset}; leave out one of them")
    given = {"emitter.strands": strands, "emitter.particles": particles, "solver": solver}
    changes = {path: value for path, value in given.items() if value is not None}
    frames = frames or (FRAMES if preset is None else FRAMES_OF_A_PRESET)
    with talk.compiled(frames, "bench", threads) as progress:
        from ..compiling import runtime
        from ..study import bench

        if preset is not None:
            from ..study import bench_preset

            data = bench_preset.run(preset, frames, size, threads, overrides, progress.note, cpu, changes)
        elif growth:
            moved_by = solver or "thesis"
            grown = bench.time_growth(moved_by, overrides, progress.note)
            data = {"solver": moved_by, **grown, "machine": runtime.machine()}
        else:
            data = bench.run({**USUAL, **changes}, frames, size, threads, overrides, progress.note)
    shown = growth_table if growth else table
    talk.result(data, lambda: shown(data))
    talk.warn_if_busy(data["busy"], "times are longer than they would be, so repeat this when it is idle")


def table(data: Mapping[str, Any]) -> str:
    """A row a stage: what it takes, and of a preset what it works on; then what the headline scene has besides."""
    wide, high = data["size"]
    frames, threads = counted(data["frames"], "frame"), counted(data["threads"], "thread")
    of_preset = "preset" in data
    subject = data.get("preset") or f"{counted(data['strands'], 'strand')} x {data['particles']} particles"
    words = ", the processor's time of all" if data.get("clock") == "cpu" else ""
    lines = [f"{subject}, {wide}x{high}, {frames}{' one by one' if of_preset else ''}, {threads}{words}", ""]
    if data.get("frames_at_once", 1) > 1:
        lines[1:1] = [f"{data['frames_at_once']} frames at once, each on its share of threads"]
    head = f"{'elements':>14} {'each a':<24}{'ns':>8}" if of_preset else ""
    lines.append(f"{'stage':<12}{'median ms':>10}{'least ms':>10}{head}")
    for name, row in {**data["stages"], "frame": data["frame"]}.items():
        line = f"{name:<12}{_ms(row['median_ms']):>10}{_ms(row.get('min_ms')):>10}"
        if row.get("element") is not None:
            line += f"{row['count']:>14,} {row['element']:<24}{row['element_ns']:>8.3g}"
        lines.append(line)
    lines.append("")
    if not of_preset:
        lines.append(f"{'frames a second':<20}{data['frame']['fps']:>14.1f}")
        lines += [f"{name:<20}{value:>14,}" for name, value in data["counts"].items()]
        lines.append(f"{'particle_step_ns':<20}{data['particle_step_ns']:>14.3g}")
        step = "particle_step_ns", "a particle and step"
        for name, unit, of in (("steps", *step), ("rules", *step), ("lines", "fragment_ns", "a fragment")):
            lines.append(f"{name + ' alone':<20}{data[name]['ms']:>11.2f} ms   {data[name][unit]:.2f} ns {of}")
        lines.append(f"{'a step of a frame':<20}{step_words(data)}")
        lines += [f"{name:<20}{value:>14.3g}" for name, value in data["error"].items() if value is not None]
    return "\n".join([*lines, f"compiling took {data['compile_seconds']:.1f} s, not counted above"])


def step_words(data: Mapping[str, Any]) -> str:
    """How many times as long a step takes within frames as alone, and where that is not about once, why."""
    from ..study.bench import busy_words

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
