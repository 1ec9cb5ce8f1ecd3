"""What SECURITY.md promises, and that each of its promises names tests that there are."""

from __future__ import annotations

import ast
import json
import re
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cli_runs import ROOT, Runner
from strandcli.cli.sweep import Axis, points
from strandcli.dataset.views import names_of

PAGE = (ROOT / "SECURITY.md").read_text(encoding="utf-8")
UNPICKLING = {"compiling/worker.py", "compiling/service.py", "jit/cache.py"}
"""Between processes of strandcli's own, and kernels whose hash and owner were looked at."""
NETWORK = {"http", "urllib.request", "ftplib", "smtplib", "ssl", "requests", "asyncio", "xmlrpc", "webbrowser"}


def test_each_promise_names_tests_that_there_are() -> None:
    promised = PAGE.partition("## What is promised")[2].partition("\n## ")[0]
    bullets = re.split(r"^- ", promised, flags=re.MULTILINE)[1:]
    assert len(bullets) >= 7
    for bullet in bullets:
        named = re.findall(r"<!-- (\S+?)::(\w+) -->", bullet)
        assert named, bullet
        for file, test in named:
            assert f"def {test}(" in (ROOT / file).read_text(encoding="utf-8"), (file, test)


def calls() -> Iterator[tuple[str, ast.Call, str]]:
    """File, call and what is called, of all calls in the package; a class is as if it called those that it is of."""
    for path in sorted((ROOT / "strandcli").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_bytes())):
            if isinstance(node, ast.Call):
                yield path.relative_to(ROOT / "strandcli").as_posix(), node, ast.unparse(node.func)
            elif isinstance(node, ast.ClassDef):
                for base in node.bases:
                    yield path.relative_to(ROOT / "strandcli").as_posix(), ast.Call(base, [], []), ast.unparse(base)


def test_nothing_from_outside_is_unpickled() -> None:
    found = set()
    for file, node, name in calls():
        if re.fullmatch(r"(.*\.)?(pickle|dill|marshal|shelve|joblib|cloudpickle)\.(load|loads|open|Unpickler)", name):
            found.add(file)
        if name.endswith(("np.load", "numpy.load", "format.read_array")):
            words = {one.arg: ast.unparse(one.value) for one in node.keywords}
            assert words.get("allow_pickle") == "False", (file, node.lineno)
        if name in ("yaml.load", "yaml.unsafe_load", "yaml.full_load"):
            raise AssertionError((file, node.lineno))
    assert found == UNPICKLING
    imported = {path for path in (ROOT / "strandcli").rglob("*.py") if "from pickle import" in path.read_text("utf-8")}
    assert not imported


def test_no_connection_is_opened(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    for path in (ROOT / "strandcli").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_bytes())):
            names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
            names += [str(node.module)] if isinstance(node, ast.ImportFrom) else []
            assert not NETWORK & {*names, *(name.partition(".")[0] for name in names)}, path

    def never(*_: object, **__: object) -> None:
        raise AssertionError("a connection")

    monkeypatch.setattr(socket, "socket", never)
    monkeypatch.setattr(socket, "create_connection", never)
    run.fine("render", "tiny.yaml", "-f", "1", "-o", "out")


def plain(name: str) -> bool:
    """Whether it is one part of a path that leads nowhere else."""
    return bool(name) and name == Path(name).name and name not in (".", "..") and "\0" not in name


KEYS = st.sampled_from(["wind.strength", "label", "material.color", "emitter.groom.file"])
VALUES = st.text(max_size=80) | st.sampled_from(["..", "../../x", "/etc/passwd", "a/b", ".", "", "con", "C:\\x"])


@given(st.lists(st.tuples(KEYS, st.lists(VALUES, min_size=1, max_size=3, unique=True)), min_size=1, max_size=2))
def test_names_of_folders_and_files_are_single_plain_parts(axes: list[tuple[str, list[str]]]) -> None:
    if len({key for key, _ in axes}) == len(axes):
        found = [one.name for one in points([Axis(key, tuple(values)) for key, values in axes])]
        assert all(map(plain, found))
        assert len({name.casefold() for name in found}) == len(found)
    grooms = [value for _, values in axes for value in values if "\0" not in value]
    found = names_of(grooms + grooms)
    assert all(map(plain, found))
    assert len(set(found)) == len(found)


def test_a_report_shows_no_pictures_but_frames_of_its_folder(run: Runner) -> None:
    assert run("render", "tiny.yaml", "-f", "1-2", "-o", "out").code == 0
    path = Path("out/report.json")
    data = json.loads(path.read_text("utf-8"))
    Path("secret.png").write_bytes(Path("out/frame_0002.png").read_bytes())
    data["frames"][1] |= {"file": "../secret.png", "seconds": 5, "error": [], "counts": {"strands": "many"}}
    data["frames"].append({"frame": [], "file": "../secret.png"})
    path.write_text(json.dumps(data), encoding="utf-8")
    assert run("render", "tiny.yaml", "-f", "1", "-o", "out", "--resume").code == 0
    again = json.loads(path.read_text("utf-8"))
    assert [one["file"] for one in again["frames"]] == ["frame_0001.png"]
