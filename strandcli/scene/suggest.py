"""Where a setting that was written at the top of a preset belongs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from .faults import hint, near, shown
from .fields import settings_of
from .model import Scene
from .rule_type import RuleType
from .specs import ModelSpec, UnionSpec

MOST_PATHS = 3
"""Paths that a message suggests at the most."""


def hint_inside(key: str, known: Iterable[str], rules: Mapping[str, RuleType]) -> str:
    """The end of a message about a key that is none of ``known`` at the top: the paths of the settings with this name,
    else what was probably meant, else all ``known`` keys."""
    names = list(known)
    paths = settings_by_name(rules)
    found = key if key in paths else None if near(key, names) else near(key, paths)
    if found is None:
        return hint(key, names, "the keys are")
    level = paths[found][0].count(".")  # they come level by level; deeper ones are meant less often
    nearest = [path for path in paths[found] if path.count(".") == level]
    return f"did you mean {' or '.join(shown(path) for path in nearest[:MOST_PATHS])}?"


def settings_by_name(rules: Mapping[str, RuleType]) -> dict[str, list[str]]:
    """Dotted paths of all settings below the top that are not in lists, by their last part, level by level."""
    paths: dict[str, list[str]] = {}
    for path in _paths(rules):
        paths.setdefault(path.rpartition(".")[2], []).append(path)
    return paths


def _paths(rules: Mapping[str, RuleType]) -> Iterator[str]:
    """Dotted paths of all settings below the top that are not in lists."""
    waiting = [(key, setting.spec) for key, setting in settings_of(Scene).items()]
    while waiting:
        path, spec = waiting.pop(0)
        if isinstance(spec, ModelSpec):
            models = [spec.model]
        elif isinstance(spec, UnionSpec):
            models = list(spec.kinds.values())
        else:
            continue
        inner = {f"{path}.{key}": setting.spec for model in models for key, setting in settings_of(model).items()}
        yield from inner
        waiting += inner.items()
    for name, rule in rules.items():
        yield from (f"{name}.{key}" for key in settings_of(rule.Parameters))
