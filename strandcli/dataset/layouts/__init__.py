"""Layouts, a file each, found by its name. A new one is a file here, a test beside those in `tests/dataset`, and a
section in docs/dataset.md; other packages name theirs under the entry point ``strandcli.layouts``."""
