"""Pictures of solids that are meshes, against those of the closed forms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import mesh_kit
from strand_kit import frames_of, scene_of

R = 0.5
SCENE = """
emitter: {strands: 40, particles: 6, length: 0.5, position: [0, %s, 0], shape: {kind: sphere, radius: 0.5, cap: 60}}
rules: []
camera: {position: [0.4, 0.8, 3], target: [0, -0.1, 0], fov: 35}
image: {size: [%d, %d], background: [0.2, 0.3, 0.5], aovs: [linear], resolver: %s, supersample: %d}
ambient: [0.3, 0.3, 0.3]
ambient_occlusion: %s
lights: [{kind: directional, direction: [-0.6, -1, -0.5], intensity: 2, size: %s}]
solids: [%s, {kind: plane, position: [0, -0.5, 0], colour: [0.5, 0.5, 0.5]}]
"""
SPHERE = f"{{kind: sphere, radius: {R}, colour: [0.6, 0.4, 0.3], coat: 0.04, mottle: 0.2}}"


def mesh(path: Path, **more: Any) -> str:
    settings = {"colour": "[0.6, 0.4, 0.3]", "coat": 0.04, "mottle": 0.2, **more}
    return f"{{kind: mesh, file: {path}, {', '.join(f'{key}: {value}' for key, value in settings.items())}}}"


def light(
    *solids: str, size: tuple[int, int] = (96, 80), occlusion: str = "{}", wide: float = 3.0, samples: int = 1,
    resolver: str = "zbuffer", hair: float = 9.0,
) -> np.ndarray:  # fmt: skip
    """What a scene that has every kind of light shows: all tests share its kernels. Strands at a height of 9 are out of
    sight."""
    scene = scene_of(SCENE % (hair, *size, resolver, samples, occlusion, wide, ", ".join(solids)))
    return np.asarray(frames_of(scene, 1)[0].aovs["linear"], float)


@pytest.fixture(scope="session")
def balls(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    folder = tmp_path_factory.mktemp("balls")
    return {n: mesh_kit.write(folder / f"ball_{n}.obj", *mesh_kit.ball(n, R)) for n in (3, 5)}


@pytest.mark.parametrize("more", [
    {"resolver": "sorted"},
    *(pytest.param(more, marks=pytest.mark.long)
      for more in ({"hair": 0.0}, {"occlusion": "null", "hair": 0.0, "wide": 0.0}, {"occlusion": "null", "wide": 6.0})),
], ids=str)  # fmt: skip
def test_a_ball_looks_like_the_sphere(balls: dict[int, Path], more: dict[str, Any]) -> None:
    """With strands on it, a soft shadow, ambient occlusion, antialiased edges; the finer, the closer."""
    exact = light(SPHERE, **more)
    found = {n: np.abs(light(mesh(path), **more) - exact).max(2) for n, path in balls.items()}
    assert exact.std() > 0.05
    assert found[5].mean() < 3e-3
    assert found[5].mean() < 0.6 * found[3].mean()
    assert np.percentile(found[5], 98) < 0.03


FOLDED = """
emitter: {strands: 1, length: 0.01, shape: {kind: sphere, radius: 0.01}}
rules: []
solids: [{kind: mesh, file: %s, colour: [1, 1, 1]}]
camera: {position: [0, 0, 4]%s}
ambient: [0, 0, 0]
lights: [{kind: directional, direction: [-0.3, 0, -1], intensity: 3, shadow: {model: "off"}}]
image: {size: [%d, %d], resolver: %s, background: [0, 0, 0], aovs: [linear]}
"""


@pytest.mark.parametrize("view", ["", ", kind: orthographic, height: 2"])
def test_edges_within_its_outline_are_antialiased(tmp_path: Path, view: str) -> None:
    """Two balls in one mesh, against eight by eight samples: the dim limb of the near ball before the lit one, which
    rays reach that graze the near one."""
    vertices, triangles = mesh_kit.ball(5, 1.0)
    both = np.concatenate([0.5 * vertices + (-0.3, 0, 0.8), 0.6 * vertices + (0.3, 0, -0.8)])
    path = mesh_kit.write(tmp_path / "two.obj", both, np.concatenate([triangles, triangles + len(vertices)]))

    def seen(width: int, height: int, resolver: str) -> np.ndarray:
        scene = scene_of(FOLDED % (path, view, width, height, resolver))
        return np.asarray(frames_of(scene, 1)[0].aovs["linear"], float)[..., 0]

    exact = seen(768, 512, "zbuffer").reshape(64, 8, 96, 8).mean((1, 3))
    off = np.abs(seen(96, 64, "sorted") - exact)
    steep = np.abs(exact[:, 2:] - exact[:, :-2]) > 0.2
    assert steep.sum() > 100
    assert off.max() < 0.1


def test_vertex_colours_and_textures_are_drawn(tmp_path: Path) -> None:
    """Each octant in its own colour: by vertices, and by a texture over (x, y)."""
    vertices, triangles = mesh_kit.ball(4, R)
    middles = vertices[triangles].mean(1)
    corners = vertices[triangles].reshape(-1, 3)
    shades = np.repeat((middles > 0) * 0.8 + 0.1, 3, 0)
    split = np.arange(len(corners)).reshape(-1, 3)
    plain = light(mesh(mesh_kit.write(tmp_path / "a.obj", vertices, triangles), mottle=0, coat=0, colour="[1, 1, 1]"))
    coloured = light(
        mesh(mesh_kit.write(tmp_path / "b.obj", corners, split, colours=shades), mottle=0, coat=0, colour_from="file")
    )
    face = plain[40, 40:56].mean(0) > 0
    assert face.all()
    share = coloured[30:50, 38:58] / plain[30:50, 38:58]
    assert 0 < share.min() < share.max() < 1
    assert np.ptp(share[:, :, 0]) > 0.5  # left and right
    image = np.zeros((64, 64, 3), np.uint8)
    image[:, 32:, 0] = 255
    image[:32, :, 1] = 255
    Image.fromarray(image).save(tmp_path / "map.png")
    uv = vertices[:, :2] / (2.2 * R) + 0.5
    textured = light(
        mesh(
            mesh_kit.write(tmp_path / "c.obj", vertices, triangles, uv=uv), mottle=0, coat=0, colour_from="file",
            texture=tmp_path / "map.png",
        )
    )  # fmt: skip
    share = textured / np.maximum(plain, 1e-6)
    middle = share[22:48, 33:63]
    assert middle[:5, -3:, 0].min() > 0.95  # red to the right, green above, as the origin of uv is below
    assert middle[:5, :3, 0].max() < 0.05
    assert middle[:3, :3, 1].min() > 0.95
    assert middle[-3:, -3:, 1].max() < 0.05
    assert middle[:, :, 2].max() < 0.05


def test_a_fine_texture_does_not_alias(tmp_path: Path) -> None:
    """A chequer far finer than a pixel is drawn as its mean, whatever the pixels' phase."""
    vertices, triangles = mesh_kit.ball(4, R)
    image = np.zeros((1024, 1024, 3), np.uint8)
    image[(np.add.outer(np.arange(1024), np.arange(1024)) % 2) == 0] = 255
    Image.fromarray(image).save(tmp_path / "fine.png")
    uv = vertices[:, :2] / (2.2 * R) + 0.5
    path = mesh_kit.write(tmp_path / "d.obj", vertices, triangles, uv=uv)
    plain = light(mesh(path, mottle=0, coat=0, colour="[1, 1, 1]", colour_from="colour"))
    fine = light(mesh(path, mottle=0, coat=0, colour_from="file", texture=tmp_path / "fine.png"))
    share = fine[22:48, 33:63] / plain[22:48, 33:63]
    np.testing.assert_allclose(share, 0.5, atol=0.02)
