"""Drivers by name: what a preset may name, that strandcli ships, an installed package offers or a program adds.

Imports no driver before it is asked for, and neither numpy nor numba.
"""

from __future__ import annotations

import functools
import importlib
import sys
from pathlib import Path
from typing import Any

from ..errors import UsageError

ROOT = Path(__file__).parents[1]


class Registry:
    """The drivers of one kind.

    Shipped ones are the modules of a package, or the object `DRIVER` in each, named as presets name them. Those of
    other packages are entry points of a group; `register` adds one for this process.
    """

    def __init__(
        self, kind: str, group: str, package: str, first: str, parts: tuple[str, ...], key: str = "name"
    ) -> None:
        """``package``: dotted, inside of strandcli; ``first``: the shipped driver that is named first; ``parts``: what
        every driver has; ``key``: the part by which presets name it."""
        self.kind, self.group, self._key = kind, group, key
        self._package, self._first, self._parts = f"strandcli.{package}", first, parts
        self._folder = ROOT.joinpath(*package.split("."))
        self._drivers: dict[str, Any] = {}

    def names(self) -> tuple[str, ...]:
        """Every known name, shipped ones first."""
        return tuple(dict.fromkeys((*self._shipped(), *self._offered(), *self._drivers)))

    def __getitem__(self, name: str) -> Any:
        """The driver of a name. Raises `UsageError` where it cannot be imported or lacks a part, `KeyError` where there
        is none."""
        if name not in self._drivers:
            if name in self._shipped():
                module = importlib.import_module(f"{self._package}.{name}")
                self._drivers[name] = getattr(module, "DRIVER", module)
            elif name in self._offered():
                self.register(load(self._offered()[name], self.kind))
        return self._drivers[name]

    def register(self, driver: Any) -> None:
        """Add a driver for this process. Raises `UsageError` where it lacks a part or where its name is taken."""
        for part in self._parts:
            if not hasattr(driver, part):
                name = getattr(driver, self._key, driver)
                raise UsageError(f"{self.kind} {name!r}: has no `{part}` (see {self._package})")
        name = getattr(driver, self._key)
        if name in self._shipped() or self._drivers.get(name, driver) is not driver:
            raise UsageError(f"{self.kind} {name!r}: another {self.kind} has this {self._key}")
        self._drivers[name] = driver

    def settings(self, name: str) -> type | None:
        """The class of settings that a driver has of its own, ``Parameters``; None for shipped drivers, whose settings
        stand beside their name."""
        return None if name in self._shipped() else getattr(self[name], "Parameters", None)

    @functools.cache  # noqa: B019  a registry lives as long as its process
    def _shipped(self) -> tuple[str, ...]:
        found = sorted(path.stem for path in self._folder.glob("*.py") if path.stem != "__init__")
        return tuple(sorted(found, key=lambda name: name != self._first))

    @functools.cache  # noqa: B019
    def _offered(self) -> dict[str, Any]:
        """Entry points by name."""
        return {found.name: found for found in offered(self.group)}


def offered(group: str) -> list[Any]:
    """The entry points that installed packages have in a group."""
    # a look at the files themselves: importlib.metadata takes a tenth of the time that `strandcli plan` may take, and
    # hardly anybody has such a package
    if not any(group in text for text in _entry_points()):
        return []
    from importlib.metadata import entry_points

    return list(entry_points(group=group))


def load(entry: Any, kind: str) -> Any:
    """The object that an entry point names. Raises `UsageError` where it cannot be imported."""
    try:
        return entry.load()
    except Exception as error:  # whatever another package raises while it is imported
        raise UsageError(f"{kind} {entry.name!r} ({entry.value}) cannot be imported: {error}") from error


@functools.cache
def _entry_points() -> tuple[str, ...]:
    """The text of every installed package's list of entry points."""
    found = []
    for folder in sys.path:
        for path in Path(folder or ".").glob("*-info/entry_points.txt"):
            try:
                found.append(path.read_text(encoding="utf-8", errors="replace"))
            except OSError:
                continue
    return tuple(found)


FIBRES = Registry("fibre model", "strandcli.fibres", "draw.fibre.models", "marschner", ("name", "tables"))
"""Models of a strand's light: `material.model`."""
LAYOUTS = Registry(
    "layout", "strandcli.layouts", "dataset.layouts", "hairstep", ("name", "paths", "encode", "index")
)  # fmt: skip
"""Layouts of data sets: `strandcli dataset --layout`."""
SHADOWS = Registry(
    "shadow model", "strandcli.shadow_models", "draw.shadows.models", "minmax",
    ("name", "casts_map", "layers", "shades_vertices"),
)  # fmt: skip
"""Models of the strands' shadows: `shadow.model` of a light."""
