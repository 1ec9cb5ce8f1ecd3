"""The command that installs an optional package: right for pipx, uv, an environment and the system's Python."""

from __future__ import annotations

import shlex
import sys
import sysconfig
import tomllib
from pathlib import Path

import pytest

from strandcli.common import extras

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of an environment with pip that is not activated."""
    (tmp_path / "bin").mkdir()
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setattr(sys, "base_prefix", "/usr")
    monkeypatch.setattr(sys, "executable", str(tmp_path / "bin" / "python"))
    monkeypatch.setattr(extras.shutil, "which", lambda name: None)
    monkeypatch.setattr(extras.importlib.util, "find_spec", lambda name: object())
    return tmp_path


def test_requirements_are_those_of_the_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    declared = project["optional-dependencies"]
    assert {name: [one] for name, one in extras.REQUIREMENTS.items()} == {
        name: declared[name] for name in declared if name != "check"
    }


def test_pip_of_an_activated_environment_is_named_shortly(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert extras.install("exr") == f"{home}/bin/python -m pip install 'OpenEXR>=3.3'"
    monkeypatch.setattr(extras.shutil, "which", lambda name: str(home / "bin" / "pip"))
    assert extras.install("exr") == "pip install 'OpenEXR>=3.3'"
    monkeypatch.setattr(extras.shutil, "which", lambda name: "/elsewhere/pip")
    assert extras.install("exr").startswith(f"{home}/bin/python -m pip")


def test_pipx_injects(home: Path) -> None:
    (home / "pipx_metadata.json").write_text("{}")
    assert extras.install("dask") == "pipx inject strandcli 'distributed>=2024.1'"


def test_uv_installs_where_the_environment_has_no_pip(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras.importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(sys, "executable", "/a b/python")
    assert shlex.split(extras.install("usd")) == ["uv", "pip", "install", "--python", "/a b/python", "usd-core>=24.11"]


def test_a_system_that_refuses_pip_is_asked_as_it_wants(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (home / "EXTERNALLY-MANAGED").write_text("")
    monkeypatch.setattr(sysconfig, "get_path", lambda name: str(home))
    assert "--break-system-packages" not in extras.install("exr")
    monkeypatch.setattr(sys, "base_prefix", str(home))
    assert extras.install("exr").endswith("pip install --break-system-packages 'OpenEXR>=3.3'")
