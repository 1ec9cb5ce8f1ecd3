"""Whatever is fed in, nothing but a SceneError or a UsageError comes out, each line of it readable."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import yaml
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from scene_kit import RULES, Breeze, error_of
from strandcli.errors import UsageError
from strandcli.scene import Scene, SceneError, dump, library, load, loads
from strandcli.scene.fields import settings_of
from strandcli.scene.model import Camera, Emitter
from strandcli.scene.yaml_source import read

thorough = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much]
)

CLASSES: tuple[type, ...] = (Scene, Camera, Emitter, Breeze)
KEYS = [*(key for cls in CLASSES for key in settings_of(cls)), *RULES, "extends", "set"]
TRAPS = ["null", "~", "no", "12:30", "1e3", ".nan", "010", "#fff"]
words = st.sampled_from([*KEYS, *TRAPS, "kind", "name", "box", "sphere"])
scalars = words | st.integers() | st.floats() | st.booleans() | st.none() | st.text(max_size=6)
trees = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(words, inner, max_size=5),
    max_leaves=25,
)
scene_like = st.dictionaries(st.sampled_from(KEYS), trees, max_size=6)
paths = st.lists(st.sampled_from([*KEYS, "0", "1", "wind[2]", "-1", "", "kind"]), min_size=1, max_size=4).map(".".join)
overridden = st.lists(st.tuples(paths, st.text(max_size=8) | words), max_size=3)

LINE_ENDS = "\n\r\x85\u2028\u2029"


def readable(error: SceneError, text: str) -> None:
    """Each fault is one printable line that names a place inside the text."""
    lines = sum(text.count(end) for end in LINE_ENDS) + 2
    assert error.faults
    for fault in error.faults:
        assert str(fault).isprintable()
        assert str(fault).startswith(f"p.yaml:{fault.line}:{fault.column}: ")
        assert 1 <= fault.line <= lines
        assert fault.column >= 1


def survives(text: str) -> None:
    """Loading gives a scene that can be written back, or faults that read well."""
    error = error_of(lambda: loads(text, rules=RULES, name="p.yaml"))
    if error is None:
        got = loads(text, rules=RULES)
        assert loads(dump(got), rules=RULES) == got
    else:
        assert isinstance(error, SceneError)
        readable(error, text)


@thorough
@given(st.text(max_size=200) | st.text("{}[]:,-?&*!|>'\"%@`#~ \n\tab01.", max_size=60))
@example("\ud800")
@example("title: \ufeff")
def test_any_text(text: str) -> None:
    survives(text)


@thorough
@given(st.binary(max_size=200))
def test_any_bytes(data: bytes) -> None:
    error = error_of(lambda: read(data, "p.yaml"))
    assert error is None or all(line.isprintable() for line in str(error).split("\n"))


@thorough
@given(scene_like)
def test_any_tree_with_the_words_of_a_preset(tree: dict[str, Any]) -> None:
    survives(yaml.safe_dump(tree, allow_unicode=True))


@thorough
@given(scene_like, overridden, st.dictionaries(paths, trees, max_size=2))
def test_any_overrides_and_settings(
    tree: dict[str, Any], overrides: list[tuple[str, str]], extra: dict[str, Any]
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "p.yaml"
        path.write_text(yaml.safe_dump(tree))
        texts = [f"{where}={value}" for where, value in overrides]
        error = error_of(lambda: load(path, rules=RULES, overrides=texts, settings=extra))
        assert error is None or all(line.isprintable() for line in str(error).split("\n"))


@thorough
@given(st.text(max_size=30))
def test_any_name(name: str) -> None:
    error = error_of(lambda: load(name, rules=RULES))
    assert all(line.isprintable() for line in str(error).split("\n"))
    if name not in dict(library.list_presets()):  # a preset that is there may use rules that these are not
        assert isinstance(error, UsageError)
