"""A template of Open Job Description (specification jobtemplate-2023-09), which several render managers take."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .job import FRAMES, POSITIONS, SCENE, Job

JOB = "job.yaml"
SPECIFICATION = "jobtemplate-2023-09"
COMMAND = "{{Param.Strandcli}}"
PATHS = {"scene": "{{Param.Scene}}", "positions": "{{Param.Positions}}", "frames": "{{Param.Frames}}"}


def files(job: Job) -> dict[str, str]:
    """The template by its file's name."""
    import yaml

    return {JOB: yaml.safe_dump(template(job), sort_keys=False, allow_unicode=True, width=100)}


def template(job: Job) -> dict[str, Any]:
    """The template as plain data."""
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
