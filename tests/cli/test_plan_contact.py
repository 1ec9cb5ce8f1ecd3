"""`plan` refuses of contact between strands what `render` would refuse."""

from __future__ import annotations

import pytest

from strandcli.cli.main import main

ROD = ("minimal", "--strands", "20", "--set", "solver=rod", "--set")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (("rules=[gravity, {contact: {thickness: 99}}]",), "rule contact.thickness: 99 m is more than the groom"),
        (("rules=[gravity, {contact: {}}]", "--set", "rod.integrator=bdf2"), "bdf2 does not go with the rule contact"),
    ],
)
def test_contact_that_rods_refuse(settings: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", *ROD, *settings]) == 2
    assert words in capsys.readouterr().err
