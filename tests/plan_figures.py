"""Hold `plan` to what runs take: `make plan-figures`.

Each case is planned, and then rendered without the pre-roll by a process of its own with compiled kernels on one
thread; some as a whole on two. A line a case: the peak of memory that was planned and that the system measured, and the
processor's seconds of a frame and of the whole run, with the ratios. Exits with 1 where a ratio is beyond its bound.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

MEMORY, TIME = 1.15, 2.0
"""Times by which planned figures may be off."""
PRESETS = (
    "minimal", "headline", "hair", "portrait", "ponytail", "fur", "grass", "fox", "curly", "bob", "curls", "brush",
    "rope",
)  # fmt: skip
SIZES = ("320x240", "1280x960")
SETTLED = ("hair", "curls", "bob", "curly", "ponytail", "grass", "brush", "minimal")
"""Of these, memory alone is held to what a whole run takes, with the pre-roll and two frames drawn at once."""
SHORT = ("solvers", "groom", "figures/fig02", "figures/fig10")
ROD = ("minimal", "--set", "solver=rod", "--set", "rules=[gravity, collision]")
PROCESSOR = """
import sys, time
time.perf_counter = time.process_time
from strandcli.cli.main import main
raise SystemExit(main(sys.argv[1:]))
"""
"""The command line with the processor's times in its report, for machines that do other things meanwhile."""


class Measured(NamedTuple):
    """Figures of a case: bytes, seconds of the last frame, and of the whole process."""

    planned: float
    peak: float
    planned_frame: float
    frame: float
    planned_run: float
    run: float

    def ratios(self) -> tuple[float, float, float]:
        """Planned over measured: memory, frame, run."""
        return self.planned / self.peak, self.planned_frame / self.frame, self.planned_run / self.run

    def within(self) -> bool:
        """Whether all are within bounds."""
        memory, *times = self.ratios()
        return 1 / MEMORY <= memory <= MEMORY and all(1 / TIME <= one <= TIME for one in times)


def cases() -> list[tuple[str, ...]]:
    """All presets at two sizes, and what makes a run large."""
    found = [(name, "--size", size, "-f", "1-3") for name in PRESETS for size in SIZES]
    found += [(name, "-f", "1") for name in SHORT]
    shown = ("--size", "640x480", "-f", "1-3")
    for count in ("1000", "100000", "300000"):
        found.append(("headline", "--strands", count, *shown))
    found.append(("headline", "--strands", "100000", "--set", "image.resolver=sorted", *shown))
    for resolver in ("zbuffer", "sorted"):
        for model in ("opacity", "minmax"):
            light = ("--set", f"lights.0.shadow.model={model}", "--set", f"image.resolver={resolver}")
            found.append(("headline", *light, "--set", "material.width=0.004", *shown))
    for more, counts in (
        ((), ("2000", "30000")), (("--set", "rules.interaction={}"), ("2000", "30000")),
        (("--set", "rules.contact={}"), ("1000", "3000", "8000", "20000")),
    ):  # fmt: skip
        found += [(*ROD, *more, "--strands", count, *shown) for count in counts]
    double = ("--set", "rod.rest=sag_free", "--set", "emitter.particles=21")
    found.append((*ROD, *double, "--strands", "30000", *shown))
    found += [(name, "-f", "1-4", "--threads", "2") for name in SETTLED]
    found += [("hair", "--quality", name, *shown) for name in ("draft", "best")]
    found.append(("hair", "--aov", "depth,mask,tangent,strand_id", *shown))
    return found


def run(arguments: tuple[str, ...], said: Path) -> tuple[int, float]:
    """Exit code and the processor's seconds of a command."""
    with open(said, "w", encoding="utf-8") as out:
        pid = os.posix_spawn(
            sys.executable, [sys.executable, "-c", PROCESSOR, *arguments], os.environ,
            file_actions=[(os.POSIX_SPAWN_DUP2, out.fileno(), 1), (os.POSIX_SPAWN_DUP2, out.fileno(), 2)],
        )  # fmt: skip
        _, status, usage = os.wait4(pid, 0)
    return os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime


def measured(case: tuple[str, ...], folder: Path, keep: Path | None = None, timed: bool = True) -> Measured:
    """The figures of a case; ``timed``: with those of time. What compiles is run again."""
    said, whole = folder / "said.txt", "--threads" in case
    usual = case if whole else (*case, "--set", "time.preroll=0", "--threads", "1")
    command = [sys.executable, "-m", "strandcli", "plan", *(usual if "--aov" not in usual else without_aov(usual))]
    if timed:
        command.append("--time")
    asked = subprocess.run([*command, "--json"], capture_output=True, text=True)
    if asked.returncode:
        raise RuntimeError(asked.stderr)
    plan = json.loads(asked.stdout)
    for _ in range(2):
        status, seconds = run(
            ("render", *usual, "-o", str(folder / "out"), "--overwrite", "--no-progress"), said
        )  # fmt: skip
        if status:
            raise RuntimeError(said.read_text(encoding="utf-8"))
        report = json.loads((folder / "out" / "report.json").read_text(encoding="utf-8"))
        if not report["compile_seconds"]:
            break
    peak = report["totals"]["peak_rss_bytes"]
    if keep is not None:
        with open(keep, "a", encoding="utf-8") as out:
            out.write(json.dumps({"case": " ".join(case), "peak": peak, "cpu": seconds, "frames": report["frames"],
                                  "compile": report["compile_seconds"], "plan": plan}) + "\n")  # fmt: skip
    frame = report["frames"][-1]["seconds"]["total"]
    if whole or not timed:
        return Measured(plan["memory_at_once_bytes"], peak, 1.0, 1.0, 1.0, 1.0)
    if len(report["frames"]) == 1:  # which has loaded kernels: the run alone tells
        frame = plan["time"]["frame"]
    return Measured(plan["memory_bytes"], peak, plan["time"]["frame"], frame, plan["time"]["total"], seconds)


def without_aov(arguments: tuple[str, ...]) -> tuple[str, ...]:
    """`plan` has layers by --set alone."""
    at = arguments.index("--aov")
    return (*arguments[:at], "--set", f"image.aovs=[{arguments[at + 1]}]", *arguments[at + 2 :])


def told(case: tuple[str, ...], found: Measured) -> str:
    """A line for people."""
    memory, frame, whole = found.ratios()
    mark = "  " if found.within() else "! "
    return (
        f"{mark}{memory:5.2f} {found.planned / 1e6:7.0f} {found.peak / 1e6:7.0f} MB  {frame:5.2f} "
        f"{found.planned_frame:6.2f} {found.frame:6.2f} s a frame  {whole:5.2f} {found.planned_run:5.1f} "
        f"{found.run:5.1f} s  {' '.join(case)}"
    )


def main() -> int:
    """Measure all cases, or those that have a word in their arguments."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("words", nargs="*")
    parser.add_argument("--keep", type=Path, help="file of lines of JSON to add what is measured to")
    given: Any = parser.parse_args()
    missed = 0
    print("  ratio planned    peak       ratio planned measured        ratio planned measured", flush=True)
    with tempfile.TemporaryDirectory() as name:
        for case in cases():
            if not given.words or any(word in " ".join(case) for word in given.words):
                found = measured(case, Path(name), given.keep)
                missed += not found.within()
                print(told(case, found), flush=True)
    return min(missed, 1)


if __name__ == "__main__":
    raise SystemExit(main())
