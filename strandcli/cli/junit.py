"""Results of `strandcli golden check` as JUnit XML, which CI systems show case by case."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from .say import printable

if TYPE_CHECKING:
    from ..study.golden import Result


def junit(results: Sequence[Result], seconds: Sequence[float]) -> bytes:
    """The XML: a test case an image, with its seconds; a failure says why and names the picture of the difference."""
    failed = sum(not result.matches for result in results)
    counts = {"tests": str(len(results)), "failures": str(failed), "errors": "0", "time": f"{sum(seconds):.3f}"}
    root = ElementTree.Element("testsuites")
    suite = ElementTree.SubElement(root, "testsuite", {"name": "strandcli golden check", **counts})
    for result, took in zip(results, seconds, strict=True):
        name = {"classname": "golden", "name": result.entry.name, "time": f"{took:.3f}"}
        case = ElementTree.SubElement(suite, "testcase", name)
        if not result.matches:
            failure = ElementTree.SubElement(case, "failure", {"message": printable(result.words)})
            failure.text = printable(str(result.difference or ""))
    ElementTree.indent(root)
    return ElementTree.tostring(root, "utf-8", xml_declaration=True)
