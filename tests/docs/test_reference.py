"""docs/preset-reference.md is what `strandcli schema --markdown` prints of the shipped rules."""

from __future__ import annotations

from pages import ROOT
from strandcli.scene.schema import markdown
from strandcli.simulate import rules

SHIPPED = (
    rules.emitter_motion,
    rules.gravity,
    rules.wind,
    rules.stiffness,
    rules.collision,
    rules.elasticity,
    rules.interaction,
    rules.contact,
)


def test_the_reference_is_that_of_the_schema() -> None:
    page = (ROOT / "docs/preset-reference.md").read_text(encoding="utf-8")
    assert page == markdown({rule.name: rule for rule in SHIPPED}), (
        "run: strandcli schema --markdown -o docs/preset-reference.md --overwrite"
    )
