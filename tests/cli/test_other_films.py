"""What was made from another scene, or with other settings, is never taken for a part of this film."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from cli_runs import Runner
from strandcli.output import png

LOOP = """
time: {frames: 8, loop: true}
emitter: {strands: 60, particles: 5, length: 0.6, keys: [{time: 0}, {time: 0.2, rotation: [0, 90, 0]}]}
image: {size: [64, 48]}
rules: [emitter_motion, gravity, {wind: {strength: 4, gust: 1, period: 0.3}}, elasticity]
"""
OTHER = "or with other settings, so --resume would mix two"
MOTION = "which moves strands otherwise; simulate it anew"


@pytest.fixture
def run(run: Runner) -> Runner:
    Path("loop.yaml").write_text(LOOP, encoding="utf-8")
    return run


def fine(run: Runner, words: str) -> str:
    return run.fine(*words.split(), "--no-html").err


def simulated(run: Runner, words: str) -> None:
    assert run(*f"simulate tiny.yaml {words} -q".split()).code == 0


def refused(run: Runner, words: str, *parts: str) -> None:
    result = run(*words.split())
    assert result.code == 2
    assert all(part in result.error() for part in parts), result.err


def pixels(folder: str, frame: int) -> np.ndarray:
    return png.read(Path(folder, f"frame_{frame:04d}.png"))


def test_positions_of_another_motion_are_not_resumed(run: Runner) -> None:
    simulated(run, "-f 1-2 -o a")
    for other in ("--set seed=7", "--set wind.strength=3", "--particles 6"):
        refused(run, f"simulate tiny.yaml {other} -f 1-4 -o a --resume", "positions_0001.npz", OTHER)
    simulated(run, "-f 1-4 -o a --resume --set camera.position=[0,1,9] --set time.frames=40")
    simulated(run, "-f 1-4 -o b")
    for frame in range(1, 5):
        assert Path(f"a/positions_{frame:04d}.npz").read_bytes() == Path(f"b/positions_{frame:04d}.npz").read_bytes()


def test_positions_of_another_motion_are_not_drawn(run: Runner) -> None:
    simulated(run, "-f 1-2 -o a")
    draw = "render tiny.yaml --from-cache a -f 1-2 -q"
    for other, key in {
        "wind.strength=9": "wind.strength", "emitter.length=0.7": "emitter.length", "seed=3": "seed",
        "time.substeps=2": "time.substeps", "solids=[{kind: sphere}]": "solids", "gravity.acceleration=[0,0,1]":
        "gravity.acceleration",
    }.items():  # fmt: skip
        assert f"a: was simulated with another {key}, {MOTION}" in run.refused(*draw.split(), "-o", "b", "--set", other)
    fine(run, f"{draw} -o c")
    fine(run, "render tiny.yaml -f 1-2 -q -o c --resume")  # the same frames, simulated
    for other in ("camera.position=[0,1,9]", "lights=[]", "material.colour=[.5,.1,.1]", "time.frames=99"):
        fine(run, f"{draw} -o {other[:6]} --set {other}")


def test_frames_are_not_resumed_from_positions_that_were_simulated_anew(run: Runner) -> None:
    simulated(run, "-f 1-4 -o a")
    fine(run, "render tiny.yaml --from-cache a -o b -f 1-2 -q")
    before = Path("a/positions_0002.npz").read_bytes()
    simulated(run, "--set gravity.acceleration=[9,9,0] -f 1-4 -o a --overwrite")
    refused(run, "render tiny.yaml --from-cache a -o b -f 1-4 --resume", "gravity.acceleration", MOTION)
    again = "render tiny.yaml --set gravity.acceleration=[9,9,0] --from-cache a -o b -f 1-4 --resume"
    refused(run, again, "frame_0001.png", OTHER)
    Path("a/positions_0002.npz").write_bytes(before)  # as a run leaves it that was broken off
    refused(run, again.replace("--resume", "--overwrite"), "positions_0002.npz: is of another motion than manifest")


def test_positions_of_another_version_are_drawn_but_not_mixed(run: Runner) -> None:
    simulated(run, "-f 1-2 -o a")
    fine(run, "render tiny.yaml --from-cache a -o b -f 1 -q")
    for frame in (1, 2):
        path = Path(f"a/positions_{frame:04d}.npz")
        path.write_bytes(path.read_bytes()[:-32] + b"0" * 32)
    manifest = json.loads(Path("a/manifest.json").read_text())
    manifest["motion"]["fingerprint"] = "0" * 32
    Path("a/manifest.json").write_text(json.dumps(manifest))
    refused(run, "render tiny.yaml --from-cache a -o b -f 1-2 --resume", "frame_0001.png", OTHER, "; empty b, add")
    fine(run, "render tiny.yaml --from-cache a -o c -f 1 -q")
    fine(run, "render tiny.yaml --from-cache a -o c -f 1-2 -q --resume")


def test_frames_of_a_loop_of_another_period_are_not_resumed(run: Runner) -> None:
    fine(run, "render loop.yaml -o a -f 1-2 -q")
    refused(run, "render loop.yaml --set time.frames=24 -o a -f 1-3 --resume", "frame_0001.png", OTHER)
    assert run(*["simulate", "loop.yaml", "-f", "1-2", "-o", "p", "-q"]).code == 0
    refused(run, "render loop.yaml --set time.frames=24 --from-cache p -o b -f 1", "time.period", MOTION)


def test_a_longer_film_is_resumed(run: Runner) -> None:
    fine(run, "render tiny.yaml -o a -f 1-2 -q")
    assert "2 kept" in fine(run, "render tiny.yaml --set time.frames=40 -o a -f 1-3 --resume")
    fine(run, "render tiny.yaml -o b -f 3 -q")
    np.testing.assert_array_equal(pixels("a", 3), pixels("b", 3))


def test_layers_of_another_camera_are_not_resumed(run: Runner) -> None:
    with_layers, moved = "--set image.aovs=[depth,mask]", "--set camera.position=[0,0,3]"
    fine(run, f"render tiny.yaml {with_layers} -o a -f 1 -q")
    assert "1 kept" in fine(run, f"render tiny.yaml {with_layers} -o a -f 1 --resume")
    fine(run, f"render tiny.yaml {moved} -o a -f 1 --overwrite -q")
    refused(run, f"render tiny.yaml {moved} {with_layers} -o a -f 1 --resume", "depth_0001.npz", OTHER)
    fine(run, f"render tiny.yaml {moved} --set image.aovs=[depth] -o a -f 1 --overwrite -q")
    refused(run, f"render tiny.yaml {moved} {with_layers} -o a -f 1 --resume", "mask_0001.npz", OTHER)
    Path("a/mask_0001.npz").unlink()
    Path("a/mask_0001.png").unlink()
    fine(run, f"render tiny.yaml {moved} {with_layers} -o a -f 1 --resume -q")
    fine(run, f"render tiny.yaml {moved} {with_layers} -o b -f 1 -q")
    for name in ("depth", "mask"):
        for suffix in (".npz", ".png"):
            assert Path(f"a/{name}_0001{suffix}").read_bytes() == Path(f"b/{name}_0001{suffix}").read_bytes()
    fine(run, f"render tiny.yaml {with_layers} -o c -f 1 -q")
    Path("c/mask_0001.png").replace("a/mask_0001.png")
    refused(run, f"render tiny.yaml {moved} {with_layers} -o a -f 1 --resume", "mask_0001.png", OTHER)
