"""A scene written back loads to an equal scene."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from scene_kit import scene
from scene_strategies import single_scenes
from strandcli.scene import Scene, dump, to_dict
from strandcli.scene.fields import settings_of

slow = settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much]
)


@slow
@given(single_scenes(), st.lists(single_scenes(), max_size=3))
def test_so_do_panels_however_much_they_differ(made: Scene, panels: list[Scene]) -> None:
    whole = dataclasses.replace(made, panels=tuple(panels))
    assert scene(dump(whole)) == whole


@pytest.mark.parametrize("text", ["no", "12:30", "~", "a: b", "#x", '"', " ", "\u2028", "é😀", "a\n\nb\n", "\n"])
def test_text_that_yaml_would_take_for_something_else_and_of_several_lines(text: str) -> None:
    made = Scene(title=text)
    assert scene(dump(made)) == made


def test_every_setting_is_written_out() -> None:
    data = to_dict(Scene())
    assert list(data) == [key for key in settings_of(Scene) if key != "panels"]
    lens = ["aperture", "focus", "shutter", "samples"]
    view = ["kind", "position", "target", "up", "fov", "height", "axis_x", "axis_y", "near", "fit"]
    assert list(data["camera"]) == [*view, *lens, "keys", "file", "name"]
    shadow = {"model": "minmax", "size": None, "layers": 31, "texel": None, "bias": 0.0, "parameters": None}
    assert data["lights"][0]["shadow"] == shadow


def test_a_panel_is_written_by_what_differs() -> None:
    made = scene("detail: {near: 3}\npanels: [{label: a, set: {detail: null}}, {label: b}]")
    assert to_dict(made)["panels"] == [{"label": "a", "set": {"detail": None}}, {"label": "b", "set": {}}]
