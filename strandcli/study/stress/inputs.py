"""Bad input: every case has to be refused in words that name it, and none may reach a kernel."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from ...errors import UsageError
from ...groom.emit import emit
from ...output.positions import read_positions
from ...scene import loads
from ...simulate import solver_of
from ...simulate.rules import registry

PRESET = "solver: {solver}\nemitter: {{strands: 2, particles: 4}}\nrules: [gravity]\n"

SETTINGS: dict[str, tuple[str, str]] = {
    "length-negative": ("emitter.length", "-1"),
    "length-zero": ("emitter.length", "0"),
    "length-nan": ("emitter.length", ".nan"),
    "length-inf": ("emitter.length", ".inf"),
    "density-negative": ("rod.density", "-1"),
    "density-zero": ("rod.density", "0"),
    "density-nan": ("rod.density", ".nan"),
    "radius-negative": ("rod.radius", "-1e-4"),
    "radius-zero": ("rod.radius", "0"),
    "modulus-negative": ("rod.young", "-4e9"),
    "modulus-zero": ("rod.young", "0"),
    "modulus-inf": ("rod.young", ".inf"),
    "step-negative": ("time.fps", "-24"),
    "step-zero": ("time.fps", "0"),
    "step-nan": ("time.fps", ".nan"),
    "substeps-zero": ("time.substeps", "0"),
    "substeps-negative": ("time.substeps", "-1"),
    "position-nan": ("emitter.position", "[0, .nan, 0]"),
    "position-inf": ("emitter.position", "[.inf, 0, 0]"),
}
"""Name: the setting and what is written there."""


def refused_setting(solver: str, *, path: str, value: str) -> str:
    """The words that a preset with this value is refused with; "" where it is not."""
    group, key = path.split(".")
    text = PRESET.format(solver=solver)
    line = f"  {key}: {value}\n"
    if group == "emitter":
        text = text.replace("emitter: {strands: 2, particles: 4}\n", f"emitter:\n  strands: 2\n{line}")
    else:
        text += f"{group}:\n{line}"
    try:
        loads(text, rules=registry(), name="preset.yaml")
    except UsageError as error:
        place = text.split("\n").index(line.rstrip("\n")) + 1
        told = str(error)
        return told if told.startswith(f"preset.yaml:{place}:") and path in told else ""
    return ""


def refused_groom(solver: str, *, part: str, value: float) -> str:
    """The words that a solver refuses a groom with, one strand of which has this value in one part."""
    scene = loads(PRESET.format(solver=solver), rules=registry())
    groom = emit(scene.emitter, 0)
    broken = np.array(getattr(groom, part))
    broken[1] = value
    try:
        solver_of(scene)(scene, replace(groom, **{part: broken}))  # type: ignore[arg-type]
    except UsageError as error:
        return str(error) if "strand 1" in str(error) else ""
    return ""


def refused_cache(solver: str, *, value: float) -> str:
    """The words that positions of an earlier run are refused with, one coordinate of which has this value."""
    positions = np.zeros((2, 4, 3), np.float32)
    positions[1, 2, 0] = value
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "positions_0001.npz")
        np.savez(path, positions=positions)
        try:
            read_positions(path, positions.shape)
        except UsageError as error:
            told = str(error).replace(str(path), path.name)
            return told if "strand 1" in told else ""
    return ""


INPUTS: dict[str, Callable[[str], str]] = {
    **{f"input={name}": partial(refused_setting, path=path, value=value) for name, (path, value) in SETTINGS.items()},
    **{
        f"input=groom-{part}-{label}": partial(refused_groom, part=part, value=value)
        for part, label, value in (
            ("roots", "nan", np.nan), ("roots", "inf", np.inf), ("directions", "nan", np.nan),
            ("directions", "zero", 0.0), ("lengths", "nan", np.nan), ("lengths", "negative", -1.0),
            ("lengths", "zero", 0.0),
        )
    },
    "input=cache-nan": partial(refused_cache, value=np.nan),
    "input=cache-inf": partial(refused_cache, value=np.inf),
}  # fmt: skip
"""By the name that follows the solver's."""
