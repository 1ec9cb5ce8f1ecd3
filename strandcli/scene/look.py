"""`look: source`: the source's own way of drawing by one word, and what clashes with it.

A look stands for several settings. Those that were not written get its values; one that was written and says otherwise
is a fault that names both, because neither could win without a surprise.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from typing import Any, NamedTuple

from .faults import shown
from .fields import settings_of
from .model import Scene
from .paths import value_at, with_value


class Fixed(NamedTuple):
    """A setting that a look fixes: the values that it allows, of which the first is its own."""

    path: str
    """Dotted; `*` stands for every entry of a list."""
    values: tuple[str | bool, ...]


LOOKS: Mapping[str, tuple[Fixed, ...]] = {
    "source": (
        Fixed("image.resolver", ("zbuffer",)),
        Fixed("material.model", ("marschner",)),
        Fixed("material.rounded", (False,)),
        Fixed("lights.*.shadow.model", ("minmax", "off")),
    ),
}
"""What each look fixes. Settings that do not exist are passed over: then there is but one way."""


def settle(scene: Scene, written: Container[str]) -> tuple[Scene, list[tuple[str, str]]]:
    """``scene`` with what its look fixes, and the clashes: path and message. ``written``: paths that were given."""
    clashes: list[tuple[str, str]] = []
    for path, values in LOOKS.get(scene.look, ()):
        for place in _places(scene, path.split(".")):
            name = ".".join(place)
            found = value_at(scene, name)
            if found in values:
                continue
            if name in written:
                clashes.append(
                    (
                        name,
                        f"{shown(_written(found))} clashes with look: {scene.look}, which draws with "
                        f"{' or '.join(map(_written, values))}; take one of the two out",
                    )
                )
            else:
                scene = with_value(scene, name, values[0])
    return scene, clashes


def _written(value: str | bool) -> str:
    return str(value).lower() if isinstance(value, bool) else value


def _places(scene: Any, parts: list[str]) -> Iterator[tuple[str, ...]]:
    """Paths without `*` of what there is."""
    if not parts:
        yield ()
    elif parts[0] == "*":
        for index, item in enumerate(scene):
            for rest in _places(item, parts[1:]):
                yield (str(index), *rest)
    else:
        kind: type = type(scene)
        if parts[0] not in settings_of(kind):
            return
        for rest in _places(getattr(scene, parts[0]), parts[1:]):
            yield (parts[0], *rest)
