"""What the tests of simulating and drawing share: scenes from short texts with the real rules, and ways to run them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from numpy.typing import NDArray

from reference.rules import Twin
from strandcli.compiling import runtime
from strandcli.groom.emit import emit
from strandcli.groom.record import Groom
from strandcli.run.frame import Frame
from strandcli.run.pipeline import render
from strandcli.scene import Scene, loads
from strandcli.simulate import advice
from strandcli.simulate.rules import Pass, registry
from strandcli.simulate.solver import Solver
from strandcli.simulate.thesis.solver import ThesisSolver, source

JIT = "from strandcli.jit import function, parallel, prange"
PLAIN = "prange = range\ndef function(f): return f\nparallel = function"


def scene_of(text: str) -> Scene:
    """The scene of a text that has to be valid, with the rules that are shipped."""
    return loads(text, rules=registry(), name="test.yaml")


def warned(scene: Scene | str) -> list[str]:
    """What a run of a scene warns of."""
    scene = scene_of(scene) if isinstance(scene, str) else scene
    return advice.warnings(scene, groom_of(scene))


def groom_of(scene: Scene) -> Groom:
    """All strands of a scene's emitter."""
    return emit(scene.emitter, scene.seed)


def solver_of(scene: Scene, plain: bool = False) -> ThesisSolver:
    """A solver; ``plain`` runs its composed step as ordinary Python, lane by lane, so that nothing is compiled."""
    with patch("strandcli.simulate.thesis.solver.step_for", plain_step) if plain else nullcontext():
        return ThesisSolver(scene, groom_of(scene))


def plain_step(passes: Sequence[Pass], folder: Path) -> Callable[..., None]:
    """The composed step with its decorators taken off."""
    text = source(passes)
    assert JIT in text
    names: dict[str, Any] = {}
    exec(text.replace(JIT, PLAIN), names)
    step: Callable[..., None] = names["step"]
    return step


def twin_of(scene: Scene) -> Twin:
    """The float64 twin of a scene, from the same groom."""
    groom = groom_of(scene)
    return Twin(scene, groom.roots, groom.directions, groom.lengths)


def frames_of(scene: Scene, *frames: int, **options: Any) -> list[Frame]:
    """Rendered frames with their positions; on one thread, where nothing else is asked for: tests run side by side, and
    pictures so small are not worth a second."""
    return list(render(scene, frames or None, keep_positions=True, **({"threads": 1} | options)))


def require_alike(left: Sequence[Frame], right: Sequence[Frame], detail: bool = False) -> None:
    """Fail where frames differ by a bit. ``detail``: the right ones have only strands that level of detail draws."""
    assert [one.number for one in left] == [one.number for one in right]
    for a, b in zip(left, right, strict=True):
        np.testing.assert_array_equal(a.positions[: len(b.positions)] if detail else a.positions, b.positions)
        np.testing.assert_array_equal(a.image, b.image)
        assert detail or (a.report["error"], a.report["counts"]) == (b.report["error"], b.report["counts"])


def need_frames_at_once() -> None:
    """Skip the test where frames cannot be drawn at once, which is known when a kernel has run."""
    list(render(scene_of("emitter: {strands: 1, particles: 2}\n"), [1], threads=1, draw=False))
    if not runtime.entered_by_several():
        pytest.skip("Numba found neither OpenMP (the package libgomp1) nor TBB: frames are drawn one by one")


def moved(scene: Scene, frame: int, plain: bool = True) -> NDArray[np.float32]:
    """(strands, particles, 3) at a frame."""
    solver = solver_of(scene, plain)
    solver.advance(frame)
    return solver.particles()


def require_same_after_restart(whole: Solver, half: Solver) -> None:
    """Fail where a solver that goes on from the state of another in frame 12 differs from it in frame 20 by a bit."""
    whole.advance(12)
    half.restore(whole.state_arrays())
    for one in (whole, half):
        one.frame = 12
        one.advance(20)
    np.testing.assert_array_equal(whole.particles(), half.particles())
