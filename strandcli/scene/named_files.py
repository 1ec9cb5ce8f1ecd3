"""Files that a scene names: which setting names each, for messages of those that read them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..errors import RefusedError, UsageError
from ..files.numbered import is_numbered, numbered
from .specs import FileSpec, MapSpec


def named_file(field: dataclasses.Field[Any], value: Any) -> str | None:
    """Return the kind of the file whose path a field's value is; None where it is none."""
    spec = field.metadata.get("spec")
    if not isinstance(spec, FileSpec) or not value or (isinstance(spec, MapSpec) and not Path(value).suffix):
        return None
    return spec.kind


def files_of(thing: Any, place: tuple[str, ...] = ()) -> Iterator[tuple[str, str, str]]:
    """Yield the key, the path and the kind of every file that a scene, or a part of it at a place, names; of numbered
    files the path of each."""
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        for field in dataclasses.fields(thing):
            value = getattr(thing, field.name)
            if (kind := named_file(field, value)) is not None:
                for path in numbered(Path(value)).values() if is_numbered(value) else (value,):
                    yield ".".join((*place, field.name)), str(path), kind
            else:
                yield from files_of(value, (*place, field.name))
    elif isinstance(thing, tuple | list):
        for number, one in enumerate(thing):
            yield from files_of(one, (*place, str(number)))


@contextmanager
def naming_files(scene: Any) -> Iterator[None]:
    """Put the key that names a file before the message of an error that `errors.about` marks as that file's."""
    try:
        yield
    except (UsageError, RefusedError) as error:
        keys = (key for key, path, kind in files_of(scene) if (kind, str(Path(path))) == error.file)
        if (key := next(keys, None)) is not None:
            raise type(error)(f"{key}: {error}") from None
        raise
