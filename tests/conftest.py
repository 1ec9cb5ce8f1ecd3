"""What all tests share."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as `one_thread` below; read when NumPy is imported
os.environ.setdefault("STRANDCLI_COMPILERS", "1")  # none compiles ahead: all cores have tests to run

import numba
import pytest
from hypothesis import settings

from cli_runs import TINY, Runner

# compiling may fall into any example, so none is timed; failures can be repeated from what is printed. `make test` has
# the same examples each time, so that what fails is of the change; `make all` asks for more, and draws them anew
FEW = 30
EXAMPLES = int(os.environ.get("STRANDCLI_TEST_EXAMPLES", FEW))
settings.register_profile(
    "strandcli", deadline=None, print_blob=True, max_examples=EXAMPLES, derandomize=EXAMPLES == FEW
)
settings.load_profile("strandcli")


@pytest.fixture(autouse=True)
def one_thread() -> None:
    """Tests run side by side: threads that wait for each other's turn would take ten times as long. Whatever is about
    threads asks for them."""
    numba.set_num_threads(1)


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Runner:
    """The command line, in a folder of its own with a small preset."""
    (tmp_path / "tiny.yaml").write_text(TINY, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("STRANDCLI_DEBUG", raising=False)
    return Runner(tmp_path, capsys)


DRAWING = ("draw/", "run/", "study/test_picture", "study/test_golden")
MOVING = ("simulate/", "stress/", "study/")
BOTH = ("stress/test_inputs", "study/test_cli")


def place(scope: str) -> tuple[int, str]:
    """Where a file of tests stands between those that draw and those that simulate."""
    name = scope.removeprefix("tests/")
    drawing = name.startswith(DRAWING)
    return 0 if drawing else 2 if name.startswith(MOVING) and not name.startswith(BOTH) else 1, scope


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Half of the processes begin with the files that draw, half with those that simulate, and they meet in between:
    on an empty cache each compiles kernels that the other one then finds there, where both would compile most twice."""
    from xdist.scheduler.loadfile import LoadFileScheduling

    class FromBothEnds(LoadFileScheduling):
        def _assign_work_unit(self, node: Any) -> None:
            last = self.nodes.index(node) % 2 == 1
            scope = sorted(self.workqueue, key=place)[-1 if last else 0]
            self.workqueue.move_to_end(scope, last=False)
            super()._assign_work_unit(node)

    return FromBothEnds(config, log) if config.getvalue("dist") == "loadfile" else None
