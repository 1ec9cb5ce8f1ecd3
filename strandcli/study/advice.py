"""The cheapest settings of a preset under an error: what `render --max-error` uses, of motion and of pictures.

A study is cached beside the compiled kernels, by all that it follows from and by all code of strandcli, and serves any
error that is asked for later.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from .. import __version__
from ..compiling import runtime
from ..errors import MismatchError, StrandError
from ..output.files import read_json, write_json
from ..output.report import finite
from ..run.fingerprint import fingerprint, motion_values
from ..scene.model import Scene
from . import sweep
from .motion import Motion
from .pictures.frame import FrameStudy
from .points import described
from .report import seconds, share
from .sweep import STRANDS, Request

ADVISED = ("time.substeps", "rod.iterations", "emitter.particles")
"""The parameters of motion that are varied, unless the user has set them."""
METRICS = {"picture": "rmse", "flip": "flip"}
"""Errors of pictures by the names that they are asked for by."""
UNITS = {"rmse": "of the mean light", "flip": "ꟻLIP"}
FRAME = 1
"""That pictures are studied of, whichever are drawn: what is cached serves all."""
Step = Callable[[str], None]
Begin = Callable[[int], None]


@dataclass(frozen=True)
class Advice:
    """Settings that keep under an error."""

    settings: dict[str, Any]
    """By dotted path, as after `--set`."""
    basis: str
    """What the study was of and the errors that it found, for people."""
    reused: bool
    """Whether the study was made before."""
    report: Mapping[str, Any]
    """What report.json says of it."""

    def text(self) -> str:
        """The line for the user."""
        chosen = " ".join(f"{path}={value}" for path, value in self.settings.items()) or "the preset's own settings"
        return f"{chosen} (by {'an earlier study' if self.reused else 'a study'} of {self.basis})"


def advise(scene: Scene, name: str, max_error: float, fixed: Sequence[str], step: Step, begin: Begin) -> Advice:
    """The cheapest setting of the scene's solver whose error is at most ``max_error``, a share of the strands' length.

    ``fixed`` are parameters that the user has set and that stay. Where no usual setting will do, but the solver has a
    limit, finer ones are tried. Raises `MismatchError` where none of these does either.
    """
    particles = scene.emitter.particles
    finer: dict[str, Any] = {} if "time.substeps" in fixed else {"substeps": (8, 16, 32)}
    finer |= {} if "emitter.particles" in fixed else {"particles": (particles, 2 * particles - 1)}
    for chosen in ({}, finer):
        request = Request(scene=scene, name=name, solvers=(scene.solver,), fixed=frozenset(fixed), **chosen)

        def study(request: Request = request) -> dict[str, Any]:
            found = sweep.run(Motion, request, None, step, begin)
            return {**found.as_dict(), "margin": found.margins[scene.solver]}

        data, reused = cached("motion", motion_of(scene, {**chosen, "fixed": sorted({*fixed} & {*ADVISED})}), study)
        try:
            return choose(data, name, scene.solver, max_error, fixed, reused)
        except MismatchError:
            if chosen is finer or not data["reference"]["limits"][scene.solver]["converges"]:
                raise
    raise AssertionError("the second round returns or raises")


def choose(
    data: Mapping[str, Any], name: str, solver: str, max_error: float, fixed: Sequence[str], reused: bool
) -> Advice:
    """The advice that a study of motion gives. Raises `MismatchError` where no setting keeps under the error."""
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
    basis = f"{STRANDS} strands at the most: error {share(best['error'][metric])} of the length, its limit known to "
    return Advice(settings, basis + share(margin), reused, {})


def advise_picture(
    scene: Scene, name: str, asked: Mapping[str, float], fixed: Sequence[str], step: Step, begin: Begin
) -> Advice:
    """The cheapest settings of drawing whose errors are at most those ``asked`` for, by metric: of windows of the
    scene's first frame, against a converged picture. ``fixed`` are dotted paths that the user has set and that stay.
    Raises `MismatchError` where no settings keep under them, and `UsageError` for scenes that studies do not draw."""

    def study() -> dict[str, Any]:
        request = Request(scene=scene, name=name, frame=FRAME, fixed=frozenset(fixed))
        return sweep.run(FrameStudy, request, None, step, begin).as_dict()

    return choose_picture(*cached("picture", picture_of(scene, fixed), study), name, asked)


def choose_picture(data: Mapping[str, Any], reused: bool, name: str, asked: Mapping[str, float]) -> Advice:
    """The advice that a study of pictures gives. Raises `MismatchError` where no setting keeps under the errors."""
    known = [one for one in data["points"] if all(one["error"].get(metric) is not None for metric in UNITS)]
    fit = [one for one in known if all(one["error"][metric] <= most for metric, most in asked.items())]
    if not fit:
        raise MismatchError(_missed(known, name, asked))
    best, reference = min(fit, key=lambda one: float(one["seconds"])), data["reference"]
    errors = {metric: best["error"][metric] for metric in UNITS}
    words = " and ".join(f"{share(errors[metric])} {unit}" for metric, unit in UNITS.items())
    settings = {**best["parameters"], **reference["width"]}
    report = {
        "asked": dict(asked), "settings": settings,
        "predicted": {**errors, "frame": FRAME, "seconds": best["seconds"]},
        "reference": {"what": reference["what"], "frame": FRAME, "windows": reference["windows"],
                      "nearest": min(one["error"]["rmse"] for one in known)},
        "study": {"remembered": reused, "untried": len(data["points"]) - len(known)},
    }  # fmt: skip
    return Advice(settings, f"windows of frame {FRAME}: {words}, {seconds(best['seconds'])} a frame", reused, report)


def _missed(known: Sequence[Mapping[str, Any]], name: str, asked: Mapping[str, float]) -> str:
    """Why nothing keeps under the errors: the least that was reached, by what, and what it costs."""
    wanted = " and ".join(f"{share(most)} {UNITS[metric]}" for metric, most in asked.items())
    words = f"{name}: no settings of drawing keep under {wanted}; "
    if not known:
        return words + "the frame's windows are black, so that no error is known"
    metric = max(asked, key=lambda one: min(point["error"][one] for point in known) / asked[one])
    best = min(known, key=lambda point: (point["error"][metric], point["seconds"]))
    least = f"the least is {share(best['error'][metric])} in {seconds(best['seconds'])} a frame"
    return f"{words}{least} ({described(best['parameters']) or 'the settings it has'})"


def motion_of(scene: Scene, chosen: Mapping[str, Any]) -> list[Any]:
    """What a study of motion follows from: everything that moves the strands, and the study's parameters."""
    return [STRANDS, motion_values(scene), chosen]


def picture_of(scene: Scene, fixed: Sequence[str]) -> list[Any]:
    """What a study of pictures follows from: everything that changes the picture, the parameters that were fixed, and
    the threads that it is timed with."""
    import numba

    whole = replace(scene, image=replace(scene.image, aovs=()))
    return [fingerprint(whole), FRAME, sorted(fixed), numba.get_num_threads()]


def cached(kind: str, given: Any, make: Callable[[], dict[str, Any]]) -> tuple[dict[str, Any], bool]:
    """The figures of a study that follows from what is ``given``, and whether they are an earlier run's. Where the
    folder cannot be written, the next run makes the study again."""
    text = json.dumps([__version__, _sources(), given], sort_keys=True, default=str)
    path = folder() / f"{kind}-{hashlib.sha256(text.encode()).hexdigest()[:24]}.json"
    with suppress(StrandError):
        earlier: dict[str, Any] = read_json(path)
        return earlier, True
    data: dict[str, Any] = finite(make())
    with suppress(OSError, StrandError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_json(path, data)
    return data, False


def folder() -> Path:
    """Where studies are cached: beside the kernels that they timed, with which they are removed."""
    return runtime.cache_folder() / "studies"


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
