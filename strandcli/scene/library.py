"""The presets that are shipped with strandcli, found by name."""

from __future__ import annotations

import re
from pathlib import Path

from ..errors import StrandError, UsageError
from .faults import near, one_line, shown

SUFFIXES = (".yaml", ".yml")


def folder() -> Path:
    """Where shipped presets are: in the installed package, or at the top of a checkout."""
    package = Path(__file__).resolve().parent.parent
    installed = package / "presets"
    return installed if installed.is_dir() else package.parent / "presets"


def list_presets() -> list[tuple[str, Path]]:
    """Name and path of every shipped preset, by name; those in a subfolder last, as ``figures/fig02``."""
    home = folder()
    found = [path for suffix in SUFFIXES for path in home.rglob(f"*{suffix}") if path.is_file()]
    named = [(path.relative_to(home).with_suffix("").as_posix(), path) for path in found]
    return sorted(named, key=lambda pair: (pair[0].count("/"), pair[0]))


def find(name: str) -> Path:
    """The shipped preset of this name. Raises UsageError, with a near name, where there is none."""
    presets = dict(list_presets())
    if name in presets:
        return presets[name]
    lost = no_such_preset(name)
    raise UsageError(lost)


def no_such_preset(name: str, others: tuple[str, ...] = ()) -> str:
    """The message for a preset that is not there; ``others`` are names that might have been meant as well."""
    names = [shipped for shipped, _ in list_presets()]
    inside = (shipped for shipped in names if shipped.rpartition("/")[2] == name)  # fig02 for figures/fig02
    guess = next(inside, None) or near(name, [*others, *names])
    meant = f"did you mean {shown(guess)}? " if guess else ""
    if name.endswith(SUFFIXES):  # a path, which the list of shipped names does not help with
        return f"no preset {shown(name)}: there is no such file" + (f"; {meant.strip()}" if guess else "")
    return f"no preset {shown(name)}; {meant}`strandcli presets list` shows what is shipped"


def describe(path: Path) -> str:
    """What a preset shows, on one line: its ``title``, else its first comment, else nothing.

    Only these lines are read, so that a folder of presets is listed quickly, faulty ones too.
    """
    from .nodes import Scalar
    from .yaml_source import read_value

    try:
        lines = path.read_text("utf-8-sig", errors="replace").splitlines()
    except OSError:
        return ""
    for line in lines:
        if title := re.match(r"title:\s+(.+)", line):
            try:
                value = read_value(title[1], str(path))
            except StrandError:
                break
            return one_line(value.text) if isinstance(value, Scalar) else ""
    comment = next((line.lstrip("# ").strip() for line in lines if line.startswith("#")), "")
    return one_line(comment)
