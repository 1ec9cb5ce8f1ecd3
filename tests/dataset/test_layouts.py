"""Labels in each layout: straight strands at known angles have the values that the layouts' own documents say."""

from __future__ import annotations

import json
import math
import pickle
from pathlib import Path

import numpy as np
import pytest

import dataset_kit as kit
from strandcli.cameras.pinhole import Pinhole, from_dict
from strandcli.dataset import layout as orientation
from strandcli.dataset.layout import directions
from strandcli.dataset.studio import Studio

WIDE = {"material.width": 0.12, "material.taper": 0}
SLANTS = pytest.mark.parametrize("slant", [0, 30, 135])


@SLANTS
def test_strand_map_of_hairstep(slant: float, tmp_path: Path) -> None:
    """Green grows downward, blue to the viewer's left: hair that falls is (255, 255, 127)."""
    path = kit.straight(tmp_path / "one.data", [kit.slanted(slant)])
    kit.run(kit.order(path, tmp_path / "set", "hairstep", scene=WIDE))
    found = kit.picture(tmp_path / "set" / "strand_map" / "0000.png")
    hair = kit.picture(tmp_path / "set" / "seg" / "0000.png")
    assert hair.shape == (64, 64)  # one channel
    assert set(np.unique(hair)) == {0, 255}
    x, y = math.sin(math.radians(slant)), math.cos(math.radians(slant))
    colour = np.array([255, 255 * (0.5 + 0.5 * y), 255 * (0.5 - 0.5 * x)])
    there = found[hair == 255].astype(int)
    assert len(there) > 100
    assert np.abs(there - colour).max() <= 1.001
    assert not found[hair == 0].any()
    if slant == 0:
        assert there[0].tolist() == [255, 255, 127]
    body = kit.picture(tmp_path / "set" / "body_img" / "0000.png")
    assert body.shape == (64, 64, 3)
    assert (body[..., 0] == hair).all()  # without solids, the hair is all there is


@SLANTS
@pytest.mark.parametrize(
    ("layout", "angles", "variances"),
    [
        ("gaussianhaircut", "orientations/angles", "orientations/vars"),
        ("neuralhaircut", "orientation_maps", "confidence_maps"),
    ],
)
def test_angles_and_variances_of_the_haircuts(
    slant: float, layout: str, angles: str, variances: str, tmp_path: Path
) -> None:
    """Degrees from upright, and to the right as they go down."""
    path = kit.straight(tmp_path / "one.data", [kit.slanted(slant)])
    kit.run(kit.order(path, tmp_path, layout, scene=WIDE))
    found, spread = kit.picture(tmp_path / angles / "0000.png"), np.load(tmp_path / variances / "0000.npy")
    hair = kit.picture(tmp_path / ("masks/hair" if layout == "gaussianhaircut" else "hair_mask") / "0000.png") > 127
    assert found.dtype == np.uint8
    assert found.shape == spread.shape == (64, 64)
    assert hair.sum() > 100
    assert found.max() < 180
    assert kit.apart(found[hair], slant).max() <= 1  # perspective: a strand through the middle keeps its angle
    assert spread.dtype == np.float16
    assert np.abs(spread[hair] - orientation.LEAST).max() < 1e-3
    assert np.abs(spread[~hair] - orientation.UNKNOWN).max() < 1e-3


def test_depths_are_in_order_and_masks_are_what_is_covered(tmp_path: Path) -> None:
    """A strand in front of another: nearer is larger for HairStep, less for nerfstudio, in metres times 1000."""
    far, near = kit.slanted(90, depth=-0.3), kit.slanted(0, depth=0.2)
    path = kit.straight(tmp_path / "two.data", [far, near])
    kit.run(kit.order(path, tmp_path / "hs", "hairstep", scene=WIDE))
    depth = np.load(tmp_path / "hs" / "depth_map" / "0000.npy")
    colours = kit.picture(tmp_path / "hs" / "strand_map" / "0000.png")
    down, right = (colours[..., 1] == 255), (colours[..., 2] == 0) & (colours[..., 0] == 255)
    assert depth.dtype == np.float32
    assert down.sum() > 100
    assert right.sum() > 100
    assert down[32, 32]  # where they cross, the front one is seen
    # a strand is round: what is seen of it is nearer than its axis by its radius at the most
    assert depth[down].min() > 0.85 > 0.15 > depth[right].max()
    assert depth.max() == 1
    assert depth[right].min() == 0
    kit.run(kit.order(path, tmp_path / "ns", "nerfstudio", scene=WIDE))
    metres = np.load(tmp_path / "ns" / "depths" / "0000.npy") / 1000
    view = from_dict(kit.manifest(tmp_path / "ns")["views"][0]["camera"])
    hair = kit.picture(tmp_path / "ns" / "masks" / "hair" / "0000.png") > 127
    (front,) = view.camera_points([[0.0, 0, 0.2]])[:, 2]
    assert front - 0.0601 < metres[32, 32] < front + 0.001
    assert (metres[:8, :8] == 0).all()
    assert metres[hair].min() > 0
    assert metres[hair].max() < view.camera_points([[0.0, 0, -0.3]])[0, 2] + 0.001


def test_hair_is_where_strands_cover_more_than_half(tmp_path: Path) -> None:
    path = kit.straight(tmp_path / "some.data", [kit.slanted(one) for one in range(0, 180, 20)])
    order = kit.order(path, tmp_path, "nerfstudio", scene={"material.width": 0.02})
    from strandcli.cameras.pinhole import of_camera
    from strandcli.dataset.views import camera_of

    studio = Studio(order.scene, 1, None, None)
    camera = camera_of(order.chance, 0, order.scene.camera, studio.points, (64, 64))
    view = of_camera(camera, "a", 64, 64)
    labels, drawing = studio.draw(order.scene, view)
    assert (labels.hair == (drawing.aovs["mask"] > 0.5)).all()
    assert 0.01 < labels.hair.mean() < 0.9
    turned = np.hypot(labels.direction[..., 0], labels.direction[..., 1])
    assert np.abs(turned[labels.hair] - 1).max() < 1e-5
    assert not turned[~labels.hair].any()


def test_solids_are_body_behind_hair_too(tmp_path: Path) -> None:
    path = kit.straight(tmp_path / "one.data", [kit.slanted(0, depth=0.5)])
    ball = {"kind": "sphere", "radius": 0.3}
    kit.run(kit.order(path, tmp_path, "hairstep", scene={**WIDE, "solids": [ball], "camera.fit": None}))
    colours = kit.picture(tmp_path / "strand_map" / "0000.png")
    hair, body = (kit.picture(tmp_path / name / "0000.png") > 127 for name in ("seg", "body_img"))
    body = body[..., 0]
    assert (body & hair == hair).all()
    assert (colours[..., 0] == np.where(hair, 255, np.where(body, 127, 0))).all()
    assert not colours[body & ~hair][:, 1:].any()
    view = from_dict(kit.manifest(tmp_path)["views"][0]["camera"])
    radius = 0.3 * view.focal
    rows, columns = np.nonzero(body & ~hair)
    (middle,) = view.project([[0.0, 0, 0]])
    away = np.hypot(columns + 0.5 - middle[0], rows + 0.5 - middle[1])
    assert away.max() < radius + 1
    assert body.sum() > 0.9 * math.pi * radius**2


def test_camera_of_hairstep_projects_as_its_scripts_do(tmp_path: Path) -> None:
    """The formulas of its `load_calib`, written out again."""
    path = kit.straight(tmp_path / "one.data", [([0.1, 0.4, 0], [-0.2, -0.4, 0.3]), ([0.3, 0.2, 0], [0.3, -0.3, 0])])
    kit.run(kit.order(path, tmp_path, "hairstep", azimuth=(-180, 180), elevation=(-30, 30), scene=WIDE))
    view = from_dict(kit.manifest(tmp_path)["views"][0]["camera"])
    given = np.load(tmp_path / "param" / "0000.npy", allow_pickle=True).item()
    points = np.random.default_rng(1).uniform(-0.4, 0.4, (40, 3))
    here = given["R"] @ points.T - given["R"] @ given["center"]
    here = here * given["scale"] / given["ortho_ratio"] / 512 * np.array([[1], [-1], [1]])
    assert np.abs(32 + 32 * here[:2].T - view.project(points)).max() < 1e-6
    assert np.linalg.det(given["R"]) == pytest.approx(1)
    nearer = view.camera_points(points)[:, 2].argsort()
    assert (np.diff(here[2][nearer]) < 0).all()  # the third axis points to the camera
    assert np.abs(here[2]).max() < 1.5


def test_files_of_all_views_together(tmp_path: Path) -> None:
    path = kit.straight(tmp_path / "some.data", [kit.slanted(one, depth=one / 400) for one in range(0, 180, 15)])
    around = {"azimuth": (-180, 180), "elevation": (-20, 40), "scene": WIDE}
    for layout in ("gaussianhaircut", "neuralhaircut", "nerfstudio"):
        kit.run(kit.order(path, tmp_path / layout, layout, range(3), **around))
    folder = tmp_path / "gaussianhaircut"
    assert (folder / "images_2" / "0001.png").read_bytes() == (folder / "images" / "0001.png").read_bytes()
    assert (folder / "masks_2" / "hair" / "0002.png").exists()
    lines = (folder / "sparse" / "0" / "points3D.txt").read_text().splitlines()[3:]
    points = np.array([[float(one) for one in line.split()[1:4]] for line in lines])
    assert len(points) > 50
    assert np.abs(points).max() < 0.6
    # the camera that its script takes from the fourth line, of eight words
    assert len((folder / "sparse" / "0" / "cameras.txt").read_text().splitlines()[3].split(" ")) == 8
    folder = tmp_path / "neuralhaircut"
    with open(folder / "scale.pickle", "rb") as file:
        ball = pickle.load(file)
    inside = (points - np.array(ball["translation"])) / ball["scale"]
    assert np.linalg.norm(inside, axis=1).max() == pytest.approx(1.1, rel=1e-4)
    arrays = np.load(folder / "cameras.npz")
    assert arrays["arr_0"].shape == (3, 4, 4)
    assert np.allclose(arrays["scale_mat_2"] @ [*inside[7], 1], [*points[7], 1])
    data = json.loads((tmp_path / "nerfstudio" / "transforms.json").read_text())
    for frame in data["frames"]:
        for key in ("file_path", "depth_file_path", "mask_path", "body_mask_path"):
            assert (tmp_path / "nerfstudio" / frame[key]).is_file()
        up = np.array(frame["transform_matrix"])[:3, 1]
        assert up[2] > 0.5  # the camera's up is that of a world whose z is up


@pytest.mark.parametrize("perspective", [True, False])
def test_directions_are_those_of_steps_along_the_strand(perspective: bool) -> None:
    rng = np.random.default_rng(3)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation = axes * np.sign(np.linalg.det(axes))
    view = Pinhole("a", 64, 48, 30.0, (20.0, 30.0), rotation, rng.normal(size=3), perspective)
    rows, columns = rng.integers(0, 48, 300), rng.integers(0, 64, 300)
    tangents = rng.normal(size=(300, 3))
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    flat = (np.stack([columns, rows], 1) + 0.5 - view.centre) / view.focal
    here = np.column_stack([2 * flat if perspective else flat, np.full(300, 2.0)]) @ rotation + view.eye
    assert np.abs(view.project(here) - np.stack([columns, rows], 1) - 0.5).max() < 1e-9
    step = view.project(here + 1e-6 * tangents) - view.project(here - 1e-6 * tangents)
    step /= np.linalg.norm(step, axis=1)[:, None]
    found = directions(tangents.astype(np.float32), rows, columns, view)
    assert np.median(np.abs(found - step).max(1)) < 1e-5
    assert np.abs(found - step).max() < 1e-2  # where strands are seen all but end on
    end_on = directions(rotation[2:].astype(np.float32), np.array([29]), np.array([19]), view)
    assert np.isfinite(end_on).all()
