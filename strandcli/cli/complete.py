"""What a shell offers for the word that is being typed: presets and files, keys of presets and their values.

Imports neither numpy nor numba: a shell waits for it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import CompletionItem

if TYPE_CHECKING:
    from ..scene.fields import Setting
    from ..scene.model import Scene

PRESETS = (".yaml", ".yml")


def presets(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Shipped presets, and files and folders that begin with what is typed."""
    return [*shipped(ctx, param, incomplete), *map(CompletionItem, files(incomplete))]


def shipped(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Shipped presets."""
    from ..scene.library import describe, list_presets

    return [CompletionItem(name, help=describe(path)) for name, path in list_presets() if name.startswith(incomplete)]


def clusters(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """What stands for a Dask cluster: workers of this machine, or how schedulers' addresses begin."""
    known = {"local": "workers of this machine, for this run", "tcp://": "a scheduler's address"}
    return [CompletionItem(word, help=words) for word, words in known.items() if word.startswith(incomplete)]


def files(incomplete: str) -> list[str]:
    """Paths of files that can be drawn, and of folders with a slash at their end."""
    folder, begin = os.path.split(incomplete)
    try:
        with os.scandir(os.path.expanduser(folder) or ".") as entries:
            found = [(one.name, one.is_dir()) for one in entries]
    except OSError:
        return []
    from ..exchange.formats import suffixes

    ends = (*PRESETS, *suffixes())
    shown = sorted(one for one in found if one[0].startswith(begin) and (begin or not one[0].startswith(".")))
    return [
        os.path.join(folder, name) + ("/" if is_folder else "")
        for name, is_folder in shown
        if is_folder or name.lower().endswith(ends)
    ]


def keys(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Dotted paths of settings, a part at a time, and after = the values of those that have few."""
    path, given, value = incomplete.partition("=")
    head, dot, begin = path.rpartition(".")
    found = dict(_inside(_scene(), head.split(".") if head else []))
    if not given:
        return [CompletionItem(f"{head}{dot}{key}", help=words) for key, (words, _) in found.items()
                if key.startswith(begin)]  # fmt: skip
    values = found.get(f"{begin}=", ("", ()))[1]
    return [CompletionItem(f"{path}={one}") for one in values if one.startswith(value)]


typed: list[str] = []
"""The words before the one that is completed: click drops what stands before an option that waits for its value."""


def _scene() -> Scene:
    """The preset that the command line names; one of defaults with all rules where there is none that can be read."""
    import strandcli

    from ..scene import RuleUse
    from ..scene.model import Scene
    from ..simulate.rules import registry

    for word in typed[1:]:
        if word and not word.startswith("-") and "=" not in word:
            try:
                return strandcli.load(word)
            except Exception:  # a shell's completion is silent; it may be the value of an option
                continue
    return Scene(rules=tuple(RuleUse(name, rule.Parameters(), name) for name, rule in registry().items()))


def _inside(scene: Scene, parts: list[str]) -> Iterator[tuple[str, tuple[str, tuple[str, ...]]]]:
    """What may follow a path, with `.` or `=` at its end: what each means, and its values where they are few."""
    from ..scene.fields import made, settings_of
    from ..scene.rule_type import first_paragraph

    rules = {use.path: use.parameters for use in scene.rules}
    node: Any = scene
    for depth, part in enumerate(parts):
        if isinstance(node, tuple):
            named = [one for one in node if getattr(one, "name", None) == part]
            node = next(iter(named or node[int(part) :][:1] if part.isdecimal() or named else ()), None)
        elif depth == 0 and part in rules:
            node = rules[part]
        else:
            node = getattr(node, part, None) or (None if node is None else made(node, part))
    if isinstance(node, tuple):
        for one in (*(one.name for one in node if getattr(one, "name", "")), *range(len(node))):
            yield f"{one}.", ("", ())
        return
    kind: type = type(node)
    if not hasattr(kind, "__dataclass_fields__"):
        return
    for key, setting in settings_of(kind).items():
        if node is not scene or key != "panels":
            yield key + _end(setting), (_doc(setting.spec.doc), _values(setting))
    if node is scene:
        yield from ((f"{name}.", (_doc(first_paragraph(type(one).__doc__)), ())) for name, one in rules.items())


def _end(setting: Setting) -> str:
    """`.` after what has settings or entries of its own, `=` after a setting."""
    from ..scene import specs

    deeper = isinstance(setting.spec, specs.ModelSpec | specs.UnionSpec | specs.ItemsSpec | specs.RulesSpec)
    return "." if deeper else "="


def _values(setting: Setting) -> tuple[str, ...]:
    from ..scene import specs

    if isinstance(setting.spec, specs.BooleanSpec):
        return "true", "false"
    return setting.spec.options if isinstance(setting.spec, specs.ChoiceSpec) else ()


def _doc(words: str) -> str:
    """The first sentence of what a setting means."""
    return words.split(". ")[0].split(": ")[0].strip(".")


def listed(choices: Iterable[str], incomplete: str) -> list[CompletionItem]:
    """Words of a list with commas in between: the choices that are not there yet, after the last comma."""
    done, comma, begin = incomplete.rpartition(",")
    taken = done.split(",")
    return [CompletionItem(f"{done}{comma}{one}") for one in choices if one.startswith(begin) and one not in taken]
