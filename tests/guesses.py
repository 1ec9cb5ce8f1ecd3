"""How often guesses about strands are right: ``python tests/guesses.py [seeds] [FILE ...]``.

Made grooms of all kinds of `ends_kit`, and files of strands that have roots first, as they are and with all strands
turned around, in random units and up axes. Exit code 1 where a guess is wrong.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import ends_kit
from strandcli.exchange.edit.fix import reversed_all
from strandcli.exchange.ends import ends, head, up_axis
from strandcli.exchange.files import ReadOptions, read
from strandcli.exchange.strands import Strands


def judged(right: bool | None) -> str:
    return "undecided" if right is None else "right" if right else "wrong"


def tally(strands: Strands, up: str | None, unit: float | None) -> Counter[str]:
    """How guesses of strands, roots first, come out both ways round; ``up``, ``unit`` None where not known."""
    found: Counter[str] = Counter()
    for truth in ("first", "last"):
        given = strands if truth == "first" else reversed_all(strands)[0]
        known = ends(given)
        found[f"root {judged(None if not known.root else known.root == truth)}"] += 1
        axis, human = up_axis(given, known), head(given, known)
        if up is not None:
            found[f"up {judged(None if axis is None else axis[0] == up)}"] += 1
        if unit is not None:
            found[f"unit {judged(None if human is None else human.scale == unit)}"] += 1
    return found


def cases(seeds: int, files: list[str]) -> Iterator[tuple[str, Counter[str]]]:
    for kind in ends_kit.KINDS:
        counts: Counter[str] = Counter()
        for seed in range(seeds):
            made = ends_kit.made(kind, seed)
            counts += tally(made.strands, made.up, made.unit)
        yield kind, counts
    for file in files:
        yield Path(file).name, tally(read(Path(file), ReadOptions(lenient=True)), None, None)


def main() -> int:
    seeds, files = int(sys.argv[1]) if len(sys.argv) > 1 else 40, sys.argv[2:]
    total: Counter[str] = Counter()
    for name, counts in cases(seeds, files):
        total += counts
        print(f"{name:20}", ", ".join(f"{counts[one]} {one}" for one in sorted(counts)))
    print(f"{'all':20}", ", ".join(f"{total[one]} {one}" for one in sorted(total)))
    return int(any(one.endswith("wrong") for one in +total))


if __name__ == "__main__":
    sys.exit(main())
