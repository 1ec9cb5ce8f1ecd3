"""Cells of a grid of strands that would be too many: what is told is enough."""

from __future__ import annotations

import pytest

from strandcli.errors import UsageError
from tests.simulate.test_grid import solver_of


@pytest.mark.parametrize(
    ("shape", "cell"), [("{kind: sphere, radius: 0.1}", 1e-3), ("{kind: disc, radius: 2000}", 0.05)]
)
def test_cells_as_large_as_is_said_are_few_enough(shape: str, cell: float) -> None:
    """And not twice as large as they have to be, where the groom is as flat as a sheet, too."""

    def begin(cell: float) -> None:
        solver_of(
            f"emitter: {{shape: {shape}, strands: 64, particles: 5, length: 0.2}}\n"
            f"rules: [interaction: {{cell: {cell}}}]"
        ).advance(2)

    with pytest.raises(UsageError, match="make them at least") as raised:
        begin(cell)
    enough = float(str(raised.value).rsplit(" ", 1)[1])
    begin(enough)
    with pytest.raises(UsageError, match="make them at least"):
        begin(enough / 2)
