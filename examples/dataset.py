#!/usr/bin/env python3
"""A labelled data set of random hair styles, views and lights, for those who train on synthetic hair.

    python examples/dataset.py --count 4 -o out/dataset

Each sample is a folder: `frame_0001.png`, layers as .npz with PNGs to look at (depth, mask, tangent, orientation,
strand id; `strandcli/draw/aovs.py` tells what they hold), `scene.yaml`, which draws the same picture again, and
`camera.json`. `dataset.json` lists the samples. Sample i depends on --seed and i alone, so a set can be made in parts
(--first), on any number of threads.

Cameras follow OpenCV: a point X of the world, in metres, is seen at K (R X + t) / depth, x to the right and y down,
pixel centres at .5; strands of the picture are those of `strand_id`, as emitted by the scene's seed.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

import strandcli
from strandcli.draw.camera import View, camera_view
from strandcli.errors import StrandError
from strandcli.output.files import prepare_folder, write_json, write_pieces
from strandcli.output.layers import write_layers
from strandcli.output.png import encode
from strandcli.scene.dump import dump
from strandcli.scene.model import Scene

LAYERS = ("depth", "mask", "tangent", "orientation", "strand_id")
COLOURS = ("#1a120d", "#2e1c12", "#4a2f1d", "#6b4a2c", "#8a5a32", "#b08a55", "#7a2f16", "#8f8c88")


def random_scene(seed: int, index: int, size: tuple[int, int], strands: int) -> Scene:
    """A head with hair of a random cut, curl, colour and stiffness, from a random side, in random light."""
    rng = np.random.default_rng([seed, index])

    def between(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    length = float(np.exp(rng.uniform(math.log(0.06), math.log(0.5))))
    azimuth, height = math.radians(between(-180, 180)), math.radians(between(-15, 40))
    away = between(0.9, 1.4)
    target = [between(-0.03, 0.03), between(-0.12, 0.0), between(-0.03, 0.03)]
    eye = [
        target[0] + away * math.cos(height) * math.sin(azimuth),
        target[1] + away * math.sin(height),
        target[2] + away * math.cos(height) * math.cos(azimuth),
    ]
    lights: list[dict[str, Any]] = []
    for power in (between(1.5, 3.5), between(0.3, 2.0), between(0.0, 1.0)):
        turn, down = math.radians(between(0, 360)), between(-1.2, -0.1)
        lights.append({
            "kind": "directional",
            "direction": [math.sin(turn), down, math.cos(turn)],
            "intensity": power,
            "colour": [1.0, between(0.85, 1.0), between(0.7, 1.0)],
            "shadow": {"size": 512},
        })  # fmt: skip
    skin = {"follow": "emitter", "colour": [between(0.15, 0.5), 0.25, 0.2]}
    settings: dict[str, Any] = {
        "title": f"sample {index} of the data set with seed {seed}",
        "seed": int(rng.integers(2**31)),
        "time": {"frames": 1, "preroll": 2.0},
        "emitter": {
            "shape": {"kind": "sphere", "radius": 0.1, "cap": between(70, 105)},
            "strands": strands,
            "particles": 16,
            "length": length,
            "length_variation": between(0.0, 0.5),
            "direction": [between(-0.8, 0.8), 1.0, between(-1.0, 0.2)],
            "jitter": between(5, 40),
            "curl_turns": float(rng.choice([0.0, 0.0, between(1, 5)])),
            "curl_angle": between(10, 35),
            "rotation": [between(-25, -10), 0.0, 0.0],
        },
        "rules": [
            {"gravity": {}},
            {"wind": {"strength": between(0, 6), "direction": [between(-1, 1), 0.1, between(-1, 1)]}},
            {"stiffness": {"strength": between(8, 50)}},
            {"collision": {"segments": True}},
            {"elasticity": {}},
        ],
        "solids": [
            {"kind": "sphere", "name": "skull", "radius": 0.097, **skin},
            {"kind": "capsule", "name": "face", "radius": 0.065, "length": 0.085, "position": [0, -0.0532, 0.0147],
             "rotation": [16, 0, 0], **skin},
            {"kind": "capsule", "name": "neck", "radius": 0.045, "length": 0.19, "position": [0, -0.155, -0.022],
             "colour": skin["colour"]},
        ],
        "camera": {"position": eye, "target": target, "fov": between(20, 32)},
        "image": {
            "size": list(size),
            "supersample": 2,
            "background": [between(0, 0.6) for _ in range(3)],
            "exposure": between(-0.5, 0.5),
            "tone": str(rng.choice(["srgb", "filmic"])),
            "aovs": list(LAYERS),
        },
        "ambient": [between(0.05, 0.2)] * 3,
        "lights": lights,
        "material": {
            "colour": str(rng.choice(COLOURS)),
            "tip_colour": str(rng.choice(COLOURS)),
            "colour_variation": between(0, 0.5),
            "beta": between(5, 12),
        },
    }  # fmt: skip
    return strandcli.load("minimal", settings=settings)


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
    return {"name": name, "seeds": seeds, "strands": scene.emitter.strands, "hair_share": round(share, 6)}


def main(arguments: list[str] | None = None) -> int:
    """Parse, make, list; returns the exit code."""
    parser = argparse.ArgumentParser(description="Write a labelled data set of random hair.")
    parser.add_argument("--count", type=int, default=4, help="number of samples")
    parser.add_argument("--first", type=int, default=0, help="number of the first sample, to make a set in parts")
    parser.add_argument("--seed", type=int, default=0, help="seed of the whole set")
    parser.add_argument("--size", type=int, nargs=2, default=(512, 512), metavar=("W", "H"), help="pixels")
    parser.add_argument("--strands", type=int, default=12_000, help="strands of each head")
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
