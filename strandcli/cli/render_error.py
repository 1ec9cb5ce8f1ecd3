"""`strandcli render --max-error`: settings from studies, and what is known of the pictures' error afterwards."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import click

from ..errors import StrandError, UsageError
from . import options, process
from .progress import Talk
from .values import Parsed, bounds

if TYPE_CHECKING:
    from ..output.report import RunReport
    from ..run.frame import Frame
    from ..scene.model import Scene
    from ..study.advice import Advice
    from .progress import Progress

max_error_option = click.option(
    "--max-error", type=Parsed("ERRORS", bounds), metavar="ERRORS",
    help="Errors to stay under: of motion 1% or motion=1%, of the picture picture=2%, to the eye flip=0.05; "
    "several separated by commas.",
)  # fmt: skip


def advised(
    preset: str,
    bounds: Mapping[str, float],
    given: dict[str, Any],
    threads: int | None,
    talk: Talk,
) -> tuple[Scene, PictureError | None]:
    """The scene with the settings that studies choose, and what its picture's error is bound to; None where that is not
    asked for. What the user has set (``given``, as `options.load_scene` takes it) is left alone."""
    process.resume()  # studies make many runs
    scene = options.load_scene(preset, **given)
    fixed = {text.partition("=")[0].strip() for text in given["overrides"]}
    if given["particles"] is not None:
        fixed.add("emitter.particles")
    if "motion" in bounds:
        given = {**given, "overrides": (*given["overrides"], *_motion(scene, preset, bounds, fixed, talk))}
        scene = options.load_scene(preset, **given)
    asked = {name: most for name, most in bounds.items() if name != "motion"}
    if not asked:
        return scene, None
    if given["quality"] is not None or "quality" in fixed:
        raise UsageError("--quality: --max-error chooses how finely a picture is drawn; leave one of the two out")
    from ..compiling import runtime
    from ..study.advice import METRICS, advise_picture
    from ..study.axes import changed

    name = options.preset_name(preset)
    wanted = {METRICS[one]: most for one, most in asked.items()}
    with _progress(talk) as progress:
        runtime.start(threads, progress.note)
        advice = advise_picture(scene, name, wanted, sorted(fixed), progress.checked_step, progress.begin)
    _report(name, asked, advice.text(), talk)
    return changed(scene, advice.settings), PictureError(scene, name, advice)


def _motion(scene: Scene, preset: str, bounds: Mapping[str, float], fixed: set[str], talk: Talk) -> tuple[str, ...]:
    """Settings of motion under an error, as after --set."""
    from ..compiling import runtime
    from ..study.advice import advise

    with _progress(talk) as progress:
        runtime.start(1, progress.note)  # as `strandcli study` does
        name = options.preset_name(preset)
        advice = advise(scene, name, bounds["motion"], sorted(fixed), progress.checked_step, progress.begin)
    _report(name, {"": bounds["motion"]}, advice.text(), talk)
    return tuple(f"{path}={value}" for path, value in advice.settings.items())


def _progress(talk: Talk) -> Progress:
    return talk.progress(1, "study", each="run", lines=True)


def _report(name: str, asked: Mapping[str, float], text: str, talk: Talk) -> None:
    from ..study.report import share

    words = ", ".join(f"{one} {share(most)}".strip() for one, most in asked.items())
    talk.note(f"{name}: under {words}: {text}")


class PictureError:
    """The error that a run's pictures are bound to, and the frame that is looked at afterwards: the first it draws."""

    def __init__(self, scene: Scene, name: str, advice: Advice) -> None:
        """``scene``: before the advice."""
        self._scene, self._name, self._advice = scene, name, advice
        self._frame: Frame | None = None

    def keep(self, frame: Frame) -> None:
        """Remember the first frame that is drawn."""
        if self._frame is None and frame.image is not None:
            self._frame = frame

    def check(self, report: RunReport, warn: Callable[[str], None], notify: Callable[[str], None]) -> None:
        """Measure that frame's error, write it into the report, and warn where it is more than was asked for. A frame
        that cannot be measured again costs the report its figures, and not the run its pictures."""
        found: dict[str, Any] = {**self._advice.report, "measured": None}
        report.picture_error = found
        frame, image = self._frame, None if self._frame is None else self._frame.image
        if frame is None or image is None:
            return
        from ..study.advice import check
        from ..study.report import share

        notify(f"measuring the error of frame {frame.number}")
        try:
            found["measured"] = check(
                self._scene, self._name, frame.number, image, frame.positions, self._advice.settings
            )
        except StrandError as trouble:
            warn(f"frame {frame.number}: its error could not be measured: {trouble}")
            return
        for metric, most in self._advice.report["asked"].items():
            error = found["measured"][metric]
            if error is not None and error > most:
                warn(f"frame {frame.number}: its error ({metric}) is {share(error)}, more than {share(most)}")
