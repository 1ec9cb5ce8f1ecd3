"""Pictures by an independent path tracer, Mitsuba 3, of a subject's strands, camera, lights and material.

Strands are B-splines through fine polylines, from tip to root, which is how its `hair` (Chiang's model) takes the tilt
of the scales; of its `linearcurve` the model does not get the tangent (3.9), which shows as soon as a strand leaves the
axes. It works in a process of its own, that is begun anew where it dies: once in some ten million rays at curves as
thin as hair 3.9 does.

Its own shadow rays begin some way off the surface (see `SCALE`), and miss what is nearer. Direct light is therefore
traced by an integrator of our own, whose shadow rays begin a hundredth of a radius off the surface, where Mitsuba's
LLVM variant works, which is also its fastest: it wants LLVM 16 or later beside it (Debian: libllvm19). Elsewhere its
own integrator has to do, and `Traced.exact` is false.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from strandcli.exchange.strands import Strands
    from strandcli.study.pictures.subject import Subject
    from tests.reference.chiang import Hair

SCALE = 100
"""How many times larger the scene is for the path tracer. Its own shadow rays begin 9e-5 · (1 + the greatest
coordinate) off the surface: in metres they miss what is within three radii of a hair, so within a half, and within a
twentieth of a strand as wide as a pixel.
"""
PASS, RAYS = 128, 4_000_000
"""Samples a pixel between one save and the next at most, and rays that are followed at once."""
DEATHS = 40
SCALAR, LLVM = "scalar_rgb", "llvm_ad_rgb"


class Traced(NamedTuple):
    """Two independent pictures (height, width, 3) of one scene, linear, and what the path tracer took."""

    one: Any
    two: Any
    alpha: Any
    """(height, width), of both."""
    samples: int
    """A pixel, of each of the two."""
    seconds: float
    """A sample of every pixel."""
    exact: bool
    """Whether shadow rays begin next to the surface."""


class Figures(NamedTuple):
    """Of a picture against the path tracer's; RMSE and noise as shares of the mean where strands are."""

    rmse: float
    """Without the path tracer's noise,"""
    sure: float
    """and by how much that noise makes it uncertain, a standard deviation."""
    brightness: float
    noise: float
    """Of the mean of the two pictures."""

    def __str__(self) -> str:
        found = f"RMSE {self.rmse:.3f} ± {self.sure:.3f} without a noise of {self.noise:.3f}"
        return f"{found}, brightness {self.brightness:.3f}"


def figures(image: Any, traced: Traced) -> Figures:
    """What the difference of ``image`` has in common with both pictures is not their noise."""
    reference = (traced.one + traced.two) / 2
    lit = float(reference.mean() / traced.alpha.mean())
    covered = float(traced.alpha.mean())
    squares = ((image - traced.one) * (image - traced.two)).mean(2) / covered
    rmse, error = max(float(squares.mean()), 0.0) ** 0.5, float(squares.std()) / squares.size**0.5
    sure = error / max(2 * rmse, error**0.5)
    noise = float(((traced.one - traced.two) ** 2).mean()) / 4 / covered
    return Figures(rmse / lit, sure / lit, float(image.mean() / reference.mean()), noise**0.5 / lit)


def seconds_to(error: float, found: Figures, traced: Traced) -> float:
    """What the path tracer takes until its noise is ``error``; it falls with the root of the number of samples."""
    return traced.seconds * 2 * traced.samples * (found.noise / error) ** 2


def trace(subject: Subject, folder: Path, samples: int, depth: int = 2, strands: Strands | None = None) -> Traced:
    """Trace paths of up to ``depth`` pieces: 2 is direct light; ``strands``, with their widths, in place of the
    subject's."""
    _write(subject, folder, depth, strands)
    exact = depth == 2 and _process(folder, 1, 0, LLVM) == 0
    one, two = (_run(folder, samples, seed, LLVM if exact else SCALAR) for seed in (1, 2))
    alpha = (one[0][..., 3] + two[0][..., 3]) / 2
    return Traced(one[0][..., :3], two[0][..., :3], alpha, samples, (one[1] + two[1]) / (2 * samples), exact)


@cache
def _knots(n: int) -> Any:
    """The matrix that makes knots of n points."""
    sums = np.eye(n)
    for i in range(1, n - 1):
        sums[i, i - 1 : i + 2] = np.array([1, 4, 1]) / 6
    return np.linalg.inv(sums)


def spline(points: Any) -> Any:
    """Control points (n + 2, …) of the uniform cubic B-spline through points (n, …) that is straight at its ends:
    (c₋ + 4 c + c₊) / 6 at each point in between."""
    knots = _knots(len(points)) @ points
    return np.concatenate([[2 * knots[0] - knots[1]], knots, [2 * knots[-1] - knots[-2]]])


def one_strand(hair: Hair, eye: float, light: float, phi: float, folder: Path, samples: int = 512**2) -> float:
    """Mean radiance, over its width, of a straight strand in directional light of irradiance 1; θ of eye and light and
    φ between them in radians."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    radius, half = 0.0025, 0.003
    along = np.linspace(1, -1, 40)
    np.savetxt(folder / "one.txt", np.column_stack([along, 0 * along, 0 * along, 0 * along + radius]))
    way = [math.sin(light), math.cos(light) * math.sin(phi), math.cos(light) * math.cos(phi)]
    look = mi.ScalarTransform4f().look_at([3 * math.sin(eye), 0, 3 * math.cos(eye)], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": 1, "height": 1, "pixel_format": "rgba", "component_format": "float32",
            "rfilter": {"type": "box"}}  # fmt: skip
    fibre = {"type": "hair", "longitudinal_roughness": hair.beta_m, "azimuthal_roughness": hair.beta_n,
             "scale_tilt": hair.tilt, "int_ior": hair.eta, "ext_ior": 1.0,
             "sigma_a": {"type": "rgb", "value": [hair.sigma] * 3}}  # fmt: skip
    scene = {"type": "scene", "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0},
             "sensor": {"type": "orthographic", "to_world": look @ mi.ScalarTransform4f().scale([half, half, 1]),
                        "film": film, "sampler": {"type": "stratified"}},
             "hair": {"type": "bsplinecurve", "filename": str(folder / "one.txt"), "bsdf": fibre},
             "light": {"type": "directional", "direction": [-c for c in way],
                       "irradiance": {"type": "rgb", "value": 1.0}}}  # fmt: skip
    red, _, _, alpha = np.array(mi.render(mi.load_dict(scene), spp=samples, seed=1), np.float64)[0, 0]
    return float(red / alpha)


def _lines(subject: Subject) -> Iterator[Any]:
    """Of each strand of a subject its points and radii (n, 4), root to tip."""
    from strandcli.draw.common.scratch import Scratch
    from strandcli.draw.geometry.curves import flatten

    scene, material = subject.scene, subject.scene.material
    lines = flatten(subject.positions, subject.lengths, subject.groom.strands, scene.curves, subject.view(scene), True,
                    Scratch())  # fmt: skip
    for a, b in zip(lines.first[:-1], lines.first[1:], strict=True):
        radii = material.width / 2 * (1 - material.drawn_taper * np.linspace(0, 1, b - a))
        yield np.column_stack([lines.world[a:b], radii])


def _told(strands: Strands) -> Iterator[Any]:
    """The same of strands of a file."""
    radii = strands.attributes["width"].values / 2
    for a, b in zip(strands.first[:-1], strands.first[1:], strict=True):
        yield np.column_stack([strands.points[a:b], radii[a:b]])


def _write(subject: Subject, folder: Path, depth: int, strands: Strands | None) -> None:
    from strandcli.draw.fibre import chiang

    scene, material, camera = subject.scene, subject.scene.material, subject.scene.camera
    with open(folder / "strands.txt", "w") as file:
        for one in _lines(subject) if strands is None else _told(strands):
            knots = SCALE * spline(one)[::-1]
            file.write("\n".join(" ".join(f"{number:.8g}" for number in knot) for knot in knots) + "\n\n")
    tables = chiang.build_tables(material)
    (folder / "scene.json").write_text(json.dumps({
        "depth": depth, "radius": SCALE * material.width / 2, "size": scene.image.size, "fov": camera.fov,
        "up": camera.up,
        "position": [SCALE * x for x in camera.position], "target": [SCALE * x for x in camera.target],
        "sigma": tables.absorption.tolist(), "beta_m": material.beta_m, "beta_n": material.beta_n,
        "tilt": material.tilt, "eta": material.eta,
        "lights": [{"direction": light.direction, "power": [light.intensity * c for c in light.colour]}
                   for light in scene.lights],
    }))  # fmt: skip


def _run(folder: Path, samples: int, seed: int, variant: str) -> tuple[Any, float]:
    """Mean of so many samples, (height, width, 4), and seconds."""
    for _ in range(DEATHS):
        code = _process(folder, samples, seed, variant)
        if code == 0:
            break
        assert code < 0, "the path tracer failed"
    found = np.load(folder / f"sum_{seed}.npz")
    assert found["samples"] == samples, "the path tracer died too often"
    return found["total"] / samples, float(found["seconds"])


def _process(folder: Path, samples: int, seed: int, variant: str) -> int:
    command = [sys.executable, __file__, str(folder), str(samples), str(seed), variant]
    return subprocess.run(command, check=False, stderr=subprocess.DEVNULL if seed == 0 else None).returncode


def _direct(lights: list[dict[str, Any]], off: float) -> Any:
    """An integrator of directional light whose shadow rays begin so far off the surface, on the light's side of it:
    Mitsuba culls the back of curves, so that no strand is in the way of what passes through it."""
    import drjit as dr
    import mitsuba as mi

    class Direct(mi.SamplingIntegrator):  # type: ignore[misc]
        def sample(self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True) -> Any:
            found = scene.ray_intersect(ray, active)
            active &= found.is_valid()
            bsdf, light = found.bsdf(ray), mi.Color3f(0)
            for one in lights:
                way = np.array(one["direction"], float)
                toward = mi.Vector3f(*(-way / np.linalg.norm(way)).tolist())
                begin = found.p + off * dr.sign(dr.dot(found.n, toward)) * found.n
                free = active & ~scene.ray_test(mi.Ray3f(begin, toward), active)
                light += bsdf.eval(mi.BSDFContext(), found, found.to_local(toward), free) * mi.Color3f(*one["power"])
            return light, found.is_valid(), []

        def aov_names(self) -> list[str]:
            return []

        def to_string(self) -> str:
            return "Direct[]"

    return Direct(mi.Properties())


def _render(folder: Path, samples: int, seed: int, variant: str) -> None:
    """In the process of its own: go on from what is saved."""
    import mitsuba as mi

    mi.set_variant(variant)
    told = json.loads((folder / "scene.json").read_text())
    look = mi.ScalarTransform4f().look_at(told["position"], told["target"], told["up"])
    film = {"type": "hdrfilm", "width": told["size"][0], "height": told["size"][1], "pixel_format": "rgba",
            "component_format": "float32", "rfilter": {"type": "box"}}  # fmt: skip
    fibre = {"type": "hair", "longitudinal_roughness": told["beta_m"], "azimuthal_roughness": told["beta_n"],
             "scale_tilt": told["tilt"], "int_ior": told["eta"], "ext_ior": 1.0,
             "sigma_a": {"type": "rgb", "value": told["sigma"]}}  # fmt: skip
    # of direct light one ray to the lamp is all: the fastest that it can be asked for
    integrator: dict[str, Any] = {"type": "path", "max_depth": told["depth"], "rr_depth": 50}
    if told["depth"] == 2:
        integrator = {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0}
    scene = {"type": "scene", "integrator": integrator,
             "sensor": {"type": "perspective", "fov": told["fov"], "fov_axis": "y", "to_world": look, "film": film,
                        "sampler": {"type": "independent"}},
             "hair": {"type": "bsplinecurve", "filename": str(folder / "strands.txt"), "bsdf": fibre}}  # fmt: skip
    for number, light in enumerate(told["lights"]):
        scene[f"light_{number}"] = {"type": "directional", "direction": light["direction"],
                                    "irradiance": {"type": "rgb", "value": light["power"]}}  # fmt: skip
    loaded = mi.load_dict(scene)
    own = _direct(told["lights"], told["radius"] / 100) if variant == LLVM else None
    each = max(min(PASS, RAYS // math.prod(told["size"])), 1)
    saved, tried = folder / f"sum_{seed}.npz", folder / f"tried_{seed}"
    total, seconds, done = np.zeros((told["size"][1], told["size"][0], 4)), 0.0, 0
    if saved.exists():
        found = np.load(saved)
        total, seconds, done = found["total"], float(found["seconds"]), int(found["samples"])
    # a pass that killed it is not tried a second time
    number = int(tried.read_text()) + 1 if tried.exists() else 0
    while done < samples:
        tried.write_text(str(number))
        count = min(each, samples - done)
        began = time.perf_counter()
        picture = mi.render(loaded, integrator=own, spp=count, seed=1_000_003 * seed + number)
        total += count * np.array(picture, np.float64)
        seconds += time.perf_counter() - began
        done, number = done + count, number + 1
        np.savez(saved, total=total, seconds=seconds, samples=done)


if __name__ == "__main__":
    _render(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4])
