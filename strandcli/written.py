"""Python modules that strandcli writes for a scene into the cache folder: compiled and cached as any other."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import sys
import tempfile
from pathlib import Path
from typing import Any


def module_of(text: str, prefix: str, folder: Path) -> Any:
    """The module with this text, named by the prefix and the text's hash; written to ``folder`` unless it is there."""
    name = f"{prefix}_{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    path = folder / f"{name}.py"
    if not path.exists() or path.read_bytes() != text.encode():  # bytes: a damaged file need not be text
        handle, temporary = tempfile.mkstemp(dir=folder, suffix=".py.part")
        with open(handle, "wb") as out:
            out.write(text.encode())
        os.replace(temporary, path)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    module: Any = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # a cached kernel imports its module by name when it is loaded
    exec(compile(text, path, "exec"), module.__dict__)  # not by the loader, whom damaged bytecode beside it would stop
    return module
