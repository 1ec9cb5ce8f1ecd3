"""Adds to a wheel the pack of kernels that STRANDCLI_PACK names: it is for one Python and one system then."""

import os
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class PackHook(BuildHookInterface):
    """Found by its base class."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Called before a wheel is built."""
        pack = os.environ.get("STRANDCLI_PACK")
        if pack and version == "standard":
            build_data["force_include"][str(Path(pack).absolute())] = "strandcli/kernels.pack"
            build_data["pure_python"], build_data["infer_tag"] = False, True
