"""Settings of the documentation site, which `make docs` builds. It reads no module of strandcli."""

import tomllib
from pathlib import Path

with open(Path(__file__).parents[1] / "pyproject.toml", "rb") as file:
    _project = tomllib.load(file)["project"]

project = _project["name"]
author = "the strandcli authors"
version = release = _project["version"]

extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
exclude_patterns = ["gallery/*"]

html_theme = "furo"
html_title = f"strandcli {version}"
html_show_sphinx = False
html_copy_source = False
