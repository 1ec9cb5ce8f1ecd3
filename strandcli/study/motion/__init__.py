"""Where strands are over time: a preset's runs against their limit, the solvers that are measured, and the foil."""

from __future__ import annotations

from .experiment import AXIS, Motion

__all__ = ["AXIS", "Motion"]
