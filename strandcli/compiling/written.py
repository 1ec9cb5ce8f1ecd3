"""Python modules that strandcli writes for a scene into the cache folder: compiled and cached as any other."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

from .folder import cache, text_hash


def module_of(text: str, prefix: str, folder: Path) -> Any:
    """The module with this text, named by the prefix and the text's hash; written to ``folder`` unless it is there."""
    name = f"{prefix}_{text_hash(text.encode())}"
    path = folder / f"{name}.py"
    try:
        kept = path.is_file() and path.read_bytes() == text.encode()  # bytes: a damaged file need not be text
    except OSError:
        kept = False
    kept = kept or cache.write(path, text.encode())
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    module: Any = importlib.util.module_from_spec(spec)
    if not kept:
        module.__strandcli_text__ = text.encode()  # the key of its kernels follows from it
    sys.modules[name] = module  # a cached kernel imports its module by name when it is loaded
    exec(compile(text, path, "exec"), module.__dict__)  # not by the loader, whom damaged bytecode beside it would stop
    return module
