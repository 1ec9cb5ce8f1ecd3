"""The strands that five presets draw, children among them, handed to Mitsuba 3: `make check-against-mitsuba`.

What is compared is direct light on strands: of each preset's first frame, with its camera, its lights as points far
away, its width, roughness and mean colour, without solids, sky and light from strand to strand, which the path tracer
would need other models for, and at a quarter of the picture's size. Strands are those of `strandcli export`. What
differs is told in `test_mitsuba`.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba
import pytest

pytest.importorskip("mitsuba", reason="Mitsuba is not installed: make check-against-mitsuba")

import strandcli
from path_tracer import Figures, Traced, figures, seconds_to, trace
from strandcli.export import drawn_strands
from strandcli.frame_renderer import FrameRenderer
from strandcli.scene.motion import camera_at
from strandcli.stages import RunOptions, SimulationStage
from strandcli.study.pictures.settings import changed, knows
from strandcli.study.pictures.subject import LinearRenderer

SIZE = (200, 150)
SAMPLES = {"hair": 256, "portrait": 256, "ponytail": 256, "fur": 128, "grass": 64}
"""A pixel, of each of two pictures."""
MOST = {"hair": (0.2, 0.02), "portrait": (0.26, 0.02), "ponytail": (0.4, 0.12), "fur": (0.19, 0.03),
        "grass": (0.16, 0.02)}  # fmt: skip
"""RMSE and distance of the brightness from 1 that stand today; .1 and .02 are aimed at."""
FINE = {"hair": 0.09, "portrait": 0.11, "ponytail": 0.13, "fur": 0.13}
"""The same with `nearby` shadows and 5 × 5 samples, whose brightness is within .02."""
FINE_SETTINGS = {"image.supersample": 5, "curves.tolerance": 0.01}
"""A strand that is a quarter of a sample off stands elsewhere among its neighbours, by about its own width."""
PLAIN: dict[str, Any] = {
    "material.colour_variation": 0.0, "material.tip_colour": None, "material.grey": 0.0, "material.scatter": "diffuse",
    "material.diffuse": 0.0, "image.background": (0.0, 0.0, 0.0), "image.horizon": None, "image.haze": None,
    "ambient": (0.0, 0.0, 0.0), "environment": None, "detail": None, "image.size": SIZE, "time.preroll": 0.0,
}  # fmt: skip
"""Settings in which the path tracer has the same scene."""


def plain(preset: str) -> Any:
    """A preset as the path tracer can draw it, its strands moved among its solids."""
    scene = strandcli.load(preset)
    unseen = tuple(changed(solid, {"visible": False}) for solid in scene.solids)
    scene = changed(scene, {path: value for path, value in PLAIN.items() if knows(scene, path)} | {"solids": unseen})
    lights = tuple(changed(light, {"size": 0.0}) for light in scene.lights)
    pose = camera_at(scene.camera, 0.0)
    camera = {"camera.position": tuple(pose[0]), "camera.target": tuple(pose[1]), "camera.keys": ()}
    return changed(scene, {"lights": lights, **camera})


class Drawn(LinearRenderer):
    """Keeps itself, to be asked for the linear picture."""

    last: Any = None

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        Drawn.last = self


def drawn(scene: Any, times: int = 2) -> tuple[Any, float]:
    """The first frame in linear light, and the least seconds of drawing it on all cores."""
    numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
    moved = SimulationStage(scene, [1], None, RunOptions())
    draw, begun = FrameRenderer(moved, Drawn), moved.begin(1)
    seconds = []
    for _ in range(times):
        report = draw(begun).report["seconds"]
        seconds.append(sum(took for stage, took in report.items() if stage not in ("simulate", "write") and took))
    return Drawn.last.linear, min(seconds)


@pytest.mark.parametrize("preset", ["hair", "portrait", "ponytail", "fur", "grass"])
def test_strands_of_presets_have_the_same_direct_light(tmp_path: Path, preset: str) -> None:
    scene = plain(preset)
    (one,) = drawn_strands(scene, [1])
    assert all(end - begin > 3 for begin, end in pairwise(one.strands.first))
    traced = trace(SimpleNamespace(scene=scene), tmp_path, SAMPLES[preset], strands=one.strands)
    image, seconds = drawn(scene)
    found = figures(image, traced)
    print(f"\n{preset}: {one.strands.count:,} strands, exact rays {traced.exact}\n{words(found, seconds, traced)}")
    models = [f"lights.{number}.shadow.model" for number in range(len(scene.lights))]
    exact, nearby = (dict.fromkeys(models, model) for model in ("traced", "nearby"))
    for name, settings in {
        "3 × 3 samples": {"image.supersample": 3},
        "exact shadows": {"image.supersample": 3, **exact},
        "nearby": {"image.supersample": 3, **nearby},
        "fine": {**FINE_SETTINGS, **nearby},
    }.items():
        if name == "fine" and preset not in FINE:
            continue
        image, seconds = drawn(changed(scene, settings), 1)
        fine = figures(image, traced)
        print(f"{name}: {words(fine, seconds, traced)}")
    if preset in FINE:
        assert fine.rmse < FINE[preset]
        assert abs(fine.brightness - 1) < 0.02
    most, apart = MOST[preset]
    assert found.rmse < most
    assert abs(found.brightness - 1) < apart


def words(found: Figures, seconds: float, traced: Traced) -> str:
    """What was found, and the times beside each other."""
    slow = seconds_to(found.rmse, found, traced)
    return f"{found}; {seconds:.2f} s, the path tracer {slow:.0f} s to that error: {slow / seconds:.0f} times"
