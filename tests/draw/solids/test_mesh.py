"""Solids in pictures: meshes against closed forms, edges under sorted strands against pictures of very many samples."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import mesh_kit
from strand_kit import frames_of, scene_of
from strandcli.draw.canvas import Canvas
from strandcli.draw.common.kernels.keys import EMPTY
from strandcli.draw.lighting.lighting import NO_SPOTS, Lighting
from strandcli.draw.transmittance import draw_solids

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


# no strand is near the camera, or one as wide as a board, alone: all edge_light comes from everywhere
EDGE = """
emitter: {strands: 1, particles: 2, length: 4, direction: [0, 1, 0], position: %s,
  shape: {kind: disc, radius: 0.000001}}
rules: []
camera: {kind: %s, position: [0.1, 0.6, 5], target: [0, 0, 0], fov: 30, height: 2.6}
image: {size: [64, 48], background: [0.9, 0.1, 0.1], aovs: [linear], resolver: %s, supersample: %d}
ambient: [1, 1, 1]
curves: {mode: "off"}
material: {width: 0.5, taper: 0, colour: [0.1, 0.9, 0.2], specular: 0, diffuse: 0}
lights: []
solids: %s
"""
BALL = "{kind: sphere, radius: 0.5, position: [0.25, 0, 0], colour: [0.2, 0.2, 0.9]}"
ROD = "{kind: capsule, radius: 0.2, length: 2, position: [-0.2, 0.2, 0], rotation: [20, 0, 35], colour: [0.9, 0.9, 0]}"
BOX = "{kind: box, size: [0.8, 0.5, 0.6], position: [-0.3, -0.3, 0.2], rotation: [20, 30, 10], colour: [0.9, 0.9, 0.1]}"
GROUND = "{kind: plane, position: [0, -0.8, 0], rotation: [0, 0, 8], colour: [0.3, 0.7, 0.3], fade: 0}"
AWAY, BEFORE, BETWEEN, BEHIND = ("[0, 90, 0]", "[0.05, -2, 1.5]", "[0.05, -2, -0.7]", "[0.05, -2, -1.5]")
KINDS = pytest.mark.parametrize("kind", ["perspective", "orthographic"])


def edge_light(strand: str, kind: str, resolver: str, samples: int, *solids: str) -> np.ndarray:
    """(48, 64, 3) linear edge_light."""
    scene = scene_of(EDGE % (strand, kind, resolver, samples, f"[{', '.join(solids)}]"))
    return np.asarray(frames_of(scene, 1)[0].aovs["linear"], float)


@KINDS
@pytest.mark.parametrize("solids", [[BALL], [BOX], [BALL, ROD, BOX, GROUND]])
def test_edges_of_solids_are_what_samples_show(kind: str, solids: list[str]) -> None:
    """All pixels are within what 4×4 samples can be off by; where the edge goes through, one sample is far off."""
    exact = edge_light(AWAY, kind, "zbuffer", 8, *solids)
    got = edge_light(AWAY, kind, "sorted", 1, *solids)
    hard = edge_light(AWAY, kind, "zbuffer", 1, *solids)
    if solids != [GROUND] or kind == "perspective":  # else there is no horizon
        assert (np.abs(hard - exact).max(2) > 0.15).sum() > 20
    assert np.abs(got - exact).max() < 0.8 / 8 + 1e-5  # the greatest contrast, of two colours a sample in eight apart
    assert np.sqrt(np.mean((got - exact) ** 2)) <= 0.2 * np.sqrt(np.mean((hard - exact) ** 2)) + 1e-6
    inside = np.abs(hard - exact).max(2) < 1e-6
    np.testing.assert_allclose(got[inside], exact[inside], atol=1e-5)


@KINDS
@pytest.mark.parametrize("strand", [BEFORE, BETWEEN, BEHIND])
def test_strands_go_before_between_and_behind_the_edges_of_solids(kind: str, strand: str) -> None:
    """A board of a strand, a ball before a wall: at the ball's edge the wall shows, or the board where it is nearer."""
    wall = "{kind: box, size: [9, 9, 0.1], position: [0, 0, -1.1], colour: [0.5, 0.5, 0.5]}"
    exact = edge_light(strand, kind, "zbuffer", 8, BALL, wall)
    got = edge_light(strand, kind, "sorted", 1, BALL, wall)
    error = np.abs(got - exact).max(2)
    # where the edges of both cross a pixel each may lie anywhere in it
    assert (error > 0.1).sum() <= 4
    assert error.max() < 0.35
    assert np.sqrt(np.mean(error**2)) < 0.02


@KINDS
def test_edges_at_the_border_are_those_of_a_wider_picture(kind: str) -> None:
    """A crop window through a ball has the edge_light of the whole picture up to its border."""
    text = EDGE % (AWAY, kind, "sorted", 1, f"[{BALL}, {GROUND}]")
    whole = frames_of(scene_of(text), 1)[0].aovs["linear"]
    for x in range(20, 36):
        scene = scene_of(text.replace("image: {", f"image: {{crop: [{x}, {x - 6}, 11, 14], "))
        part = frames_of(scene, 1)[0].aovs["linear"]
        np.testing.assert_allclose(part, whole[x - 6 : x + 8, x : x + 11], atol=1e-5)


def test_solids_behind_closed_strands_are_not_shaded_and_no_pixel_differs(monkeypatch: pytest.MonkeyPatch) -> None:
    """In bands, with haze and edges of solids before, between and behind an opaque board."""
    left: list[np.ndarray] = []
    beside: list[int] = []
    shade = Lighting.shade_surfaces

    def note(self: Lighting, keys: Any, image: Any, spots: Any = NO_SPOTS, *rest: Any) -> None:
        before = image.copy()
        shade(self, keys, image, spots, *rest)
        if not len(spots):
            left.append((image != before).any(2))
        else:
            beside.append(np.count_nonzero(keys != EMPTY))

    def all_of_them(self: Canvas, layer: Any, edges: Any) -> None:
        rows = layer.fragments.top, layer.fragments.bottom
        draw = partial(draw_solids, self.lighting)
        draw(self.keys, self.image, rows=rows)
        edges.within(rows[0] * self.size[0], rows[1] * self.size[0]).composite(draw, self.image, self.backdrop)

    monkeypatch.setattr("strandcli.draw.coverage.coverage.Coverage._cuts", lambda self, *rows: [(0, 21), (21, 48)])
    monkeypatch.setattr(Lighting, "shade_surfaces", note)
    text = EDGE % (BETWEEN, "perspective", "sorted", 1, f"[{BALL}, {ROD}, {GROUND}]")
    scene = scene_of(text.replace("image: {", "image: {haze: 20, "))
    spared = np.asarray(frames_of(scene, 1)[0].aovs["linear"])
    shaded, shaded_beside = np.any(left, 0), sum(beside)
    left.clear()
    beside.clear()
    monkeypatch.setattr(Canvas, "_behind", all_of_them)
    whole = np.asarray(frames_of(scene, 1)[0].aovs["linear"])
    assert np.any(left, 0).sum() > shaded.sum() + 100
    assert sum(beside) > shaded_beside + 10
    np.testing.assert_array_equal(spared, whole)


def test_a_picture_of_one_pixel_and_a_ball_about_the_camera_have_edges_or_none() -> None:
    around = "{kind: sphere, radius: 9, position: [0, 0, 0]}"
    for solid in (BALL, around):
        for kind in ("perspective", "orthographic"):
            text = EDGE % (BETWEEN, kind, "sorted", 1, f"[{solid}]")
            frame = frames_of(scene_of(text.replace("[64, 48]", "[1, 1]")), 1)[0]
            assert np.isfinite(frame.aovs["linear"]).all()
