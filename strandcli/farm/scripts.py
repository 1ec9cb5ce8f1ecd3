"""Job files: scripts of the stages, and how Slurm or GNU parallel runs them, in POSIX sh; and a template of Open Job
Description."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from typing import Any

from .job import CHUNKS, FRAMES, POSITIONS, SCENE, Job

JOB, SUBMIT, RUN = "job.sh", "submit.sh", "run.sh"

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

        return {TEMPLATE: yaml.safe_dump(template(job), sort_keys=False, allow_unicode=True, width=100)}
    if target == "slurm":
        return {JOB: _stages(job), SUBMIT: _slurm(job), CHUNKS: _lines(job.chunks)}
    return {JOB: _stages(job), RUN: _parallel(job, cores), CHUNKS: _lines(job.chunks)}


def _lines(words: Sequence[str]) -> str:
    return "".join(f"{word}\n" for word in words)


def _stages(job: Job) -> str:
    simulate = f'strandcli {shlex.join(job.simulate())} --threads "$threads"' if job.simulated else ":"
    draw = shlex.join(job.draw("CHUNK")).replace("-f CHUNK", '-f "$frames"')
    command = f"{shlex.quote(sys.executable)} -m strandcli"
    return STAGES.format(
        name=_comment(job.name), command=command, threads=job.threads, warmup=shlex.join(job.warm_up()),
        simulate=simulate, draw=draw, join=shlex.join(job.join()), chunks=CHUNKS,
    )  # fmt: skip


def _slurm(job: Job) -> str:
    short = "".join(c if c.isascii() and c.isalnum() else "-" for c in job.name)[:40].strip("-") or "strands"
    simulate = SIMULATE.format(short=short) if job.simulated else ""
    return SLURM.format(
        name=_comment(job.name), count=len(job.chunks), threads=job.threads, short=short, last=len(job.chunks) - 1,
        simulate=simulate, after="moved" if job.simulated else "warm", memory=job.memory,
        warm_memory=job.warm_up_memory,
    )  # fmt: skip


def _parallel(job: Job, cores: int) -> str:
    return PARALLEL.format(
        name=_comment(job.name), threads=job.threads, jobs=max(1, cores // job.threads), chunks=CHUNKS,
        simulate="sh job.sh simulate\n" if job.simulated else "",
    )  # fmt: skip


def _comment(text: str) -> str:
    """Text that ends neither a comment nor a line."""
    return "".join(c if c.isprintable() else "?" for c in text)


TEMPLATE = "job.yaml"
SPECIFICATION = "jobtemplate-2023-09"
COMMAND = "{{Param.Strandcli}}"
PATHS = {"scene": "{{Param.Scene}}", "positions": "{{Param.Positions}}", "frames": "{{Param.Frames}}"}


def template(job: Job) -> dict[str, Any]:
    """A template of Open Job Description (specification jobtemplate-2023-09) as plain data, which several render
    managers take."""
    draw = job.draw("{{Task.Param.Chunk}}", **PATHS)
    steps = [_step(job, "Warm up", job.warm_up(PATHS["scene"]))]
    if job.simulated:
        moved = job.simulate(PATHS["scene"], PATHS["positions"])
        steps.append(_step(job, "Simulate", moved, after=steps[-1]["name"]))
    steps.append(_step(job, "Draw", draw, after=steps[-1]["name"], chunks=job.chunks))
    steps.append(_step(job, "Join", job.join(**PATHS), after="Draw"))
    return {
        "specificationVersion": SPECIFICATION,
        "name": "".join(c if c.isprintable() and c not in "{}" else "-" for c in job.name)[:120] or "strands",
        "parameterDefinitions": [
            _path("Scene", SCENE, "FILE", "IN", "Preset with all settings"),
            _path("Positions", POSITIONS, "DIRECTORY", "INOUT", "Simulated positions"),
            _path("Frames", FRAMES, "DIRECTORY", "INOUT", "Pictures, animation, report"),
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
    action = {"command": COMMAND, "args": [*arguments, "--threads", str(job.threads)]}
    step["script"] = {"actions": {"onRun": action}}
    return step
