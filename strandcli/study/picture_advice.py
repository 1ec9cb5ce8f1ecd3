"""The cheapest settings of drawing under an error: what `render --max-error picture=ERROR` uses.

Like a study of motion, one of a picture is cached (`advice`), by everything that changes the picture.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MismatchError
from ..output.report import finite
from ..run.fingerprint import fingerprint
from ..scene.model import Scene
from . import advice, sweep
from .axes import Request
from .pictures.frame import CHECKED, FrameStudy
from .points import described
from .report import seconds, share
from .settings import changed

METRICS = {"picture": "rmse", "flip": "flip"}
"""Errors of points by the names that they are asked for by."""
SAID = {"rmse": "of the mean light", "flip": "ꟻLIP"}
FRAME = 1
"""That is studied, whichever are drawn: what is remembered serves all."""


@dataclass(frozen=True)
class PictureAdvice:
    """Settings of drawing that keep under an error."""

    settings: dict[str, Any]
    """By dotted path."""
    asked: dict[str, float]
    """By metric."""
    error: dict[str, float]
    """By metric, as the study has it."""
    seconds: float
    """That drawing a frame takes, as the study has it."""
    reference: dict[str, Any]
    untried: int
    """Settings that there was no time for."""
    reused: bool
    """Whether the study was made before."""

    def apply(self, scene: Scene) -> Scene:
        """A scene with these settings."""
        return changed(scene, self.settings)

    def text(self) -> str:
        """The line for the user."""
        chosen = " ".join(f"{path}={value}" for path, value in self.settings.items()) or "the preset's own settings"
        source = "an earlier study" if self.reused else "a study"
        errors = " and ".join(f"{share(self.error[name])} {words}" for name, words in SAID.items())
        return f"{chosen} (by {source} of windows of frame {FRAME}: {errors}, {seconds(self.seconds)} a frame)"

    def report(self) -> dict[str, Any]:
        """What report.json says of it."""
        return {
            "asked": self.asked,
            "settings": self.settings,
            "predicted": {**self.error, "frame": FRAME, "seconds": self.seconds},
            "reference": self.reference,
            "study": {"remembered": self.reused, "untried": self.untried},
        }


def advise(
    scene: Scene,
    name: str,
    asked: Mapping[str, float],
    fixed: Sequence[str] = (),
    step: Callable[[str], None] = lambda text: None,
    begin: Callable[[int], None] = lambda runs: None,
) -> PictureAdvice:
    """The cheapest settings of drawing whose errors are at most those ``asked`` for, by metric: of windows of the
    scene's first frame, against a converged picture. ``fixed`` are dotted paths that the user has set and that stay.
    Raises `MismatchError` where no settings keep under them, and `UsageError` for scenes that studies do not draw."""
    request = Request(scene=scene, name=name, frame=FRAME, fixed=frozenset(fixed))
    path = advice.folder() / f"picture-{key(scene, fixed)}.json"
    data = read_picture(path)
    reused = data is not None
    if data is None:
        study = sweep.run(FrameStudy, request, None, step, begin)
        data = finite(study.as_dict())
        advice.write(path, data)
    return choose(data, name, asked, reused)


def choose(data: Mapping[str, Any], name: str, asked: Mapping[str, float], reused: bool) -> PictureAdvice:
    """The advice that a study's figures give. Raises `MismatchError` where no setting keeps under the errors."""
    known = [one for one in data["points"] if all(one["error"].get(metric) is not None for metric in SAID)]
    untried = len(data["points"]) - len(known)
    fit = [one for one in known if all(one["error"][metric] <= most for metric, most in asked.items())]
    if not fit:
        raise MismatchError(_missed(known, name, asked, untried))
    best = min(fit, key=lambda one: float(one["seconds"]))
    reference = data["reference"]
    finest = min((one["error"]["rmse"] for one in known), default=None)
    told = {"what": reference["what"], "frame": FRAME, "windows": reference["windows"], "nearest": finest}
    errors = {metric: best["error"][metric] for metric in SAID}
    settings = {**best["parameters"], **reference["width"]}
    return PictureAdvice(settings, dict(asked), errors, best["seconds"], told, untried, reused)


def _missed(known: Sequence[Mapping[str, Any]], name: str, asked: Mapping[str, float], untried: int) -> str:
    """Why nothing keeps under the errors: the least that was reached, by what, and what it costs."""
    wanted = " and ".join(f"{share(most)} {SAID[metric]}" for metric, most in asked.items())
    words = f"{name}: no settings of drawing keep under {wanted}; "
    if not known:
        return words + "the frame's windows are black, so that no error is known"
    metric = max(asked, key=lambda one: min(point["error"][one] for point in known) / asked[one])
    best = min(known, key=lambda point: (point["error"][metric], point["seconds"]))
    words += f"the least is {share(best['error'][metric])} in {seconds(best['seconds'])} a frame"
    words += f" ({described(best['parameters']) or 'the settings it has'})"
    return words + (f"; {untried} more were not tried, for lack of time" if untried else "")


def check(
    scene: Scene, name: str, number: int, image: NDArray[np.uint8], positions: NDArray[np.float32] | None,
    settings: Mapping[str, Any],
) -> dict[str, Any]:  # fmt: skip
    """The errors of a frame that was drawn with ``settings``, in other windows than those of the study, by metric.

    image (height, width, 3): the frame's pixels; positions (strands, particles, 3): its simulated strands, or None to
    simulate them again. The frame's light, which its pixels do not tell, is that of the frame drawn once more;
    ``redrawn_apart`` is the mean difference of the two in pixels, a share of their range.
    """
    study = FrameStudy(Request(scene=scene, name=name, frame=number), CHECKED, positions)
    windows = study.windows
    windows.move()
    study.draw_reference()
    again = windows.draw_whole(changed(study.scene, settings))
    drawn = np.concatenate(windows.cut(image))
    assert again.pixels is not None
    levels = np.abs(np.concatenate(windows.cut(again.pixels)).astype(np.int16) - drawn)
    return {
        "frame": number,
        "rmse": study.rmse(np.concatenate(windows.cut(again.image))),
        "flip": study.flip(drawn),
        "windows": [list(window) for window in windows.windows],
        "redrawn_apart": float(levels.mean()) / 255,
    }


def key(scene: Scene, fixed: Sequence[str]) -> str:
    """What a study is cached by: everything that changes the picture, the parameters that were fixed, and the
    threads that it was timed with."""
    import numba

    whole = replace(scene, image=replace(scene.image, aovs=()))
    return advice.digest([fingerprint(whole), FRAME, sorted(fixed), numba.get_num_threads()])


def read_picture(path: Path) -> dict[str, Any] | None:
    """An earlier study; None where there is none that can be read, or one of another shape."""

    def is_sound(data: dict[str, Any]) -> bool:
        reference = data["reference"]
        kinds = {"what": str, "windows": list, "width": dict}
        return all(isinstance(reference[name], kind) for name, kind in kinds.items())

    return advice.read(path, is_sound, lambda data: tuple(SAID))
