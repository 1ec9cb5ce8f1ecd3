"""Kernels name an array for as long as they work in its memory."""

from __future__ import annotations

import ast
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "strandcli"
MAKERS = ("np.empty", "np.zeros", "np.ones", "np.full")


def freed_early(function: ast.FunctionDef) -> list[str]:
    """Names of arrays that a function makes, and that no line names after a pointer to them was taken."""
    made, pointed, named = set(), {}, {}
    for node in ast.walk(function):
        if isinstance(node, ast.Name):
            named[node.id] = max(named.get(node.id, 0), node.lineno)
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Call):
            made |= {ast.unparse(one) for one in node.targets if ast.unparse(node.value.func) in MAKERS}
        if isinstance(node, ast.Call) and node.args and ast.unparse(node.func).endswith("pointer"):
            array = ast.unparse(node.args[0])
            pointed[array] = max(pointed.get(array, 0), node.lineno)
    return [name for name, line in pointed.items() if name in made and named[name] <= line]


def functions(text: str) -> list[ast.FunctionDef]:
    return [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)]


def test_no_kernel_works_in_memory_that_is_freed() -> None:
    """Numba frees an array after the last line that names it; a pointer does not hold it."""
    (wrong,) = functions("def f():\n    a = np.empty(4)\n    rows = pointer(a)\n    store(rows, 0, 1.0)")
    assert freed_early(wrong) == ["a"]
    found = [(path, one) for path in PACKAGE.rglob("kernels/*.py") for one in functions(path.read_text("utf-8"))]
    assert len(found) > 500
    assert [(path.name, one.name) for path, one in found if freed_early(one)] == []
