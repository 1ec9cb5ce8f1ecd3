"""What a shell offers for the word that is being typed: presets and files, keys of presets and their values.

Imports neither numpy nor numba: a shell waits for it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import click
from click.shell_completion import CompletionItem

Json = Mapping[str, Any]

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
    from ..scene import json_schema
    from ..simulate.rules import registry

    tree = Tree(json_schema(registry()), _data())
    path, given, value = incomplete.partition("=")
    if given:
        return [CompletionItem(f"{path}={one}") for one in tree.values(path) if one.startswith(value)]
    head, dot, begin = path.rpartition(".")
    found = tree.inside(head) if head or not dot else {}
    return [CompletionItem(f"{head}{dot}{key}", help=words) for key, words in found.items() if key.startswith(begin)]


typed: list[str] = []
"""The words before the one that is completed: click drops what stands before an option that waits for its value."""


def _data() -> Json:
    """The settings of the preset that the command line names; nothing where there is none that can be read."""
    import strandcli
    from strandcli.scene import to_dict

    for word in typed[1:]:
        if word and not word.startswith("-") and "=" not in word:
            try:
                return to_dict(strandcli.load(word, roughly=True))
            except Exception:  # a shell's completion is silent; it may be the value of an option
                continue
    return {}


class Tree:
    """The schema of presets, with the values of one."""

    def __init__(self, schema: Json, data: Json) -> None:
        self._schema, self._data = schema, data
        uses = data.get("rules") or []
        self._rules = [name for use in uses if isinstance(use, dict) for name in use] or list(self._known_rules())

    def inside(self, path: str) -> dict[str, str]:
        """What may follow a path, each with `.` or `=` at its end, and what it means."""
        if not path:
            keys = {key: node for key, node in self._schema["properties"].items() if key not in ("extends", "panels")}
            rules = {name: self._known_rules()[name] for name in self._rules if name in self._known_rules()}
            return {key + self._end(node): _doc(node) for key, node in {**keys, **rules}.items()}
        node, data = self._at(path)
        if isinstance(data, list):
            named = [one["name"] for one in data if isinstance(one, dict) and one.get("name")]
            return {f"{one}.": "" for one in (*named, *range(len(data)))}
        properties = self._properties(node)
        if isinstance(data, dict) and "kind" in data:  # another kind has other settings
            properties = {key: one for key, one in properties.items() if key in data}
        return {key + self._end(one): _doc(one) for key, one in properties.items()}

    def values(self, path: str) -> list[str]:
        """The values that a setting may have, where they are few."""
        node, _ = self._at(path)
        found = []
        for one in self._variants(node):
            found += [str(value) for value in one.get("enum", ())]
            kinds = one.get("type")
            found += ["true", "false"] if kinds == "boolean" or kinds == ["boolean", "null"] else []
        return list(dict.fromkeys(found))

    def _known_rules(self) -> Json:
        """Schemas of the rules by name."""
        for one in self._variants(self._schema["properties"]["rules"]):
            if "properties" in one:
                rules: Json = one["properties"]
                return rules
        return {}

    def _at(self, path: str) -> tuple[Json, Any]:
        """The schema and the data at a path; nothing where it leads nowhere."""
        first, *rest = path.split(".")
        name = first.partition("[")[0]
        node: Json = self._schema["properties"].get(first) or self._known_rules().get(name) or {}
        data: Any = self._data.get(first)
        for part in rest:
            if isinstance(data, list):
                entry = [one for one in data if isinstance(one, dict) and one.get("name") == part]
                entry += data[int(part) :][:1] if part.isdigit() else []
                data = entry[0] if entry else None
            else:
                data = data.get(part) if isinstance(data, dict) else None
            items = [one["items"] for one in self._variants(node) if "items" in one]
            node = items[0] if items else self._properties(node).get(part, {})
        return node, data

    def _variants(self, node: Json) -> Iterator[Json]:
        """The schemas that a schema offers, references followed."""
        if "$ref" in node:
            yield from self._variants(self._schema["$defs"][node["$ref"].rpartition("/")[2]])
        elif "anyOf" in node:
            for one in node["anyOf"]:
                yield from self._variants(one)
        elif node:
            yield node

    def _properties(self, node: Json) -> Json:
        found: dict[str, Any] = {}
        for one in self._variants(node):
            for key, value in one.get("properties", {}).items():
                found.setdefault(key, value)
        return found

    def _end(self, node: Json) -> str:
        """`.` after what has settings or entries of its own, `=` after a setting."""
        deeper = any("properties" in one or "properties" in str(one.get("items", "")) or "$ref" in str(one.get("items"))
                     for one in self._variants(node))  # fmt: skip
        return "." if deeper else "="


def _doc(node: Json) -> str:
    """The first sentence of what a setting means."""
    return str(node.get("description", "")).split(". ")[0].split(": ")[0].strip(".")


def listed(choices: Iterable[str], incomplete: str) -> list[CompletionItem]:
    """Words of a list with commas in between: the choices that are not there yet, after the last comma."""
    done, comma, begin = incomplete.rpartition(",")
    taken = done.split(",")
    return [CompletionItem(f"{done}{comma}{one}") for one in choices if one.startswith(begin) and one not in taken]
