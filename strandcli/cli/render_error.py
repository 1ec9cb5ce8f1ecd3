"""`strandcli render --max-error`: settings from studies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from ..errors import UsageError
from . import options, process
from .progress import Talk
from .values import Parsed, bounds

if TYPE_CHECKING:
    from ..scene.model import Scene
    from .progress import Progress

max_error_option = click.option(
    "--max-error", type=Parsed("ERRORS", bounds), metavar="ERRORS",
    help="Errors to stay under: of motion 1% or motion=1%, of the picture picture=2%, to the eye flip=0.05; "
    "several separated by commas.",
)  # fmt: skip


def advised(
    preset: str, bounds: Mapping[str, float], given: dict[str, Any], threads: int | None, talk: Talk
) -> tuple[Scene, Mapping[str, Any] | None]:
    """The scene with the settings that studies choose, and what the report says of its picture's error; None where that
    is not asked for. What the user has set (``given``, as `options.load_scene` takes it) is left alone."""
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
    return changed(scene, advice.settings), advice.report


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
