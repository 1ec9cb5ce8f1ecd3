"""The same strands drawn by an independent path tracer, Mitsuba 3: `make check-against-mitsuba`. Direct light alone.

What is the same: strands, to them B-splines through fine polylines (of their `linearcurve` the BSDF of 3.9 does not get
the tangent, which shows as soon as a strand leaves the axes), of one width; camera; one directional light of a given
irradiance; index of refraction, absorption, roughness. What differs, and is part of the figures here:

- Mitsuba's `hair` is Chiang's model, evaluated at the offset h where a ray meets the strand; here light is averaged
  over the width, and with `material.model: marschner` the lobes are Gaussians in θ_h and the fourth is left out.
- Mitsuba traces shadows. Strands stand apart and the light is beside the eye or opposite, and maps are off.
- One ray a sample there, a grid of samples here: the noise of the path tracer, estimated from two renderings with
  different seeds, is taken off the squared difference.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

mi = pytest.importorskip("mitsuba", reason="Mitsuba is not installed: make check-against-mitsuba")

import strandcli  # noqa: E402
from strandcli.draw.curves import flatten  # noqa: E402
from strandcli.draw.marschner import azimuthal_beta  # noqa: E402
from strandcli.draw.scratch import Scratch  # noqa: E402
from strandcli.scene.fields import settings_of  # noqa: E402
from strandcli.scene.model import Material  # noqa: E402
from strandcli.study.axes import Request  # noqa: E402
from strandcli.study.pictures.subject import Subject, changed, silhouette  # noqa: E402

SIZE = (96, 72)
SPP = 2048
IRRADIANCE = 3.0
BETA_M, BETA_N = 0.3, 0.3
LIGHTS = {
    "from the eye": ((0, -0.2, -1), (0.27, 0.3)),
    "from behind": ((0.5, -0.3, 0.8), (0.03, 0.22)),
}
"""Where light travels to, and how far Gaussian lobes may be from Chiang's there: in brightness, and in RMSE. Facing the
eye there is little light, much of it in the fourth lobe and in the tails, which a Gaussian lacks."""
CHIANG = "model" in settings_of(Material) and "chiang" in settings_of(Material)["model"].spec.options
PRESET = """\
title: strands that stand apart
emitter: {shape: {kind: sphere, radius: 0.2}, strands: 60, particles: 9, length: 0.8, jitter: 20, curl_turns: 0.4}
camera: {position: [0, 0.3, 4], target: [0, 0, 0], fov: 34}
image: {size: [96, 72], supersample: 8, background: [0, 0, 0]}
ambient: [0, 0, 0]
lights: [{kind: directional, direction: [0, -0.2, -1], intensity: 3, shadow: {model: "off"}}]
material: {colour: [0.45, 0.25, 0.12], diffuse: 0, width: 0.005, taper: 0}
curves: {mode: fixed, level: 4}
"""


class Both(NamedTuple):
    """Pictures (height, width, 3) of one scene."""

    ours: Any
    theirs: Any
    """Mean of two seeds."""
    noise: float
    """Standard deviation of that mean, over all values."""


@pytest.fixture(scope="module")
def subject(tmp_path_factory: pytest.TempPathFactory) -> Subject:
    path = tmp_path_factory.mktemp("mitsuba") / "apart.yaml"
    path.write_text(PRESET)
    longitudinal = 0.726 * BETA_M + 0.812 * BETA_M**2 + 3.7 * BETA_M**20  # of R in θ_l + θ_v, twice that in θ_h
    settings: dict[str, Any] = {"material.alpha": 0.0, "material.beta": float(np.degrees(longitudinal) / 2)}
    settings["material.azimuthal"] = _degrees(BETA_N)
    if CHIANG:
        settings = {"material.model": "chiang", "material.tilt": 0.0}
        settings |= {"material.beta_m": BETA_M, "material.beta_n": BETA_N}
    # so many samples are more than a preset may ask for
    found = Subject(Request(strandcli.load(str(path), settings=settings), "apart", size=SIZE))
    found.scene = changed(found.scene, {"image.supersample": 16})
    found.move()
    return found


def _degrees(beta_n: float) -> float:
    return float(min(np.linspace(5, 40, 3501), key=lambda degrees: abs(azimuthal_beta(float(degrees)) - beta_n)))


def spline(points: Any) -> Any:
    """Control points (n + 2, 3) of a uniform cubic B-spline that begins and ends where a polyline (n, 3) does."""
    return np.concatenate([[2 * points[0] - points[1]], points, [2 * points[-1] - points[-2]]])


def traced(subject: Subject, direction: tuple[float, float, float], folder: Path, seed: int) -> tuple[Any, Any]:
    """Colour and coverage by the path tracer."""
    mi.set_variant("scalar_rgb")
    scene = subject.scene
    lines = flatten(subject.positions, subject.lengths, subject.groom.strands, scene.curves, subject.view(scene), True,
                    Scratch())  # fmt: skip
    strands = [spline(lines.world[a:b]) for a, b in zip(lines.first[:-1], lines.first[1:], strict=True)]
    radius = scene.material.width / 2
    text = "\n\n".join("\n".join(f"{x:.7g} {y:.7g} {z:.7g} {radius:.7g}" for x, y, z in one) for one in strands)
    (folder / "strands.txt").write_text(text + "\n")
    tables = import_module(f"strandcli.draw.{'chiang' if CHIANG else 'marschner'}").build_tables(scene.material)
    sigma = tables.absorption
    camera = scene.camera
    look = mi.ScalarTransform4f().look_at(list(camera.position), list(camera.target), list(camera.up))
    film = {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1], "pixel_format": "rgba",
            "component_format": "float32", "rfilter": {"type": "box"}}  # fmt: skip
    fibre = {"type": "hair", "longitudinal_roughness": BETA_M, "azimuthal_roughness": BETA_N, "scale_tilt": 0.0,
             "int_ior": scene.material.eta, "ext_ior": 1.0,
             "sigma_a": {"type": "rgb", "value": sigma.tolist()}}  # fmt: skip
    loaded = mi.load_dict({
        "type": "scene", "integrator": {"type": "path", "max_depth": 2},
        "sensor": {"type": "perspective", "fov": camera.fov, "fov_axis": "y", "to_world": look, "film": film,
                   "sampler": {"type": "independent", "sample_count": SPP}},
        "hair": {"type": "bsplinecurve", "filename": str(folder / "strands.txt"), "bsdf": fibre},
        "light": {"type": "directional", "direction": list(direction), "irradiance": IRRADIANCE},
    })  # fmt: skip
    image = np.array(mi.render(loaded, spp=SPP, seed=seed), np.float64)
    return image[..., :3], image[..., 3]


def both(subject: Subject, direction: tuple[float, float, float], folder: Path) -> Both:
    one, two = (traced(subject, direction, folder, seed)[0] for seed in (1, 2))
    ours = subject.draw(changed(subject.scene, {"lights.0.direction": direction}), draws=1).image
    return Both(ours, (one + two) / 2, float(np.sqrt(((one - two) ** 2).mean()) / 2))


def figures(found: Both) -> tuple[float, float, float]:
    """RMSE without the noise, mean brightness over theirs, and the noise. Most of the picture is empty, so that its
    mean says little: RMSE and noise are shares of their picture's own root mean square."""
    size = float(np.sqrt((found.theirs**2).mean() - found.noise**2))
    square = ((found.ours - found.theirs) ** 2).mean() - found.noise**2
    return (float(np.sqrt(max(square, 0.0))) / size, float(found.ours.mean() / found.theirs.mean()),
            found.noise / size)  # fmt: skip


def test_strands_cover_the_same_pixels(subject: Subject, tmp_path: Path) -> None:
    alpha = traced(subject, (0, -0.2, -1), tmp_path, 1)[1]
    white = subject.draw(silhouette(subject.scene), draws=1).image[..., 0]
    noise = float(np.sqrt((alpha * (1 - alpha)).mean() / SPP))
    rmse = float(np.sqrt(((white - alpha) ** 2).mean()))
    print(f"\narea {white.mean() / alpha.mean():.4f}, RMSE {rmse:.4f}, noise {noise:.4f}")
    assert white.mean() / alpha.mean() == pytest.approx(1, abs=0.02)
    assert rmse**2 - noise**2 < (0.02) ** 2


@pytest.mark.parametrize(("direction", "marschner"), LIGHTS.values(), ids=LIGHTS)
def test_strands_have_the_same_light(subject: Subject, tmp_path: Path, direction: Any, marschner: Any) -> None:
    found = both(subject, direction, tmp_path)
    rmse, brightness, noise = figures(found)
    print(f"\nRMSE {rmse:.4f} without a noise of {noise:.4f}, brightness {brightness:.4f}")
    off, apart = (0.02, 0.1) if CHIANG else marschner
    assert abs(brightness - 1) < off
    assert rmse < apart
