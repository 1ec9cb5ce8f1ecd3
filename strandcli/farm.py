"""Job files for schedulers: kernels are compiled once, the scene is simulated once, chunks of frames are drawn side by
side, and the animation is joined. Scripts of POSIX sh for Slurm and GNU parallel, or a template of Open Job
Description."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from .plan import SHARE

SCENE, CHUNKS = "scene.yaml", "chunks.txt"
"""Beside the job files: the preset with all settings, and a line a chunk."""
MOST_CHUNKS = 1000
"""Tasks of one job: Slurm takes 1,001 of an array as it comes, Open Job Description 1,024 of a step."""
USUAL_CHUNK = 8
"""Frames: a task starts in two seconds, which should be little beside its work."""
COMPILER = 700
"""MiB of a process that compiles: 530 were measured of `hair`."""


class Places(NamedTuple):
    """Where a job has its files, as its commands name them."""

    scene: str = SCENE
    positions: str = "positions"
    frames: str = "frames"


HERE = Places()


@dataclass(frozen=True, slots=True)
class Job:
    """A run in pieces. ``name``: the preset's, for people; ``chunks``: frames of each task, as ``-f`` takes them;
    ``simulated``: frames whose positions are needed, "" where nothing is simulated beforehand; ``threads`` and
    ``memory``, MiB: of a task; ``animate``: kinds of animation, "" for none; ``extra``: options of render that every
    task has."""

    name: str
    frames: str
    chunks: tuple[str, ...]
    simulated: str
    threads: int
    memory: int
    animate: str = ""
    extra: tuple[str, ...] = ()

    @property
    def warm_up_memory(self) -> int:
        """MiB of the task that compiles, a process a thread."""
        return max(self.memory, (self.threads + 1) * COMPILER)

    def stages(self, chunk: str, places: Places = HERE) -> dict[str, list[str]]:
        """Arguments of strandcli by stage: to compile, to simulate, to draw a chunk, and to look whether all frames are
        there, draw what is missing, and make animation and report."""
        positions = ["--from-cache", places.positions] if self.simulated else []
        draw, again = ["render", places.scene, *positions, "-o", places.frames], ["--resume", "--no-progress"]
        animate = ["--animate", self.animate] if self.animate else []
        return {
            "warmup": ["warmup", places.scene, "--quiet"],
            "simulate": ["simulate", places.scene, "-o", places.positions, "-f", self.simulated, *again],
            "draw": [*draw, "-f", chunk, *self.extra, "--no-html", *again],
            "join": [*draw, "-f", self.frames, *self.extra, *animate, *again],
        }


def asked_memory(planned: int) -> int:
    """MiB to ask a scheduler for, of the bytes that a plan tells within 15 %: so many that they are no more than the
    share of free memory that a run may take."""
    return math.ceil(1.15 * planned / SHARE / (1 << 20))


def chunks_of(frames: Sequence[int], size: int | None = None) -> tuple[str, ...]:
    """Ascending frames in chunks of ``size``, as ``-f`` takes them; by default of eight, more where there would be too
    many. Raises ``ValueError`` for too many chunks."""
    least = -(-len(frames) // MOST_CHUNKS)
    if size is not None and size < least:
        raise ValueError(
            f"--chunk {size}: makes {-(-len(frames) // size):,} tasks; at most {MOST_CHUNKS:,}: take {least}"
        )
    each = size or max(USUAL_CHUNK, least)
    return tuple(spelled(frames[i : i + each]) for i in range(0, len(frames), each))


def spelled(frames: Sequence[int]) -> str:
    """Ascending frames as ``-f`` takes them: ``1-8``, ``1-29x4``, ``1-3,9``."""
    parts: list[tuple[int, int, int]] = []  # first, last, step
    for frame in frames:
        if parts:
            first, last, step = parts[-1]
            if first == last or frame - last == step:
                parts[-1] = first, frame, frame - last
                continue
        parts.append((frame, frame, 1))
    return ",".join(
        f"{first}" if first == last else f"{first}-{last}" + ("" if step == 1 else f"x{step}")
        for first, last, step in parts
    )


STAGES = """\
#!/bin/sh
# Stages of "{name}": sh job.sh warmup | simulate | draw [FRAMES] | join, in this folder.
# All of them may run again: complete files are skipped.
set -eu
strandcli() {{
  if [ -n "${{STRANDCLI:-}}" ]; then $STRANDCLI "$@"; else {command} "$@"; fi
}}
threads="${{SLURM_CPUS_PER_TASK:-{threads}}}"
cores="$(OMP_NUM_THREADS= OMP_THREAD_LIMIT= nproc 2>/dev/null || getconf _NPROCESSORS_ONLN || echo "$threads")"
if [ "$threads" -gt "$cores" ]; then threads="$cores"; fi
case "$1" in
  warmup) strandcli {warmup} --threads "$threads" ;;
  simulate) {simulate} ;;
  draw)
    frames="${{2:-}}"
    if [ -z "$frames" ]; then frames="$(sed -n "$((SLURM_ARRAY_TASK_ID + 1))p" {chunks})"; fi
    strandcli {draw} --threads "$threads" ;;
  join) strandcli {join} --threads "$threads" ;;
  *) echo "job.sh: no stage '$1'" >&2; exit 2 ;;
esac
"""

SLURM = """\
#!/bin/sh
# Submit "{name}" to Slurm: kernels, motion, {count} tasks of frames, then all joined, each after what it needs.
# Options of sbatch go with it: sh submit.sh --partition=short --time=2:00:00 --mem=8G
# Submit it again after a failure: finished work is not repeated.
# This folder has to be on storage that all nodes share, and so has the cache of kernels: STRANDCLI_CACHE_DIR.
set -eu
cd "$(dirname "$0")"
mkdir -p logs
submit() {{
  id="$(sbatch --parsable --chdir="$(pwd)" --cpus-per-task={threads} --mem={memory}M --requeue \\
    --kill-on-invalid-dep=yes "$@")"
  echo "${{id%%;*}}"
}}
warm="$(submit --job-name={short}-warmup --output=logs/warmup-%j.txt --mem={warm_memory}M "$@" job.sh warmup)"
{simulate}drawn="$(submit --job-name={short}-draw --output=logs/draw-%A-%a.txt --array=0-{last} \\
  --dependency="afterok:${after}" "$@" job.sh draw)"
joined="$(submit --job-name={short}-join --output=logs/join-%j.txt --dependency="afterok:$drawn" "$@" job.sh join)"
echo "submitted: the last job is $joined; frames go to $(pwd)/frames"
"""
SIMULATE = """\
moved="$(submit --job-name={short}-simulate --output=logs/simulate-%j.txt \\
  --dependency="afterok:$warm" "$@" job.sh simulate)"
"""

PARALLEL = """\
#!/bin/sh
# Run "{name}" on this machine by GNU parallel, {threads} threads a task; its options go with it:
#   sh run.sh --sshloginfile nodes.txt --workdir .   # on several that share this folder
# Run it again after a failure: finished work is not repeated.
set -eu
cd "$(dirname "$0")"
sh job.sh warmup
{simulate}parallel --halt soon,fail=1 --jobs "${{JOBS:-{jobs}}}" "$@" sh job.sh draw {{}} :::: {chunks}
sh job.sh join
"""


def files(job: Job, target: str, cores: int) -> dict[str, str]:
    """The files for a target by name. ``cores``: of this machine, for GNU parallel."""
    if target == "openjd":
        import yaml

        return {"job.yaml": yaml.safe_dump(template(job), sort_keys=False, allow_unicode=True, width=100)}
    stages = {name: shlex.join(words) for name, words in job.stages("CHUNK").items()}
    short = "".join(c if c.isascii() and c.isalnum() else "-" for c in job.name)[:40].strip("-") or "strands"
    slurm = target == "slurm"
    known = {
        "name": "".join(c if c.isprintable() else "?" for c in job.name),  # which ends neither a comment nor a line
        "command": f"{shlex.quote(sys.executable)} -m strandcli", "threads": job.threads, "chunks": CHUNKS, **stages,
        "draw": stages["draw"].replace("-f CHUNK", '-f "$frames"'), "short": short, "count": len(job.chunks),
        "last": len(job.chunks) - 1, "after": "moved" if job.simulated else "warm", "memory": job.memory,
        "warm_memory": job.warm_up_memory, "jobs": max(1, cores // job.threads),
    }  # fmt: skip
    simulate = f'strandcli {stages["simulate"]} --threads "$threads"' if job.simulated else ":"
    submitted = (SIMULATE.format(**known) if slurm else "sh job.sh simulate\n") if job.simulated else ""
    return {
        "job.sh": STAGES.format(**{**known, "simulate": simulate}),
        "submit.sh" if slurm else "run.sh": (SLURM if slurm else PARALLEL).format(**{**known, "simulate": submitted}),
        CHUNKS: "".join(f"{chunk}\n" for chunk in job.chunks),
    }


PARAMETERS = Places("{{Param.Scene}}", "{{Param.Positions}}", "{{Param.Frames}}")


def template(job: Job) -> dict[str, Any]:
    """A template of Open Job Description (specification jobtemplate-2023-09) as plain data, which several render
    managers take."""
    stages = job.stages("{{Task.Param.Chunk}}", PARAMETERS)
    titles = {"warmup": "Warm up", "simulate": "Simulate", "draw": "Draw", "join": "Join"}
    steps: list[dict[str, Any]] = []
    for stage, title in titles.items():
        if stage != "simulate" or job.simulated:
            after = steps[-1]["name"] if steps else ""
            steps.append(_step(job, title, stages[stage], after, job.chunks if stage == "draw" else ()))
    return {
        "specificationVersion": "jobtemplate-2023-09",
        "name": "".join(c if c.isprintable() and c not in "{}" else "-" for c in job.name)[:120] or "strands",
        "parameterDefinitions": [
            _path("Scene", SCENE, "FILE", "IN", "Preset with all settings"),
            _path("Positions", HERE.positions, "DIRECTORY", "INOUT", "Simulated positions"),
            _path("Frames", HERE.frames, "DIRECTORY", "INOUT", "Pictures, animation, report"),
            {"name": "Strandcli", "type": "STRING", "default": "strandcli", "description": "The command on the hosts"},
        ],
        "steps": steps,
    }


def _path(name: str, default: str, kind: str, flow: str, words: str) -> dict[str, str]:
    return {"name": name, "type": "PATH", "objectType": kind, "dataFlow": flow, "default": default,
            "description": words}  # fmt: skip


def _step(job: Job, name: str, arguments: Sequence[str], after: str = "", chunks: Sequence[str] = ()) -> dict[str, Any]:
    """A step that runs strandcli, once or for each chunk; the first one compiles."""
    step: dict[str, Any] = {"name": name}
    if after:
        step["dependencies"] = [{"dependsOn": after}]
    if chunks:
        definition = {"name": "Chunk", "type": "STRING", "range": list(chunks)}
        step["parameterSpace"] = {"taskParameterDefinitions": [definition]}
    memory = job.memory if after else job.warm_up_memory
    needs = {"amount.worker.vcpu": job.threads, "amount.worker.memory": memory}
    step["hostRequirements"] = {"amounts": [{"name": key, "min": least} for key, least in needs.items()]}
    action = {"command": "{{Param.Strandcli}}", "args": [*arguments, "--threads", str(job.threads)]}
    step["script"] = {"actions": {"onRun": action}}
    return step
