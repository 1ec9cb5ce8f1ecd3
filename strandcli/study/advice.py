"""The cheapest setting of a preset's own solver under an error: what `render --max-error` uses.

A study is cached beside the compiled kernels, by everything that moves its strands and by all code of strandcli, and
serves any error that is asked for later.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from .. import __version__
from ..compiling import runtime
from ..errors import MismatchError, StrandError
from ..output.files import read_json, write_json
from ..output.report import finite, is_number, is_number_or_none
from ..scene.dump import plain
from ..scene.model import Scene
from . import sweep
from .axes import STRANDS, Request, settled
from .registry import find
from .report import share

MOVING = ("seed", "solver", "rod", "time", "emitter", "rules", "solids")
"""The settings of a scene that its motion depends on."""
ADVISED = ("time.substeps", "rod.iterations", "emitter.particles")
"""The parameters that are turned, unless the user has set them."""


@dataclass(frozen=True)
class Advice:
    """A setting that keeps under an error."""

    settings: dict[str, Any]
    """By dotted path, as after `--set`."""
    error: float
    margin: float
    """How well the limit is known that the error is measured from."""
    reused: bool
    """Whether the study was made before."""

    def text(self) -> str:
        """The line for the user."""
        chosen = " ".join(f"{path}={value}" for path, value in self.settings.items()) or "nothing to change"
        source = "an earlier study" if self.reused else "a study"
        return (
            f"{chosen} (by {source} of {STRANDS} strands at the most: error {share(self.error)} of the length, "
            f"its limit known to {share(self.margin)})"
        )


def advise(
    scene: Scene,
    name: str,
    max_error: float,
    fixed: Sequence[str] = (),
    step: Callable[[str], None] = lambda text: None,
    begin: Callable[[int], None] = lambda runs: None,
) -> Advice:
    """The cheapest setting of the scene's solver whose error is at most ``max_error``, a share of the strands' length.

    ``fixed`` are parameters that the user has set and that stay. Where no usual setting will do, but the solver has a
    limit, finer ones are tried. Raises `MismatchError` where none of these does either.
    """
    own = settled(scene, fixed)
    for more in ({}, {**finer(scene), **own}):
        chosen = {**own, **more}
        path = folder() / f"{key(scene, chosen)}.json"
        data = read_motion(path, scene.solver)
        reused = data is not None
        if data is None:
            request = Request(scene=scene, name=name, solvers=(scene.solver,), **chosen)
            study = sweep.run(find("motion"), request, None, step, begin)
            data = finite({**study.as_dict(), "margin": study.margins[scene.solver]})
            write(path, data)
        try:
            return choose(data, name, scene.solver, max_error, fixed, reused)
        except MismatchError:
            if more or not data["reference"]["limits"][scene.solver]["converges"]:
                raise
    raise AssertionError("the second round returns or raises")


def finer(scene: Scene) -> dict[str, tuple[int, ...]]:
    """Substeps and particles of a second round."""
    own = scene.emitter.particles
    return {"substeps": (8, 16, 32), "particles": (own, 2 * own - 1)}


def choose(
    data: dict[str, Any], name: str, solver: str, max_error: float, fixed: Sequence[str], reused: bool
) -> Advice:
    """The advice that a study's figures give. Raises `MismatchError` where no setting keeps under the error."""
    metric, margin = data["metric"], data["margin"]
    known = [point for point in data["points"] if point["error"].get(metric) is not None]
    fit = [] if margin is None else [one for one in known if one["error"][metric] + margin <= max_error]
    if not fit:
        if margin is None or margin > max_error:
            why = f"its limit is known to {share(margin)} only" if margin is not None else "it has no limit"
        else:
            why = f"the nearest is {share(min((one['error'][metric] + margin for one in known), default=float('inf')))}"
        other = "" if solver == "rod" else "; the solver rod has a limit: --set solver=rod"
        raise MismatchError(
            f"{name}: no setting of the solver {solver} keeps under an error of {share(max_error)}, {why}{other}; "
            f"'strandcli study {name}' shows all"
        )
    best = min(fit, key=lambda one: float(one["seconds"]))
    settings = {path: value for path, value in best["parameters"].items() if path in ADVISED and path not in fixed}
    return Advice(settings, best["error"][metric], margin, reused)


def folder() -> Path:
    """Where studies are kept: beside the kernels that they timed, and with them forgotten."""
    return runtime.cache_folder() / "studies"


def key(scene: Scene, chosen: dict[str, Any]) -> str:
    """What a study is cached by: everything that moves the strands, the code that does, and the study's parameters."""
    parts = {name: plain(getattr(scene, name)) for name in MOVING}
    return digest([STRANDS, parts, chosen])


def digest(parts: Any) -> str:
    """A name for a study of data that can be written as JSON, by this version of strandcli."""
    text = json.dumps([__version__, _sources(), parts], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:24]


@cache
def _sources() -> str:
    """A hash over all code of strandcli but its command line."""
    root = Path(__file__).parents[1]
    found = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        inside = path.relative_to(root)
        if inside.parts[0] != "cli":
            found.update(str(inside).encode() + b"\0" + path.read_bytes())
    return found.hexdigest()


def read_motion(path: Path, solver: str) -> dict[str, Any] | None:
    """An earlier study of motion; None where there is none that can be read, or one of another shape."""

    def is_sound(data: dict[str, Any]) -> bool:
        converges = data["reference"]["limits"][solver]["converges"]
        return isinstance(data["metric"], str) and isinstance(converges, bool) and is_number_or_none(data["margin"])

    return read(path, is_sound, lambda data: (data["metric"],))


def read(
    path: Path, is_sound: Callable[[dict[str, Any]], bool], metrics: Callable[[dict[str, Any]], Sequence[str]]
) -> dict[str, Any] | None:
    """An earlier study whose points have numbers, or None, as errors by ``metrics``; None where there is none that can
    be read, or one of another shape."""
    try:
        data = read_json(path)
        points = data["points"]
        sound = is_sound(data) and isinstance(points, list)
        for point in points:
            sound = sound and all(is_number_or_none(point["error"].get(metric)) for metric in metrics(data))
            sound = sound and isinstance(point["parameters"], dict) and is_number(point["seconds"])
    except (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError):
        return None
    return data if sound else None


def write(path: Path, data: dict[str, Any]) -> None:
    """Cache a study; a folder that cannot be written costs the next run the same time again, and nothing else."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_json(path, data)
    except (OSError, StrandError):
        return
