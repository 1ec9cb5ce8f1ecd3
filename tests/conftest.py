"""What all tests share."""

from __future__ import annotations

from hypothesis import settings

# compiling may fall into any example, so none is timed; failures can be repeated from what is printed
settings.register_profile("strandcli", deadline=None, print_blob=True)
settings.load_profile("strandcli")
