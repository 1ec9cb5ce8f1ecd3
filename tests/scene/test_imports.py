"""The scene knows nobody: nothing heavy is imported with it, and YAML only when a preset is read."""

from __future__ import annotations

import subprocess
import sys

HEAVY = ["numpy", "numba", "pydantic", "PIL", "platformdirs", "click"]


def imported_by(code: str) -> set[str]:
    """The top-level modules that a fresh interpreter has imported after ``code``."""
    script = f"import sys\n{code}\nprint(' '.join({{name.split('.')[0] for name in sys.modules}}))"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(run.stdout.split())


def test_a_solid_with_a_file_of_its_own_is_read_when_it_is_asked_for_and_imports_nothing_heavy() -> None:
    modules = imported_by("""
from strandcli.scene import loads
loads("solids: [{kind: sphere}]", rules={})
assert "strandcli.solid_shapes.cone" not in sys.modules
loads("solids: [{kind: cone}]", rules={})
assert "strandcli.solid_shapes.cone" in sys.modules
""")
    assert modules.isdisjoint(HEAVY)
