"""The cheapest setting of a preset's own solver under an error: what `render --max-error` uses.

A study of a preset is kept beside the compiled kernels, by everything that moves its strands, and serves any error that
is asked for later.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from .. import __version__, runtime
from ..errors import MismatchError, StrandError
from ..output.earlier import is_number, is_number_or_none
from ..output.files import read_json, write_json
from ..output.report import finite
from ..scene.dump import plain
from ..scene.model import Scene
from . import sweep
from .axes import STRANDS, Request, settled
from .chart import share
from .registry import find

MOVING = ("seed", "solver", "rod", "time", "emitter", "rules", "solids")
"""The settings of a scene that its motion depends on."""
KNOBS = ("time.substeps", "rod.iterations", "emitter.particles")
"""The knobs that are turned, unless the user has set them."""


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

    ``fixed`` are knobs that the user has set and that stay. Where no usual setting will do, but the solver has a limit,
    finer ones are tried. Raises `MismatchError` where none of these does either.
    """
    kept = settled(scene, fixed)
    for more in ({}, {**finer(scene), **kept}):
        chosen = {**kept, **more}
        path = folder() / f"{key(scene, chosen)}.json"
        data = _read(path, scene.solver)
        reused = data is not None
        if data is None:
            request = Request(scene=scene, name=name, solvers=(scene.solver,), **chosen)
            study = sweep.run(find("motion"), request, None, step, begin)
            data = finite({**study.as_dict(), "margin": study.margins[scene.solver]})
            keep(path, data)
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
    settings = {path: value for path, value in best["knobs"].items() if path in KNOBS and path not in fixed}
    return Advice(settings, best["error"][metric], margin, reused)


def folder() -> Path:
    """Where studies are kept: beside the kernels that they timed, and with them forgotten."""
    return runtime.cache_folder() / "studies"


def key(scene: Scene, kept: dict[str, Any]) -> str:
    """What a study is kept by: everything that moves the strands, the code that does, and the knobs that were fixed."""
    parts = {name: plain(getattr(scene, name)) for name in MOVING}
    text = json.dumps([__version__, _sources(), STRANDS, parts, kept], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:24]


@cache
def _sources() -> str:
    """A hash over the code of solvers and of studies."""
    root = Path(__file__).parent
    digest = hashlib.sha256()
    for path in sorted([*root.rglob("*.py"), *root.parent.glob("simulate/**/*.py")]):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


def _read(path: Path, solver: str) -> dict[str, Any] | None:
    """An earlier study; None where there is none that can be read, or one of another shape."""
    try:
        data = read_json(path)
        points, margin = data["points"], data["margin"]
        metric, converges = data["metric"], data["reference"]["limits"][solver]["converges"]
        sound = isinstance(metric, str) and isinstance(converges, bool) and is_number_or_none(margin)
        for point in points:
            error = point["error"].get(metric)
            sound = sound and is_number_or_none(error) and isinstance(point["knobs"], dict)
            sound = sound and is_number(point["seconds"])
    except (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError):
        return None
    return data if sound and isinstance(points, list) else None


def keep(path: Path, data: dict[str, Any]) -> None:
    """Keep a study; a folder that cannot be written costs the next run the same time again, and nothing else."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_json(path, data)
    except (OSError, StrandError):
        return
