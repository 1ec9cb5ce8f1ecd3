"""What the commands for files of strands share: options of reading, and how facts are said."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from ..common.counted import counted
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
    options.objects,
)  # fmt: skip

MOST_OBJECTS = 20
"""Objects that are told to people."""


def say_facts(found: Facts) -> None:
    """Facts for people: a line each."""
    from ..exchange.objects import shown

    data = found.data
    kind = " ".join(part for part in (data["format"], data["version"]) if part)
    say(f"{data['file']}: {kind}, {data['bytes']:,} bytes")
    say(f"  strands    {data['strands']:,}")
    counts = data["points_a_strand"]
    if counts is not None:
        each = f"{counts['min']:,}" if counts["min"] == counts["max"] else f"{counts['min']:,} to {counts['max']:,}"
        say(f"  points     {data['points']:,}, {each} a strand")
    if data["length"] is not None:
        one = data["length"]
        say(f"  length     {one['min']:.4g} to {one['max']:.4g}, median {one['median']:.4g}")
    if data["box"] is not None:
        box = data["box"]
        spans = [f"{'xyz'[i]} {box['min'][i]:.4g} to {box['max'][i]:.4g}" for i in range(3)]
        say(f"  box        {', '.join(spans)}")
    if data["unit"] is not None:
        say(f"  unit       {data['unit']:.6g} m")
    if data["up"] is not None:
        say(f"  up         {data['up']}")
    for one in data["objects"][:MOST_OBJECTS]:
        say(f"  object     {shown(one['name'])}: {counted(one['strands'], 'strand')}, {one['points']:,} points")
    if len(data["objects"]) > MOST_OBJECTS:
        say(f"  object     and {len(data['objects']) - MOST_OBJECTS:,} more, all of them with --json")
    for one in data["attributes"]:
        bounds = "" if one["min"] is None else f", {one['min']:.4g} to {one['max']:.4g}"
        say(f"  attribute  {one['name']}: {one['type']} for each {one['domain']}{bounds}")
    if data["moments"] is not None:
        say(f"  moments    {_moments(data['moments'])}")
    for name, value in data["header"].items():
        if value not in ("", None):
            say(f"  header     {name.replace('_', ' ')}: {value}")
    for text in _guesses(data["guess"]):
        say(f"  guess      {text}")
    if data["strands"] and _as_it_is(data):
        say(f"  as it is   {_as_it_is(data)}")
    for fault in found.faults:
        say(f"  fault      {fault.text}" + (f"; convert {fault.mend}" if fault.mend else ""))


def _moments(found: Mapping[str, Any]) -> str:
    """When strands are known."""
    if found["unit"] == "s":
        span = f"{found['first']:.4g} to {found['last']:.4g} s, {found['frames_a_second']:.4g} a second"
    else:
        span = f"files {found['first']:.0f} to {found['last']:.0f}"
        span += f", {found['missing']:,} of them missing" if found["missing"] else ""
    return f"{found['count']:,}, {span}"


def _guesses(guess: Mapping[str, Any]) -> list[str]:
    found = []
    if guess["root"] is not None:
        found.append(f"roots are {guess['root']}")
    if guess["up"] is not None:
        found.append(f"up is {guess['up']['axis']}")
    return found


def _as_it_is(data: Mapping[str, Any]) -> str:
    """What holds because neither the file nor its strands tell otherwise, "" where they tell all."""
    guess = data["guess"]
    taken = {"roots are first": (None, guess["root"]), "up is y": (data["up"], guess["up"]),
             "units are metres": (data["unit"], None)}  # fmt: skip
    found = ", ".join(words for words, known in taken.items() if known == (None, None))
    return found and f"{found}: there is no evidence for a guess"
