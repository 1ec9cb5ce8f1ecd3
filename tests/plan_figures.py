"""Hold `plan` to what runs take: `make plan-figures`.

Each case is planned and then rendered, without the pre-roll, by processes of their own with warm kernels. A line a case:
the peak of memory that was planned and the one that the system measured, the ratio of the two, and the same of time.
Exits with 1 where a figure is farther off than its bound.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
PRESETS = (
    "minimal",
    "headline",
    "hair",
    "portrait",
    "ponytail",
    "fur",
    "grass",
    "fox",
    "curly",
    "bob",
    "groom",
    "solvers",
)
SIZES = ("320x240", "1280x960")
MEMORY = 1.15
"""Times by which planned memory may be off."""
TIME = 2.0
"""Times by which planned time may be off."""
PROCESSOR = """
import sys, time
time.perf_counter = time.process_time
from strandcli.cli.main import main
raise SystemExit(main(sys.argv[1:]))
"""
"""The command line with times of the processor in its report, for machines that do other things meanwhile."""
USUAL = ("-f", "1-2", "--set", "time.preroll=0")


def case(preset: str, *more: str) -> tuple[str, ...]:
    """Arguments of `render` for a case."""
    return (preset, *more)


def cases() -> list[tuple[str, ...]]:
    """All presets at two sizes, and what makes a run large."""
    found = [case(name, "--size", size) for name in PRESETS for size in SIZES]
    found += [case(f"figures/{path.stem}") for path in sorted((ROOT / "presets/figures").glob("*.yaml"))]
    for count in (1_000, 10_000, 100_000, 300_000):
        for more in (
            (), ("--set", "image.resolver=sorted"), ("--set", "lights.0.shadow.model=opacity"),
        ):  # fmt: skip
            found.append(case("headline", "--strands", str(count), *more))
    rods = ("--set", "solver=rod", "--set", "rules.stiffness=null")
    for count in (1_000, 30_000):
        found.append(case("minimal", "--strands", str(count), "--set", "solver=rod"))
        found.append(
            case(
                "minimal",
                "--strands",
                str(count),
                "--set",
                "solver=rod",
                "--set",
                "rules.interaction={}",
            )
        )
    del rods
    for model in ("off", "minmax", "opacity", "traced"):
        for resolver in ("zbuffer", "sorted"):
            found.append(case("headline", "--size", "640x480", "--set", f"lights.0.shadow.model={model}",
                              "--set", f"image.resolver={resolver}", "--set", "material.width=0.0006"))  # fmt: skip
    found.append(case("hair", "--size", "640x480", "--quality", "draft"))
    found.append(case("hair", "--size", "640x480", "--quality", "best"))
    found.append(case("hair", "--size", "640x480", "--aov", "depth,mask,tangent,strand_id"))
    found.append(case("fur", "--size", "640x480", "--strands", "3000"))
    return found


def run(arguments: list[str], output: Path) -> tuple[int, int, float]:
    """Exit code, peak bytes and seconds of the processor of a command."""
    with open(output, "w", encoding="utf-8") as out:
        pid = os.posix_spawn(
            sys.executable, [sys.executable, "-c", PROCESSOR, *arguments], os.environ,
            file_actions=[(os.POSIX_SPAWN_DUP2, out.fileno(), 1), (os.POSIX_SPAWN_DUP2, out.fileno(), 2)],
        )  # fmt: skip
        _, status, usage = os.wait4(pid, 0)
    scale = 1 if sys.platform == "darwin" else 1024
    return os.waitstatus_to_exitcode(status), usage.ru_maxrss * scale, usage.ru_utime + usage.ru_stime


def measured(arguments: tuple[str, ...], threads: int, folder: Path) -> dict[str, Any]:
    """Planned and measured figures of a case."""
    text = folder / "said.txt"
    done = subprocess.run([sys.executable, "-m", "strandcli", "plan", *arguments, *USUAL, "--json"],
                          capture_output=True, text=True)  # fmt: skip
    if done.returncode:
        return {"case": " ".join(arguments), "failed": done.stderr}
    plan = json.loads(done.stdout)
    status, peak, cpu = run(["render", *arguments, *USUAL, "-o", str(folder / "out"), "--overwrite", "--threads",
                             str(threads), "--no-progress"], text)  # fmt: skip
    if status:
        return {"case": " ".join(arguments), "failed": text.read_text(encoding="utf-8")}
    report = json.loads((folder / "out/report.json").read_text(encoding="utf-8"))
    compiled = report.get("compile_seconds")
    return {"case": " ".join(arguments), "planned": plan["memory_bytes"], "peak": peak, "cpu": cpu,
            "compile": compiled, "frames": report["frames"], "plan": plan}  # fmt: skip


def main() -> int:
    """Measure all cases, or those that a word names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("words", nargs="*", help="cases that have one of these in their arguments")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="a file of lines of JSON to add what is measured to")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        for arguments in cases():
            if given.words and not any(word in " ".join(arguments) for word in given.words):
                continue
            found = measured(arguments, given.threads, Path(name))
            if "failed" in found:
                print(f"{found['case']}: {found['failed']}", flush=True)
                continue
            ratio = found["planned"] / found["peak"]
            print(f"{ratio:5.2f} {found['planned'] / 1e6:8.0f} {found['peak'] / 1e6:8.0f} MB {found['cpu']:6.1f} s "
                  f"{found['compile'] or 0:5.1f} {found['case']}", flush=True)  # fmt: skip
            if given.keep:
                with open(given.keep, "a", encoding="utf-8") as out:
                    out.write(json.dumps(found) + "\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
