"""Optional packages, and the command that installs one beside this strandcli, however that was installed."""

from __future__ import annotations

import importlib.util
import shlex
import shutil
import sys
import sysconfig
from pathlib import Path

REQUIREMENTS = {
    "exr": "OpenEXR>=3.3",
    "usd": "usd-core>=24.11",
    "dask": "distributed>=2024.1",
    "video": "imageio-ffmpeg>=0.5",
}
"""By extra of pyproject.toml."""


def install(extra: str) -> str:
    """The command that installs what an extra needs into the environment of this process.

    It names the package itself, not ``strandcli[exr]``: that holds for a checkout, which no index has, too."""
    wanted = shlex.quote(REQUIREMENTS[extra])
    if Path(sys.prefix, "pipx_metadata.json").exists():
        return f"pipx inject strandcli {wanted}"
    python = shlex.quote(sys.executable)
    if importlib.util.find_spec("pip") is None:
        return f"uv pip install --python {python} {wanted}"
    found = shutil.which("pip")
    pip = "pip" if found and Path(found).parent == Path(sys.executable).parent else f"{python} -m pip"
    managed = sys.prefix == sys.base_prefix and Path(sysconfig.get_path("stdlib"), "EXTERNALLY-MANAGED").exists()
    return f"{pip} install {'--break-system-packages ' if managed else ''}{wanted}"
