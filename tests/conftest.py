"""What all tests share."""

from __future__ import annotations

import numba
import pytest
from hypothesis import settings

# compiling may fall into any example, so none is timed; failures can be repeated from what is printed
settings.register_profile("strandcli", deadline=None, print_blob=True)
settings.load_profile("strandcli")


@pytest.fixture(autouse=True)
def one_thread() -> None:
    """Tests run side by side: threads that wait for each other's turn would take ten times as long. Whatever is about
    threads asks for them."""
    numba.set_num_threads(1)
