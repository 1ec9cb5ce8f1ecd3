"""Arrays and states that are kept from one run to the next: the same bits, and what is something else is made again."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import strandcli
from mesh_kit import sphere
from strand_kit import require_alike
from strandcli import load
from strandcli.compiling import folder
from strandcli.compiling.clock import clock
from strandcli.groom import family
from strandcli.groom.children import Children
from strandcli.groom.emit import emit
from strandcli.jit import array_cache as keeping
from strandcli.jit.array_cache import FREE, cached_arrays
from strandcli.mesh_file import prepared
from strandcli.meshes.bvh import make_bvh, make_distance_grid
from strandcli.meshes.make import make_mesh
from strandcli.run import checkpoints
from strandcli.run.checkpoints import Checkpoints
from strandcli.run.frame import Frame
from strandcli.run.pipeline import render
from strandcli.scene import Scene
from tests.run.test_checkpoints import SMALL, counted_steps

LIKE = {FREE + "many": np.empty(0, np.float32), "few": np.empty((2, 2))}
CODE = ("strandcli.jit.array_cache",)


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder; kernels stay in the cache's. However short a simulation, its state is kept."""
    new = folder.Folder()
    new.use(tmp_path / "cache")
    new.path.mkdir(mode=0o700)
    monkeypatch.setattr(keeping, "folder", SimpleNamespace(cache=new))
    monkeypatch.setattr(checkpoints, "LEAST", 0)
    return new.path


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    lines: list[str] = []
    monkeypatch.setattr(clock, "notify", lines.append)
    return lines


def refuse(*given: Any) -> Any:
    raise AssertionError("made again")


def numbers(value: float = 1.0) -> Iterable[NDArray[Any]]:
    return np.full((3, 4), value, np.float32), np.eye(2) * value


def get(make: Callable[[], Iterable[NDArray[Any]]] = numbers, of: Any = "this") -> list[NDArray[Any]]:
    return cached_arrays("some", CODE, (of, np.arange(3)), LIKE, make)


def test_what_was_made_is_read_and_follows_what_it_is_made_of(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = get()
    assert first[0].shape == (12,)
    (path,) = place.iterdir()
    assert path.stat().st_mode & 0o777 == 0o600
    for one, other in zip(first, get(refuse), strict=True):
        np.testing.assert_array_equal(one, other)
        assert (one.dtype, one.shape) == (other.dtype, other.shape)
    assert get(lambda: numbers(2.0), of="that")[1][0, 0] == 2
    monkeypatch.setattr(keeping, "_machine", lambda: ["another"])
    assert get(lambda: numbers(3.0))[1][0, 0] == 3
    with pytest.raises(TypeError):
        get(of=object())


def damage(path: Path, how: str, other: Path) -> None:
    content = bytearray(path.read_bytes())
    if how == "a bit":
        content[-40] ^= 4
    elif how == "short":
        del content[-5:]
    elif how == "empty":
        content.clear()
    elif how == "swapped":
        content[:] = other.read_bytes()
    elif how == "a long head":
        content[:] = content.replace(b"[12]", b"[99999999999]", 1)
    if how == "a folder":
        path.unlink()
        path.mkdir()
    elif how == "a link":
        path.rename(path.with_suffix(".moved"))
        path.symlink_to(path.with_suffix(".moved"))
    else:
        path.write_bytes(content)
    if how == "open to others":
        path.chmod(0o666)


@pytest.mark.parametrize(
    "how", ["a bit", "short", "empty", "swapped", "a long head", "a folder", "a link", "open to others"]
)
def test_what_is_not_what_was_written_is_made_again(place: Path, told: list[str], how: str) -> None:
    get()
    (path,) = place.iterdir()
    get(lambda: numbers(7.0), of="other")
    (other,) = {*place.iterdir()} - {path}
    damage(path, how, other)
    assert get(lambda: numbers(5.0))[1][0, 0] == 5
    assert len(told) == 1
    assert str(path) in told[0]
    assert "\n" not in told[0]
    assert get(refuse)[1][0, 0] == 5


def test_nothing_is_kept_where_nothing_can_be_nor_what_is_large(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(keeping.folder.cache, "_trouble", "a disk that is full")
    assert get()[0].shape == (12,)
    assert get(lambda: numbers(2.0))[1][0, 0] == 2
    assert not list(place.iterdir())
    monkeypatch.setattr(keeping.folder.cache, "_trouble", None)
    monkeypatch.setattr(keeping, "LARGEST", 3 * 4 * 4 + 2 * 2 * 8 - 1)
    assert get()[0].shape == (12,)
    assert not list(place.iterdir())
    monkeypatch.setattr(keeping, "LARGEST", 3 * 4 * 4 + 2 * 2 * 8)
    get()
    assert len(list(place.iterdir())) == 1


def same(one: Any, other: Any) -> None:
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a, b)
        assert (np.asarray(a).dtype, np.shape(a)) == (np.asarray(b).dtype, np.shape(b))


def require_cached(
    patch: pytest.MonkeyPatch, get: Callable[[], Any], maker: tuple[Any, str], *others: Callable[[], Any]
) -> None:
    """Fail where what was made is not read with its bits and layout, and what follows from other inputs not made.
    ``maker``: module and name of the function that is to make it."""
    made = get()
    patch.setattr(*maker, refuse)
    same(get(), made)
    for one, other in zip(get(), made, strict=True):  # kernels are compiled for either order
        assert np.asarray(one).flags.c_contiguous == np.asarray(other).flags.c_contiguous
    for other in others:
        with pytest.raises(AssertionError, match="made again"):
            other()


def test_distances_have_the_bits_of_those_that_are_made(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = make_mesh(*sphere())
    bvh = make_bvh(mesh.vertices, mesh.triangles)
    same(prepared.distances_of(bvh, mesh.closed, 24), make_distance_grid(bvh, mesh.closed, 24))
    require_cached(
        monkeypatch, lambda: prepared.distances_of(bvh, mesh.closed, 24), (prepared, "make_distance_grid"),
        lambda: prepared.distances_of(bvh, mesh.closed, 25), lambda: prepared.distances_of(bvh, not mesh.closed, 24),
    )  # fmt: skip


def test_what_children_follow_has_the_bits_and_the_layout_of_what_is_made(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wave = {"radius": 0.001, "length": 0.02}

    def found(**more: Any) -> family.Family:
        settings = {"children.count": 4, "children.waves": [wave, {**wave, "share": 0.5}], **more}
        scene = load("brush", settings=settings)
        return Children(scene, emit(scene.emitter, scene.seed)).family

    computed: list[family.Family] = []
    make = family._made
    monkeypatch.setattr(family, "_made", lambda *given: computed.append(make(*given)) or computed[0])
    same(found(), computed[0])
    require_cached(
        monkeypatch, found, (family, "_made"), lambda: found(seed=1), lambda: found(**{"children.cut": 0.3}),
        lambda: found(**{"emitter.strands": 80}),
    )  # fmt: skip


def scene_of(name: str = "hair", **more: Any) -> Scene:
    return strandcli.load(name, settings={**SMALL, "time.preroll": 0.5, **more})


def run(scene: Scene, frames: list[int], checkpoints: Any = None, **more: Any) -> tuple[list[Frame], int]:
    """Frames, and how many steps were simulated."""
    with counted_steps() as steps:
        found = list(render(scene, frames, threads=1, keep_positions=True, checkpoints=checkpoints, **more))
    return found, steps.count


@pytest.mark.parametrize("name", ["hair", "solvers"])
def test_a_later_run_has_the_bits_of_the_first(name: str) -> None:
    scene = scene_of(name)
    plain, whole = run(scene, [1, 3])
    first, simulated = run(scene, [1, 3], Checkpoints(None))
    assert simulated == whole
    later, fewer = run(scene, [1, 3], Checkpoints(None))
    assert fewer < whole
    assert run(scene, [1], Checkpoints(None))[1] == 0
    for found in first, later:
        require_alike(plain, found)


def test_only_what_moves_strands_begins_anew(place: Path) -> None:
    told: list[str] = []
    steps = []
    changes: list[dict[str, Any]] = [
        {}, {"lights.0.intensity": 1.0}, {"camera.fov": 30.0}, {"wind.strength": 5.0}, {"time.preroll": 0.6},
        {"emitter.strands": 71},
    ]  # fmt: skip
    for more in changes:
        scene = scene_of(**more)
        found, simulated = run(scene, [1], Checkpoints(None, notify=told.append))
        assert found[0].report.get("went_on_from") == (None if simulated else 1)
        steps.append(simulated > 0)
        np.testing.assert_array_equal(found[0].image, run(scene, [1])[0][0].image)
    assert steps == [True, False, False, True, True, True]
    assert told.count("frame 1 as an earlier run left it") == 2
    assert len(list(place.glob("first-frame-*.arrays"))) == 4


def test_a_scene_without_preroll_and_a_short_one_leave_nothing(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run(scene_of(**{"time.preroll": 0}), [1, 2], Checkpoints(None))
    monkeypatch.setattr(checkpoints, "LEAST", 1e9)
    run(scene_of(), [1], Checkpoints(None))
    assert list(place.glob("first-frame-*")) == []


def test_checkpoints_of_the_run_go_before(tmp_path: Path) -> None:
    scene = scene_of()
    plain, whole = run(scene, [3], Checkpoints(tmp_path, 2))
    again, simulated = run(scene, [3], Checkpoints(tmp_path, 2))
    assert 0 < simulated == scene.time.substeps < whole
    assert again[0].report["went_on_from"] == 2
    require_alike(plain, again)
