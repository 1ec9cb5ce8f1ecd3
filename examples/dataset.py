#!/usr/bin/env python3
"""A labelled data set of random hair styles, views and lights, for those who train on synthetic hair.

    python examples/dataset.py --count 4 -o out/dataset

Each sample is a folder: `frame_0001.png`, layers as .npz with PNGs to look at (depth, mask, tangent, orientation,
strand id; `strandcli/draw/film/aovs.py` tells what they hold), `scene.yaml`, which draws the same picture again, and
`camera.json`. `dataset.json` lists the samples. Sample i depends on --seed and i alone, so a set can be made in parts
(--first), on any number of threads.

Cameras follow OpenCV: a point X of the world, in metres, is seen at K (R X + t) / depth, x to the right and y down,
pixel centres at .5. `strand_id` numbers the strands that are drawn, of which the first are simulated and guide the
others; with `depth` it tells which strand a point of space lies on.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import strandcli
from strandcli.draw.view.camera import View, camera_view
from strandcli.errors import StrandError
from strandcli.output.files import prepare_folder, write_json, write_pieces
from strandcli.output.layers import write_layers
from strandcli.output.png import encode
from strandcli.scene.dump import dump
from strandcli.scene.model import Scene

LAYERS = ("depth", "mask", "tangent", "orientation", "strand_id")
PIGMENTS = ("black", "dark_brown", "brown", "light_brown", "auburn", "red", "dark_blond", "blond", "platinum")
PALE = ("blond", "platinum")
"""Burn out in light that brown hair wants; so does grey."""
GUIDES = 20
"""Strands that are drawn for each that is simulated."""
WIDTH, USUAL = 0.00026, 20_000
"""Metres, of so many strands; fewer are wider, more are thinner."""
ENDS = ((-0.21, -0.43, -0.03), (0.21, -0.43, -0.03), (0.0, -0.43, 0.069), (0.0, -0.43, -0.12))
"""Metres; where arms, chest and back of the bust have begun to round off below."""


def random_scene(seed: int, index: int, size: tuple[int, int], strands: int) -> Scene:
    """The bust of the preset `hair` with hair of a random cut, parting, curl, colour and stiffness, from a random side,
    in random light that shows it."""
    rng = np.random.default_rng([seed, index])

    def between(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    length = math.exp(between(math.log(0.06), math.log(0.5)))
    azimuth, height = math.radians(between(-180, 180)), math.radians(between(-15, 18))
    away = between(0.9, 1.4)
    target = [between(-0.03, 0.03), between(-0.05, 0.0) - 0.15 * length, between(-0.03, 0.03)]
    eye = [
        target[0] + away * math.cos(height) * math.sin(azimuth),
        target[1] + away * math.sin(height),
        target[2] + away * math.cos(height) * math.cos(azimuth),
    ]
    pigment, grey = str(rng.choice(PIGMENTS)), max(between(-0.5, 0.5), 0.0)
    lights = random_lights(azimuth, 1 - (0.45 if pigment in PALE else 0.5 * grey), between)
    tone = between(0.06, 0.55)
    settings: dict[str, Any] = {
        "title": f"sample {index} of the data set with seed {seed}",
        "seed": int(rng.integers(2**31)),
        "time.frames": 1,
        "emitter.keys": [],
        "emitter.strands": -(-strands // GUIDES),
        "emitter.length": length,
        "emitter.length_variation": between(0.0, 0.3),
        "emitter.comb": [between(0.2, 1.0), between(-0.6, 0.2), between(-1.0, 0.4)],
        "emitter.parting": between(-0.05, 0.05) if rng.random() < 0.6 else None,
        "emitter.lift": between(8, 35),
        "emitter.jitter": between(4, 20),
        "children": {
            "count": GUIDES,
            "cut": between(0.05, 0.5),
            "clumps": [
                {"size": between(0.015, 0.03), "strength": between(0.2, 0.7), "shape": between(0.8, 2)},
                {"size": between(0.004, 0.009), "strength": between(0.3, 0.9)},
            ],
            "waves": [
                _wave(str(rng.choice(["straight", "waves", "curls"])), between),
                {"radius": between(0.0004, 0.0015), "length": 0.05, "round": 1, "disorder": 1},
            ],
        },
        "rod.radius": between(1.2e-4, 3e-4),
        "wind.strength": between(0, 1.5),
        "wind.direction": [between(-1, 1), between(-0.2, 0.3), between(-1, 1)],
        "solids.head.colour": [tone, 0.68 * tone, 0.54 * tone],
        "camera": {"position": eye, "target": target, "fov": min(between(22, 32) + 16 * length, widest(eye, target))},
        "image.size": list(size),
        "image.background": [between(0.02, 0.45) for _ in range(3)],
        "image.horizon": None,
        "image.exposure": between(-0.3, 0.3),
        "image.tone": str(rng.choice(["srgb", "filmic"])),
        "image.aovs": list(LAYERS),
        "ambient": [between(0.12, 0.3) * tint for tint in (between(0.9, 1.0), 1.0, between(0.95, 1.15))],
        "lights": lights,
        "material.pigment": pigment,
        "material.grey": grey,
        "material.colour_variation": between(0.1, 0.4),
        "material.beta_m": between(0.15, 0.35),
        "material.width": min(WIDTH * USUAL / max(strands, 1), 0.001),
    }
    return strandcli.load("hair", settings=settings)


def widest(eye: list[float], target: list[float]) -> float:
    """The vertical angle of view in degrees at which a camera begins to see where the bust ends below."""
    way = np.subtract(target, eye) / math.dist(target, eye)
    up = np.array([0.0, 1.0, 0.0]) - way[1] * way
    ends = np.subtract(ENDS, eye)
    tangents = -(ends @ up) / math.hypot(*up) / (ends @ way)
    return 2 * math.degrees(math.atan(float(tangents.min())))


def random_lights(azimuth: float, power: float, between: Callable[[float, float], float]) -> list[dict[str, Any]]:
    """Three lights about a camera that looks from ``azimuth``, in radians, as a photographer sets them up.

    The key light comes from the camera's side, within 65 degrees of it, so that what is seen is lit; a weaker and
    larger fill comes from its other hand, so that no shadow is black; a light from behind draws an outline, in some
    pictures next to none. ``power`` scales all of them.
    """
    hand = 1.0 if between(-1, 1) > 0 else -1.0
    key = power * between(3.2, 5.5)
    parts = (
        (hand * between(10, 65), between(-1.1, -0.25), key, between(3, 15)),
        (-hand * between(20, 80), between(-0.6, 0.1), key * between(0.2, 0.5), between(15, 40)),
        (-hand * between(120, 200), between(-0.8, -0.15), key * between(0.05, 0.5), between(3, 15)),
    )
    lights = []
    for turn, down, intensity, size in parts:
        around = azimuth + math.radians(turn)
        lights.append({
            "kind": "directional",
            "direction": [-math.sin(around), down, -math.cos(around)],
            "intensity": intensity,
            "size": size,
            "colour": [1.0, between(0.88, 1.0), between(0.75, 1.0)],
            "shadow": {"model": "opacity"},
        })  # fmt: skip
    return lights


def _wave(style: str, between: Callable[[float, float], float]) -> dict[str, float]:
    """How the strands of a lock wind together."""
    if style == "curls":
        return {"radius": between(0.006, 0.012), "length": between(0.03, 0.07), "round": 1, "onset": between(0.1, 0.4)}
    if style == "waves":
        return {"radius": between(0.004, 0.01), "length": between(0.09, 0.18), "round": between(0.3, 0.8), "onset": 0.5}
    return {"radius": between(0.0, 0.002), "length": between(0.1, 0.2)}


def matrices(view: View) -> dict[str, Any]:
    """Intrinsics K (3, 3) in pixels and extrinsics R (3, 3), t (3,) in metres, as OpenCV has them."""
    cx, cy = view.middle
    rotation = np.stack([view.right, -view.up, view.forward])
    return {
        "width": int(view.width),
        "height": int(view.height),
        "K": [[view.focal, 0.0, cx], [0.0, view.focal, cy], [0.0, 0.0, 1.0]],
        "R": rotation.tolist(),
        "t": (-rotation @ view.eye).tolist(),
    }


def write_sample(folder: Path, scene: Scene, index: int, seed: int, threads: int | None) -> dict[str, Any]:
    """Draw one sample into its folder; returns its entry of the list."""
    (frame,) = strandcli.render(scene, threads=threads)
    assert frame.image is not None
    assert frame.positions is not None
    name = f"{index:05d}"
    pixels = frame.image.shape[0] * frame.image.shape[1]
    prepare_folder(folder / name, 40 * pixels)
    write_pieces(folder / name / "scene.yaml", [dump(scene).encode()])
    bounds = np.stack([frame.positions.min((0, 1)), frame.positions.max((0, 1))]).astype(float)
    view = camera_view(scene.camera, 0.0, *scene.image.size, bounds)
    seeds = {"set": seed, "index": index, "scene": scene.seed}
    write_json(folder / name / "camera.json", {"convention": "opencv", "seeds": seeds, **matrices(view)})
    write_layers(folder / name, 1, frame.aovs)
    write_pieces(folder / name / "frame_0001.png", encode(frame.image))
    share = float(np.mean(frame.aovs["mask"]))
    return {"name": name, "seeds": seeds, "strands": scene.drawn_strands, "hair_share": round(share, 6)}


def main(arguments: list[str] | None = None) -> int:
    """Parse, make, list; returns the exit code."""
    parser = argparse.ArgumentParser(description="Write a labelled data set of random hair.")
    parser.add_argument("--count", type=int, default=4, help="number of samples")
    parser.add_argument("--first", type=int, default=0, help="number of the first sample, to make a set in parts")
    parser.add_argument("--seed", type=int, default=0, help="seed of the whole set")
    parser.add_argument("--size", type=int, nargs=2, default=(512, 512), metavar=("W", "H"), help="pixels")
    parser.add_argument("--strands", type=int, default=12_000, help="strands of each head, about")
    parser.add_argument("--threads", type=int, help="threads (default: all cores)")
    parser.add_argument("-o", "--output", type=Path, default=Path("out/dataset"), metavar="DIR", help="folder")
    given = parser.parse_args(arguments)
    if given.count < 1 or given.first < 0 or given.seed < 0:
        parser.error("--count is at least 1, --first and --seed are not negative")
    try:
        entries = []
        for index in range(given.first, given.first + given.count):
            scene = random_scene(given.seed, index, tuple(given.size), given.strands)
            entries.append(write_sample(given.output, scene, index, given.seed, given.threads))
            print(f"{given.output / entries[-1]['name']}: hair on {entries[-1]['hair_share']:.1%} of the picture")
        listed = given.output / "dataset.json"
        if listed.exists():  # parts made before stay listed
            old = json.loads(listed.read_text())["samples"]
            entries += [entry for entry in old if entry["name"] not in {new["name"] for new in entries}]
        entries.sort(key=lambda entry: entry["name"])
        write_json(listed, {"strandcli": strandcli.__version__, "layers": list(LAYERS), "samples": entries})
    except StrandError as error:
        print(f"dataset.py: {error}", file=sys.stderr)
        return error.exit_code
    except (OSError, ValueError, KeyError, TypeError) as error:
        print(f"dataset.py: {given.output / 'dataset.json'}: cannot be read: {error!r}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
