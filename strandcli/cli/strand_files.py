"""What the commands for files of strands share: options of reading, and how facts are said."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from . import options
from .say import say

if TYPE_CHECKING:
    from ..exchange.facts import Facts

reading = options.together(
    click.option(
        "--stride", type=options.Whole(2, 1_000_000), metavar="N",
        help="Points a strand, where a file has vertices alone.",
    ),
    click.option("--array", metavar="NAME", help="Array of the points, where an .npz file has several."),
)  # fmt: skip


def say_facts(found: Facts) -> None:
    """Facts for people: a line each."""
    data = found.data
    kind = " ".join(part for part in (data["format"], data["version"]) if part)
    say(f"{data['file']}: {kind}, {data['bytes']:,} bytes")
    say(f"  strands    {data['strands']:,}")
    counts = data["points_a_strand"]
    if counts is not None:
        each = f"{counts['min']:,}" if counts["min"] == counts["max"] else f"{counts['min']:,} to {counts['max']:,}"
        say(f"  points     {data['points']:,}, {each} a strand")
    for name, unit in (("length", ""), ("segment", ""), ("curvature", " radians a unit")):
        if data[name] is not None:
            one = data[name]
            say(f"  {name:<10} {one['min']:.4g} to {one['max']:.4g}, median {one['median']:.4g}{unit}")
    if data["box"] is not None:
        box = data["box"]
        spans = [f"{'xyz'[i]} {box['min'][i]:.4g} to {box['max'][i]:.4g}" for i in range(3)]
        say(f"  box        {', '.join(spans)}")
    if data["unit"] is not None:
        say(f"  unit       {data['unit']:.6g} m")
    if data["up"] is not None:
        say(f"  up         {data['up']}")
    for one in data["attributes"]:
        bounds = "" if one["min"] is None else f", {one['min']:.4g} to {one['max']:.4g}"
        say(f"  attribute  {one['name']}: {one['type']} for each {one['domain']}{bounds}")
    for name, value in data["header"].items():
        if value not in ("", None):
            say(f"  header     {name.replace('_', ' ')}: {value}")
    for text in _guesses(data["guess"]):
        say(f"  guess      {text}")
    for fault in found.faults:
        say(f"  fault      {fault.text}" + (f"; convert {fault.mend}" if fault.mend else ""))


def _guesses(guess: Mapping[str, Any]) -> list[str]:
    found = []
    if guess["root"] is not None:
        found.append(f"roots are {guess['root']}")
    if guess["up"] is not None:
        found.append(f"up is {guess['up']['axis']}")
    if guess["head"] is not None:
        head = guess["head"]
        found.append(f"a head of radius {head['radius']:.3g}" + (f", in {head['unit']}" if head["unit"] else ""))
    return found
