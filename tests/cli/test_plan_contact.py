"""`plan` refuses of contact between strands what `render` would refuse."""

from __future__ import annotations

import pytest

from strandcli.cli.main import main
from strandcli.plan import make_plan
from strandcli.scene import load
from strandcli.simulate.rules import registry

ROD = ("minimal", "--strands", "20", "--set", "solver=rod", "--set")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (("rules=[gravity, {contact: {thickness: 99}}]",), "rule contact.thickness: 99 m is more than the groom"),
        (("rules=[gravity, {interaction: {cell: 1e-9}}]",), "cell: 1e-09 m is less than a strand's thickness"),
        (("rules=[gravity, {interaction: {cell: 1e9}}]",), "cell: 1e+09 m is larger than the groom, which is at most"),
        (("rules=[gravity, {interaction: {cell: 0.001}}]",), "is less than a 64th of a segment"),
    ],
)
def test_contact_that_rods_refuse(settings: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", *ROD, *settings]) == 2
    assert words in capsys.readouterr().err


def test_contact_takes_memory_where_strands_are_many() -> None:
    """290 bytes a particle, 32 a cell that a segment lies in, about four, and 50 a pair of boxes that meet."""
    for strands, more in ((200, 1e6), (20_000, 105e6)):
        few = (f"emitter.strands={strands}", "solver=rod")
        plain, touching = (
            make_plan(load("minimal", rules=registry(), overrides=(*few, f"rules=[gravity{rule}]")), [1]).memory_bytes
            for rule in ("", ", {contact: {}}")
        )
        assert abs(touching - plain - more) < 20e6, strands
