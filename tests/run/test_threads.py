"""No bit of a picture depends on the number of threads: every shipped preset, and scenes at random, at odd sizes.

Pictures are higher than two bands of the z-buffer, and shadow maps than two bands of theirs, so that three threads have
one each.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from strandcli.scene import list_presets
from strandcli.study import golden
from thread_runs import Drawer

GOLDEN = Path(__file__).parents[1] / "golden"
FEWER = {entry.preset: list(entry.overrides) for entry in golden.read_entries(GOLDEN)}
FEWER |= {name: ["children.count=10"] for name in ("hair", "portrait", "ponytail")} | {"minimal": []}
"""Strands so few that all presets take seconds, and enough that some cross every band of a map."""
SIZE = [101, 141]
MAPS = 200
"""Texels along a side of shadow maps."""


@pytest.fixture(scope="module")
def drawer() -> Iterator[Drawer]:
    with Drawer() as one:
        yield one


@pytest.mark.parametrize("preset", [name for name, _ in list_presets()])
def test_presets_have_the_same_pixels_with_any_number_of_threads(preset: str, drawer: Drawer) -> None:
    one, *others = drawer.hashes(
        preset=preset,
        overrides=FEWER[preset],
        settings={"image.size": SIZE, "image.supersample": 1, "time.preroll": 0},
        shadow_size=None if preset.startswith("figures/") else MAPS,
    )
    assert others == [one] * len(others)


LIGHT = {"kind": "directional", "direction": [0.5, -0.7, -0.6], "intensity": 3}
POINT = {"kind": "point", "position": [0.4, 1.5, 2.0], "intensity": 6}
SOLIDS: list[dict[str, Any]] = [
    {"kind": "sphere", "radius": 0.4, "position": [0, 0, 0]},
    {"kind": "box", "size": [0.4, 1.2, 0.3], "position": [0.6, 0.2, -0.3]},
    {"kind": "capsule", "radius": 0.15, "length": 0.8, "position": [-0.5, 0.3, 0.3]},
    {"kind": "plane", "position": [0, -0.6, 0]},
]


def shadows(models: list[str]) -> st.SearchStrategy[dict[str, Any]]:
    model = st.sampled_from(models)
    return st.fixed_dictionaries({"model": model}, optional={"size": st.sampled_from([1, 63, 65, 131, 193])})


@st.composite
def scenes(draw: st.DrawFn) -> dict[str, Any]:
    """Scenes of a few hundred strands that grow from a ball or a square, as wide as anything."""
    resolver = draw(st.sampled_from(["zbuffer", "sorted"]))
    wide = draw(st.sampled_from([0.0, 0.001, 0.01, 0.06]))
    lights = [LIGHT | {"shadow": draw(shadows(["off", "minmax", "opacity"]))}]
    if draw(st.booleans()):
        lights.append(POINT | {"size": draw(st.sampled_from([0, 0.3])), "shadow": draw(shadows(["minmax", "opacity"]))})
    ball = {"kind": "sphere", "radius": 0.45, "cap": draw(st.sampled_from([40, 180]))}
    square = {"kind": "plane", "width": 1.6, "depth": 1.2}
    return {
        "seed": draw(st.integers(0, 1000)),
        "emitter": {
            "shape": draw(st.sampled_from([ball, square])), "strands": draw(st.integers(1, 400)),
            "particles": draw(st.integers(3, 8)), "length": 0.7, "jitter": 25,
        },
        "rules": ["emitter_motion"],
        "camera": {"position": [0.2, 0.5, 2.6], "target": [0, 0.1, 0], "kind": draw(KINDS)},
        "image": {
            "size": [draw(st.integers(1, 131)), draw(st.integers(1, 207))], "resolver": resolver,
            "supersample": draw(st.sampled_from([1, 2])), "aovs": draw(LAYERS),
        },
        "curves": {"mode": draw(st.sampled_from(["off", "fixed", "adaptive", "thinned"]))},
        "material": {"width": wide, "model": "chiang", "pigment": "brown", "scatter": draw(SCATTER)},
        "lights": lights,
        "solids": draw(st.lists(st.sampled_from(SOLIDS), max_size=2, unique_by=lambda one: one["kind"])),
    }  # fmt: skip


LAYERS = st.sampled_from([[], ["depth", "mask", "shadow"]])
KINDS = st.sampled_from(["perspective", "orthographic"])
SCATTER = st.sampled_from(["diffuse", "dual"])


@settings(max_examples=25, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture])
@given(scene=scenes())
def test_random_scenes_have_the_same_pixels_with_1_2_and_3_threads(
    scene: dict[str, Any], drawer: Drawer, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "threads.yaml"
    path.write_text(yaml.safe_dump(scene))
    one, *others = drawer.hashes(preset=str(path), overrides=[], settings={}, shadow_size=None)
    assert others == [one] * len(others)
