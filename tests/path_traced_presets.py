"""The strands that five presets draw, children among them, by strandcli and by Mitsuba 3: prints JSON.

    python tests/path_traced_presets.py [PRESET ...]

What is compared is direct light on strands: of the frame of each preset that the README shows, settled as shipped, with
its camera, its lights as points far away, its width, roughness and mean colour, without solids, sky and light from
strand to strand, which the path tracer would need other models for, and with a smaller picture. Strands are those of
`strandcli export`. `test_mitsuba` tells what else differs.
"""

from __future__ import annotations

import json
import sys
import tempfile
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba

import strandcli
from path_tracer import figures, seconds_to, trace
from strandcli.run.export import drawn_strands
from strandcli.run.frame import FrameRenderer
from strandcli.run.stages import RunOptions, SimulationStage
from strandcli.scene.motion import camera_at
from strandcli.study.pictures.subject import LinearRenderer
from strandcli.study.sweep import changed, knows

SIZE = (320, 240)
FRAMES = {"hair": 10, "portrait": 1, "ponytail": 20, "fur": 36, "grass": 12}
"""As `make gallery` draws them."""
SAMPLES = 256
"""A pixel, of each of two pictures."""
PLAIN: dict[str, Any] = {
    "material.colour_variation": 0.0, "material.tip_colour": None, "material.grey": 0.0, "material.scatter": "diffuse",
    "material.diffuse": 0.0, "image.background": (0.0, 0.0, 0.0), "image.horizon": None, "image.haze": None,
    "ambient": (0.0, 0.0, 0.0), "environment": None, "detail": None, "image.size": SIZE,
}  # fmt: skip
"""Settings in which the path tracer has the same scene."""
FINE = {"image.supersample": 5, "curves.tolerance": 0.01}
"""A strand that is a quarter of a sample off stands elsewhere among its neighbours, by about its own width."""


def plain(preset: str, frame: int) -> Any:
    """A preset's frame as the path tracer can draw it, its strands moved among its solids."""
    scene = strandcli.load(preset)
    unseen = tuple(changed(solid, {"visible": False}) for solid in scene.solids)
    scene = changed(scene, {path: value for path, value in PLAIN.items() if knows(scene, path)} | {"solids": unseen})
    lights = tuple(changed(light, {"size": 0.0}) for light in scene.lights)
    pose = camera_at(scene.camera, (frame - 1) / scene.time.fps)
    camera = {"camera.position": tuple(pose[0]), "camera.target": tuple(pose[1]), "camera.keys": ()}
    return changed(scene, {"lights": lights, **camera})


class Drawn(LinearRenderer):
    """Keeps itself, to be asked for the linear picture."""

    last: Any = None

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        Drawn.last = self


def drawn(scene: Any, frame: int, times: int = 1) -> tuple[Any, float]:
    """A frame in linear light, and the least seconds of drawing it on all cores."""
    numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
    moved = SimulationStage(scene, [frame], None, RunOptions())
    draw, begun = FrameRenderer(moved, Drawn), moved.begin(frame)
    seconds = []
    for _ in range(times):
        report = draw(begun).report["seconds"]
        seconds.append(sum(took for stage, took in report.items() if stage not in ("simulate", "write") and took))
    return Drawn.last.linear, min(seconds)


def measured(preset: str, folder: Path) -> dict[str, Any]:
    """Of a preset's frame the figures of each picture by name; times of both programs."""
    frame = FRAMES[preset]
    scene = plain(preset, frame)
    (one,) = drawn_strands(scene, [frame])
    assert all(end - begin > 3 for begin, end in pairwise(one.strands.first))
    traced = trace(SimpleNamespace(scene=scene), folder, SAMPLES, strands=one.strands)
    pictures = {}
    for name, settings in {
        "as it is": {},
        "3 × 3 samples": {"image.supersample": 3},
        "5 × 5, tolerance .01": FINE,
    }.items():
        image, seconds = drawn(changed(scene, settings), frame, times=1 if settings else 2)
        found = figures(image, traced)
        slow = seconds_to(max(found.rmse, found.sure), found, traced)
        pictures[name] = {**found._asdict(), "seconds": seconds, "path_tracer_seconds": slow}
        print(f"{preset}, {name}: {found}, {seconds:.2f} s, the path tracer {slow:.0f} s", file=sys.stderr, flush=True)
    return {"preset": preset, "frame": frame, "strands": one.strands.count, "size": SIZE, "exact": traced.exact,
            "pictures": pictures}  # fmt: skip


def main() -> None:
    """Measure the presets that are named, or all."""
    shots = []
    for preset in sys.argv[1:] or FRAMES:
        with tempfile.TemporaryDirectory() as folder:
            shots.append(measured(preset, Path(folder)))
    print(json.dumps({"shots": shots}))


if __name__ == "__main__":
    main()
