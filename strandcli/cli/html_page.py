"""report.html at the end of a run, however it ends."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import StrandError

if TYPE_CHECKING:
    from ..scene.model import Scene

no_html = click.option("--no-html", is_flag=True, help="Write no report.html.")


class HtmlPage:
    """The page of one run of a scene into a folder."""

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

    def write_last(self) -> None:
        """Write it from report.json, which a run that has failed leaves too; what ended the run says more than what
        might go wrong here."""
        from ..output.report import read_report

        with suppress(StrandError, OSError):
            data = read_report(self._directory)
            if data is not None and data.keys() >= {"preset", "status", "strandcli"}:
                self.write(data)


@contextmanager
def of_failed(page: HtmlPage | None) -> Iterator[None]:
    """A block after which the page is written if it raises."""
    try:
        yield
    except BaseException:
        if page is not None:
            page.write_last()
        raise
