"""The second process of a first frame: who compiles what, and that what it compiles is what the frame calls."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path

import pytest

from strand_kit import frames_of, groom_of, scene_of
from strandcli import rehearsal
from strandcli.draw.coverage.kernels import resolve, tile_binning
from strandcli.draw.film.kernels import film
from strandcli.draw.lighting.kernels import shade_strands, shade_surfaces
from strandcli.draw.rehearse import rehearse
from strandcli.draw.renderer import Renderer
from strandcli.draw.solids.kernels import edges

SCENE = """
emitter: {strands: 1, particles: 2, length: 4, direction: [0, 1, 0], position: [0.05, -2, 1.5],
  shape: {kind: disc, radius: 0.000001}}
rules: []
camera: {kind: perspective, position: [0.1, 0.6, 5], target: [0, 0, 0], fov: 30}
image: {size: [64, 48], resolver: sorted}
curves: {mode: "off"}
material: {width: 0.004, taper: 0, colour: [0.1, 0.9, 0.2], specular: 0, diffuse: 0}
lights: []
solids: [{kind: sphere, radius: 0.5, position: [0.25, 0, 0], colour: [0.2, 0.2, 0.9]}]
"""
KERNELS = {
    "light": (shade_strands.strands, shade_surfaces.surfaces, resolve.compose, film.develop),
    "coverage": (
        edges.depths, edges.find, edges.collect, edges.sample, edges.part, edges.lay, tile_binning.spans,
        tile_binning.share_out,
        resolve.resolve,
    ),
}  # fmt: skip


@pytest.fixture
def helping(monkeypatch: pytest.MonkeyPatch) -> None:
    """A second process is begun whatever the cache holds."""
    monkeypatch.setattr(rehearsal, "_helps", lambda: True)


@pytest.mark.parametrize("part", rehearsal.PARTS)
def test_a_rehearsal_compiles_what_a_frame_calls_and_nothing_else(part: str) -> None:
    scene = scene_of(SCENE)
    frames_of(scene, 1)
    drawn = {kernel: list(kernel.signatures) for kernel in KERNELS[part]}
    assert all(drawn.values())
    calls = {kernel: sum(kernel.stats.cache_hits.values()) for kernel in KERNELS[part]}
    small = dataclasses.replace(scene, image=dataclasses.replace(scene.image, size=(8, 8)))
    rehearse(Renderer(small, groom_of(scene)), part)
    assert {kernel: list(kernel.signatures) for kernel in KERNELS[part]} == drawn
    assert {kernel: sum(kernel.stats.cache_hits.values()) for kernel in KERNELS[part]} == calls


def test_a_part_is_taken_once(tmp_path: Path) -> None:
    (tmp_path / "light").touch()
    assert rehearsal.take(tmp_path, "light")
    assert not rehearsal.take(tmp_path, "light")
    assert not rehearsal.take(tmp_path, "coverage")


def begin(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, program: str) -> rehearsal.Rehearsal:
    """A rehearsal whose second process is a program that finds the folder of parts in `folder`."""
    script = tmp_path / "program.py"
    begins = "import pickle, sys\nfrom pathlib import Path\n_, folder = pickle.load(sys.stdin.buffer)\n"
    script.write_text(begins + program)
    popen = rehearsal.subprocess.Popen
    monkeypatch.setattr(rehearsal.subprocess, "Popen", lambda command, **more: popen([sys.executable, script], **more))
    return rehearsal.Rehearsal(None)


@pytest.mark.usefixtures("helping")
def test_what_the_second_process_has_begun_is_waited_for(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    done = tmp_path / "done"
    one = begin(monkeypatch, tmp_path, f"import time\ntime.sleep(0.3)\nPath({str(done)!r}).touch()\n")
    assert one._folder is not None
    folder = one._folder
    assert rehearsal.take(folder, "light")  # as the second process does
    one.wait("coverage")  # nobody has begun it: no wait
    assert not (folder / "coverage").exists()
    one.wait("light")
    assert done.exists()
    assert not folder.exists()
    one.wait("light")  # of the next frame


@pytest.mark.usefixtures("helping")
def test_what_nobody_has_begun_is_not_waited_for(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    one = begin(monkeypatch, tmp_path, "import time\ntime.sleep(600)\n")
    assert one._folder is not None
    folder = one._folder
    for part in rehearsal.PARTS:
        one.wait(part)
        assert not (folder / part).exists()
    one.stop()
    assert not folder.exists()
