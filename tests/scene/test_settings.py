"""Settings from Python, and the hash of a preset with all that changes it."""

from __future__ import annotations

from pathlib import Path

import pytest

from scene_kit import RULES, fails, make_library, write
from strandcli.scene import load
from strandcli.scene.model import Detail


@pytest.fixture(autouse=True)
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """`make_library`."""
    return make_library(tmp_path, monkeypatch)


def test_settings_take_ready_values() -> None:
    settings = {
        "image.size": (320, 200),
        "emitter.strands": 12,
        "camera.position": [1, 2, 3.5],
        "title": "1e3",
        "detail": {"near": 2},
        "emitter.direction": None,
        "curves.mode": "off",
        "solids": [{"kind": "box", "visible": False}],
    }
    got = load("hair", rules=RULES, settings=settings)
    assert (got.image.size, got.emitter.strands, got.camera.position) == ((320, 200), 12, (1.0, 2.0, 3.5))
    assert (got.title, got.detail, got.solids[0].visible) == ("1e3", Detail(near=2.0), False)


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        ("image.size", (0, 3), "image.size: must be a size"),
        pytest.param("emitter.strands", 10**5000, "emitter.strands: must be a whole number", id="huge"),
        ("emitter.length", float("nan"), "emitter.length: must be a number above 0 (m), not '.nan'; it must be finite"),
        ("emitter.length", float("-inf"), "not '-.inf'; it must be finite"),
        ("emitter.length", True, "not 'true'"),
        ("emitter.length", "3", "not the text '3'"),
        ("emitter.lenght", 3, "emitter.lenght: unknown key; did you mean 'length'?"),
        ("seed", object(), "seed: a setting cannot be a object"),
    ],
)
def test_settings_that_are_refused(path: str, value: object, says: str) -> None:
    message = fails("hair", **{path: value})
    assert says in message
    assert message.startswith(path)
    assert len(message.splitlines()) == 1


def test_the_hash_tells_scenes_apart() -> None:
    write("base.yaml", "seed: 1\n")
    write("p.yaml", "extends: base.yaml\n")

    def sha(*overrides: str, **settings: object) -> str:
        return load("p.yaml", rules=RULES, overrides=overrides, settings=settings).sha256

    first = sha()
    assert len(first) == 64
    assert first == sha()
    found = {first, sha("seed=2"), sha("seed=3"), sha("seed=2", "seed=3"), sha(title="a"), sha(title="b")}
    # where one override ends and the next begins makes a difference
    assert sha("title=aseed=2") != sha("title=a", "seed=2")
    write("base.yaml", "seed: 1 # changed\n")
    found.add(sha())
    write("p.yaml", "extends: base.yaml\n\n")
    found.add(sha())
    assert len(found) == 8
