"""The command that installs an optional package: right for pipx, uv, an environment and the system's Python."""

from __future__ import annotations

import sys
import sysconfig
import tomllib
from pathlib import Path

import pytest

from strandcli.common import extras

ROOT = Path(__file__).resolve().parents[2]


def test_requirements_are_those_of_the_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    declared = project["optional-dependencies"]
    assert {name: [one] for name, one in extras.REQUIREMENTS.items()} == {
        name: declared[name] for name in declared if name != "check"
    }


@pytest.mark.parametrize(
    ("there", "pip", "which", "command"),
    [
        ("", True, None, "{home}/bin/python -m pip install 'OpenEXR>=3.3'"),
        ("", True, "{home}/bin/pip", "pip install 'OpenEXR>=3.3'"),
        ("", True, "/elsewhere/pip", "{home}/bin/python -m pip install 'OpenEXR>=3.3'"),
        ("", False, None, "uv pip install --python {home}/bin/python 'OpenEXR>=3.3'"),
        ("pipx_metadata.json", True, None, "pipx inject strandcli 'OpenEXR>=3.3'"),
        ("EXTERNALLY-MANAGED", True, None, "{home}/bin/python -m pip install --break-system-packages 'OpenEXR>=3.3'"),
    ],
)
def test_the_command_is_that_of_the_installation(
    there: str, pip: bool, which: str | None, command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of an environment; and of a system's Python, which has no prefix of its own, that refuses pip."""
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setattr(sys, "base_prefix", str(tmp_path) if there == "EXTERNALLY-MANAGED" else "/usr")
    monkeypatch.setattr(sys, "executable", str(tmp_path / "bin" / "python"))
    monkeypatch.setattr(sysconfig, "get_path", lambda name: str(tmp_path))
    monkeypatch.setattr(extras.shutil, "which", lambda name: which and which.format(home=tmp_path))
    monkeypatch.setattr(extras.importlib.util, "find_spec", lambda name: object() if pip else None)
    if there:
        (tmp_path / there).write_text("")
    assert extras.install("exr") == command.format(home=tmp_path)
