"""A validated scene back to plain data and to YAML that loads to an equal scene."""

from __future__ import annotations

import dataclasses
from typing import Any

from .checks import grown
from .fields import settings_of
from .model import RuleUse, Scene


def plain(value: Any) -> Any:
    """A setting's value as None, bool, int, float, str, lists and dicts with the keys of a preset."""
    if isinstance(value, RuleUse):
        return {value.name: plain(value.parameters)}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {key: plain(getattr(value, setting.attribute)) for key, setting in settings_of(type(value)).items()}
    if isinstance(value, tuple):
        return [plain(item) for item in value]
    return value


def to_dict(scene: Scene) -> dict[str, Any]:
    """``scene`` with every setting written out. A panel holds only the top-level settings in which it differs,
    or all where its quality does."""
    base = _alone(scene)
    if scene.panels:
        base["panels"] = []
    for panel in scene.panels:
        own = _alone(panel)
        label = own.pop("label")
        # another quality would change what is the same: then everything is written beside it
        whole = own["quality"] != base["quality"]
        changes = {key: value for key, value in own.items() if whole or value != base[key]}
        base["panels"].append({"label": label, "set": changes})
    return base


def _alone(scene: Scene) -> dict[str, Any]:
    """A scene without its panels; null for what it has of its file of strands."""
    found: dict[str, Any] = plain(dataclasses.replace(scene, panels=()))
    del found["panels"]
    if scene.emitter.groom is not None:
        for key in grown(scene):
            found["emitter"][key] = None
    return found


def dump(scene: Scene) -> str:
    """``scene`` as the text of a preset that stands by itself, without ``extends``."""
    import yaml

    class Dumper(yaml.SafeDumper):
        def ignore_aliases(self, data: Any) -> bool:
            return True

        def represent_str(self, data: str) -> Any:
            # in other styles PyYAML writes some line ends, such as U+0085, as what is read back as a space
            return self.represent_scalar("tag:yaml.org,2002:str", data, style=None if data.isprintable() else '"')

    Dumper.add_representer(str, Dumper.represent_str)
    # short lists such as vectors stay on one line
    return yaml.dump(to_dict(scene), Dumper=Dumper, sort_keys=False, allow_unicode=True, default_flow_style=None)
