"""Rules of the code that no linter knows: how long files and functions are, and what may import what."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "strandcli"
TESTS = PACKAGE.parent / "tests"
LINES_OF_FILE = 300
"""Of the package and of the tests."""
LINES_OF_FUNCTION = 60
"""Docstring and decorators included."""
ARGUMENTS = 10
"""Of a function; commands of `strandcli.cli` have one an option."""
ROOMS = ("common", "view", "geometry", "zbuffer", "solids", "coverage", "fibre", "shadows", "lighting", "film")
"""Of `strandcli.draw`: each imports those before it alone."""
BELOW_SCENE = "scene", "common", "files"
"""Rooms that settings may import."""
APART = (
    ("draw", "simulate"), ("simulate", "draw"), ("draw", "output"), ("simulate", "output"), ("groom", "output"),
    ("draw", "exchange"), ("simulate", "exchange"), ("groom", "exchange"), ("solids", "exchange"),
    ("draw", "groom_file"), ("simulate", "groom_file"), ("groom", "groom_file"), ("scene", "groom_file"),
    ("exchange", "groom_file"), ("groom_file", "draw"), ("groom_file", "simulate"),
    ("exchange", "draw"), ("exchange", "simulate"), ("exchange", "groom"), ("exchange", "scene"),
    *(("meshes", other) for other in ("draw", "simulate", "groom", "groom_file", "scene", "solids", "output")),
)  # fmt: skip
"""Packages of which the first may import nothing of the second."""
FOR_KERNELS = (
    "strandcli.constants", "strandcli.jit", "strandcli.simd", "strandcli.solids",
)  # fmt: skip
"""What modules in a folder `kernels` import beside kernels."""


@cache
def modules() -> dict[str, ast.Module]:
    """The syntax trees of the package by the names of its modules."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = ["strandcli", *path.relative_to(PACKAGE).with_suffix("").parts]
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = ast.parse(path.read_text("utf-8"))
    return found


def path_of(module: str) -> Path:
    """The file of a module."""
    path = PACKAGE.joinpath(*module.split(".")[1:])
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def functions() -> Iterator[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef]]:
    """All functions and methods with their names, as module:name."""
    for module, tree in modules().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield f"{module}:{node.name}", node


@cache
def imports(module: str) -> set[str]:
    """The modules of the package that a module imports, anywhere but for types alone."""
    found = set()
    for node in without_types(modules()[module]):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names if alias.name in modules()}
        elif isinstance(node, ast.ImportFrom):
            package = module.split(".") if path_of(module).name == "__init__.py" else module.split(".")[:-1]
            base = package[: len(package) - node.level + 1] if node.level else []
            name = ".".join([*base, node.module] if node.module else base)
            for alias in node.names:
                inner = f"{name}.{alias.name}"
                found |= {inner if inner in modules() else name} & modules().keys()
    return found - {module}


def without_types(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes but those under ``if TYPE_CHECKING:``."""
    yield node
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"):
            yield from without_types(child)


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Sets of nodes that all lead to each other, sorted (Tarjan's components of more than one node)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(graph.get(node, ())):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            begin = stack.index(node)
            found.append(sorted(stack[begin:]))
            del stack[begin:]

    for node in sorted(graph):
        if node not in index:
            visit(node)
    return [circle for circle in found if len(circle) > 1]


def is_command(name: str) -> bool:
    """Whether a function is one of click's commands, which have an argument an option."""
    return name.startswith("strandcli.cli.") and name.endswith(":command")


def test_files_are_short() -> None:
    files = [*map(path_of, modules()), *TESTS.rglob("*.py")]
    long = {path for path in files if len(path.read_text("utf-8").splitlines()) > LINES_OF_FILE}
    assert not long


def test_functions_are_short() -> None:
    """Of commands what comes after their options."""

    def lines(name: str, node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
        begin = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
        begin = node.body[0].lineno if is_command(name) else begin
        return (node.end_lineno or begin) - begin + 1

    assert not {name for name, node in functions() if lines(name, node) > LINES_OF_FUNCTION}


def test_functions_have_few_arguments() -> None:
    def many(node: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
        given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
        return len([one for one in given if one.arg not in ("self", "cls")]) > ARGUMENTS

    found = {name for name, node in functions() if many(node)}
    assert not {name for name in found if not is_command(name)}


def test_no_files_import_each_other_in_a_circle() -> None:
    """The package itself imports its parts when they are asked for, and does not count."""
    graph = {module: imports(module) - {"strandcli"} for module in modules() if module != "strandcli"}
    assert circles(graph) == []


def test_no_packages_import_each_other_in_a_circle() -> None:
    """A process that compiles is a program of its own, which imports what it compiles."""

    def package(module: str) -> str:
        return module if module == "strandcli.compiling.worker" else ".".join(module.split(".")[:2])

    graph: dict[str, set[str]] = {}
    for module in modules():
        if module != "strandcli":
            others = {package(one) for one in imports(module) if one != "strandcli"}
            graph.setdefault(package(module), set()).update(others - {package(module)})
    assert circles(graph) == []


def test_packages_import_only_what_they_may() -> None:
    """Settings know nothing of who uses them, drawing and moving nothing of each other, and the command line is for
    ``python -m strandcli`` alone."""
    wrong = []
    for module in modules():
        package = module.split(".")[1:2]
        for other in imports(module):
            for importer, imported in APART:
                if package == [importer] and other.split(".")[1:2] == [imported]:
                    wrong.append(f"{module} imports {other}")
            if package == ["scene"] and path_of(other).parent != PACKAGE and other.split(".")[1] not in BELOW_SCENE:
                wrong.append(f"{module} imports {other}")
            if other.startswith("strandcli.cli") and package not in (["cli"], ["__main__"]):
                wrong.append(f"{module} imports {other}")
    assert not wrong


def test_rooms_import_those_before_them() -> None:
    """And none imports a file of `strandcli.draw` itself, which is in no room."""
    wrong = []
    for module in modules():
        room = module.split(".")[2:3]
        if module.startswith("strandcli.draw.") and room[0] in ROOMS:
            for other in imports(module):
                if other.startswith("strandcli.draw."):
                    there = other.split(".")[2]
                    if there not in ROOMS or ROOMS.index(there) > ROOMS.index(room[0]):
                        wrong.append(f"{module} imports {other}")
    assert not wrong


def test_kernels_import_no_drivers() -> None:
    found = set()
    for module in modules():
        if ".kernels." in module:
            others = {one for one in imports(module) if ".kernels" not in one and not one.startswith(FOR_KERNELS)}
            found |= {f"{module} {other}" for other in others}
    assert not found


def test_kernels_ask_for_double_precision_by_its_name() -> None:
    """Numba's ``float(x)`` of a number in single precision stays in single precision."""
    wrong = []
    for module, tree in modules().items():
        if ".kernels." in module:
            calls = [one for one in ast.walk(tree) if isinstance(one, ast.Call)]
            wrong += [f"{module}:{one.lineno}" for one in calls if ast.unparse(one.func) == "float"]
    assert not wrong, "np.float64(x) is meant"


def test_parallel_kernels_write_to_no_member_of_a_tuple() -> None:
    """Numba takes ``lines.screen[v] = x`` in a parallel kernel, where lines is a tuple, for dead code and leaves it
    out: a function that the kernel calls has to write it."""
    wrong = []
    for name, node in functions():
        if not any(ast.unparse(decorator) == "parallel" for decorator in node.decorator_list):
            continue
        assigned = [one for one in ast.walk(node) if isinstance(one, ast.Assign | ast.AugAssign)]
        members = set()
        for one in assigned:
            if isinstance(one, ast.Assign):
                for target in one.targets:
                    members |= set(member_names(target, one.value))
        for one in assigned:
            for target in one.targets if isinstance(one, ast.Assign) else [one.target]:
                if isinstance(target, ast.Subscript):
                    array = target.value
                    if isinstance(array, ast.Attribute) or (isinstance(array, ast.Name) and array.id in members):
                        wrong.append(f"{name}: {ast.unparse(target)}")
    assert not wrong


def member_names(target: ast.expr, value: ast.expr) -> Iterator[str]:
    """Names that an assignment makes stand for members of a tuple."""
    if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        for inner, one in zip(target.elts, value.elts, strict=True):
            yield from member_names(inner, one)
    elif isinstance(target, ast.Tuple) and isinstance(value, ast.Name):
        yield from (inner.id for inner in target.elts if isinstance(inner, ast.Name))
    elif isinstance(target, ast.Name) and isinstance(value, ast.Attribute):
        yield target.id


OPENS_PICTURES = "strandcli.files.picture_samples"
"""The module that opens pictures, of a list of formats."""
LIBRARIES = {
    "OpenEXR", "PIL", "click", "distributed", "imageio_ffmpeg", "isal", "llvmlite", "numba", "numpy", "platformdirs",
    "pxr", "strandcli", "yaml",
}  # fmt: skip
"""By none of these but PIL is a file opened that may be or name a picture."""


def test_pictures_are_opened_in_one_module() -> None:
    """Pillow's `open` without formats runs Ghostscript, for one; and other libraries call it so."""
    openers, libraries = set(), set()
    for module, tree in modules().items():
        for node in ast.walk(tree):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and not node.level:
                names = [f"{node.module}.{alias.name}" for alias in node.names]
            libraries |= {name.split(".")[0] for name in names} - sys.stdlib_module_names
            opened = isinstance(node, ast.Attribute) and ast.unparse(node) in ("Image.open", "PIL.Image.open")
            if opened or any(name.startswith("PIL.") and ("Plugin" in name or "ImageFile" in name) for name in names):
                openers.add(module)
            assert "PIL.Image.open" not in names, module
    assert openers == {OPENS_PICTURES}
    assert libraries == LIBRARIES
