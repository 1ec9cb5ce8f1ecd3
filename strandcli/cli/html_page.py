"""report.html at the end of a run, however it ends."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import click

from ..errors import StrandError

if TYPE_CHECKING:
    from ..scene.model import Scene

no_html = click.option("--no-html", is_flag=True, help="Write no report.html.")


class HtmlPage:
    """The page of one run of a scene into a folder; a block of it that fails writes the page, too."""

    def __init__(self, directory: Path, scene: Scene, overwrite: bool) -> None:
        """Raises ``UsageError`` where a file of somebody else's is in its place, unless that may be replaced."""
        from ..html_report import page, run

        self._directory, self._scene = directory, scene
        if not overwrite:
            page.require_own(directory / run.FILE)

    def write(self, data: dict[str, Any], made: Sequence[Path] = ()) -> None:
        """Write it from the report's ``data``, with the animations that were ``made``."""
        from ..html_report import run
        from ..scene import dump

        run.write(self._directory, data, dump(self._scene), made)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Write it after a failure from report.json, which a run that has failed leaves too; what ended the run says
        more than what might go wrong here."""
        from ..output.report import read_report

        if kind is not None:
            with suppress(StrandError, OSError):
                data = read_report(self._directory)
                if data is not None and data.keys() >= {"preset", "status", "strandcli"}:
                    self.write(data)
