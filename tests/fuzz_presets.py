"""Presets that `fuzz` makes: of the shipped ones and of one another, with values that nobody means."""

from __future__ import annotations

import contextlib
import io
import time
from collections.abc import Mapping
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from fuzz_changes import OTHERS, mutated
from strandcli.cli.main import main
from strandcli.scene import library

LONGEST = 1.0
"""Seconds of a processor's time for one command."""
GOOD = {0: "read", 2: "refused", 4: "refused"}
FILES = Path(__file__).resolve().parents[1] / "presets"
WORDS = (
    *OTHERS, 1e-30, 1e30, -1e30, 1e-300, 0.999, 255, 10**6, 10**9, "hair", "a.preset", "fifo", "/dev/zero",
    "/dev/full", "/proc/self/environ", "/", "..", "../../x", "~", "a" * 5000, "\x1b[2J", "é\u202e", "1e999", "#ff0000",
    "off", "null", [1, 2], [1, 2, 3], [0, 0, 0], [1e30, -1e30, 1e-30], [10**9, 10**9], [[0, 1], [2, 3]],
    ["wind", "wind"],
)  # fmt: skip
"""What values become."""
OUT, TOLD = io.StringIO(), io.StringIO()
"""What commands write: the same each time, for click keeps every stream that it has written to."""


def command(*words: object, good: Mapping[int, str] = GOOD) -> str:
    """What becomes of a command: as its exit code says, or what is wrong with how it ends."""
    for stream in (OUT, TOLD):
        stream.seek(0)
        stream.truncate()
    out, told, begin = OUT, TOLD, time.process_time()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(told):
        code = main([str(word) for word in words])
    took = time.process_time() - begin
    lines = told.getvalue().splitlines()
    if code not in good or "out of memory;" in told.getvalue():
        return f"exit code {code}: {lines[-1:]}"
    if code and not lines:
        return "nothing is told"
    if not all(line.isprintable() for line in (*lines, *out.getvalue().splitlines())):
        return f"lines as these: {told.getvalue()!r:.200}"
    return good[code] if took < LONGEST else f"{took:.1f} s"


@cache
def trees() -> list[dict[str, Any]]:
    """The shipped presets."""
    return [yaml.safe_load(path.read_bytes()) for path in sorted(FILES.glob("*.yaml"))]


def files() -> list[bytes]:
    """The shipped presets, small ones among them twice."""
    return [path.read_bytes() for path in (*sorted(FILES.glob("**/*.yaml")), *sorted(FILES.glob("figures/*.yaml")))]


def mutated_preset(content: bytes, generator: np.random.Generator) -> bytes:
    """One that is damaged as text, or, mostly, one in whose tree some values are others, or parts of other presets."""
    if generator.random() < 0.25:
        return mutated(content, generator)
    tree = yaml.load(content, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    for _ in range(generator.integers(1, 4)):
        place, key = _place(tree, generator)
        if key is None:
            continue
        chance = generator.random()
        if chance < 0.25:
            donor, other = _place(deepcopy(trees()[int(generator.integers(len(trees())))]), generator)
            if other is not None and isinstance(donor, dict) and isinstance(place, dict):
                place[other] = donor[other]
        elif chance < 0.35:
            del place[key]
        elif chance < 0.75 and type(place[key]) in (int, float):
            number = float(min(max(place[key], -(10**300)), 10**300)) * 10.0 ** generator.normal(0, 2)
            place[key] = type(place[key])(np.clip(np.nan_to_num(number), -1e300, 1e300)) * int(
                generator.choice((1, -1))
            )
        else:
            place[key] = deepcopy(WORDS[int(generator.integers(len(WORDS)))])
    text = yaml.dump(tree, Dumper=getattr(yaml, "CSafeDumper", yaml.SafeDumper), allow_unicode=True, sort_keys=False)
    return text.encode("utf-8", "surrogatepass")


def _place(tree: Any, generator: np.random.Generator) -> tuple[Any, Any]:
    """A mapping or a list of a tree and a key of it; None where it has none."""
    while True:
        keys = list(tree) if isinstance(tree, dict) else list(range(len(tree)))
        if not keys:
            return tree, None
        key = keys[int(generator.integers(len(keys)))]
        if not isinstance(tree[key], dict | list) or generator.random() < 0.15:
            return tree, key
        tree = tree[key]


def remember_shipped() -> None:
    """Have shipped presets found and parsed once in this process: damaged ones extend them, and they are the same each
    time."""
    whole = {path.read_bytes() for path in FILES.glob("**/*.yaml")}
    known: dict[tuple[bytes, str], Any] = {}
    parse = library._read

    def read(data: bytes, file: str) -> Any:
        if data not in whole or not file.startswith(str(FILES)):
            return parse(data, file)
        if (data, file) not in known:
            known[data, file] = parse(data, file)
        return known[data, file]

    library._read = read
    library.list_presets = cache(library.list_presets)


def attempt_preset(content: bytes, folder: Path) -> str:
    """Plan it."""
    path = folder / "a.preset"
    path.write_bytes(content)
    found = command("plan", path)
    stray = [one.name for one in folder.iterdir() if one != path]
    return f"{stray} was written" if stray else found
