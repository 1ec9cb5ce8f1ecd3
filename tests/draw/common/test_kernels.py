"""Kernels compute in single precision throughout: one stray integer or literal would turn whole loops to double."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numba import typeof

from strand_kit import scene_of, solver_of
from strandcli.constants import W
from strandcli.draw.common.kernels import surface_batch
from strandcli.draw.common.kernels.view_columns import DepthSlope
from strandcli.draw.coverage.kernels import cells, fragments
from strandcli.draw.coverage.kernels import ribbon as coverage_ribbon
from strandcli.draw.fibre.kernels import chiang, dual, marschner
from strandcli.draw.film.kernels import film
from strandcli.draw.geometry.kernels import curves, piece_counts, ribbon, tangents
from strandcli.draw.lighting.kernels import light, shade_strands
from strandcli.draw.lighting.kernels.inputs import StrandColour
from strandcli.draw.shadows.kernels import (
    minmax,
    penumbra,
    percentage_closer,
    solid_shadows,
    splats,
    strand_shadows,
)
from strandcli.draw.solids.kernels import rays
from strandcli.draw.view.kernels import project
from strandcli.draw.zbuffer.kernels import lines, raster
from strandcli.jit import function
from strandcli.simulate.rules import Moment
from strandcli.solids import Solids
from strandcli.solids.kernels import box, capsule, plane, sphere
from tests.run.test_pipeline_extremes import EVERYTHING

ONE = np.float32(1)
ROW = np.ones(24, np.float32)
TABLE = np.ones((4, 24), np.float32)
KEYS = np.zeros(64, np.uint64)
WORK = np.ones(project.ROWS * project.ROW, np.float32)
LIT = np.ones(surface_batch.ROWS * W, np.float32)
BLOCKS = np.ones((1, 5, 3 * W), np.float32)
PLACES = np.zeros(4, np.int64)
SOLIDS = Solids(TABLE, TABLE, TABLE, TABLE)
RAY = penumbra.LightRay(*[ONE] * 7)

SLOPE = DepthSlope(*4 * (ONE,))
RIBBON = ribbon.Ribbon(True, *16 * (ONE,))
NUMBERS = np.zeros(64, np.int32)
TILE = cells.Target(0, 8, 0, 8, 4, ROW, NUMBERS, NUMBERS, ONE, ROW, ROW, NUMBERS, ROW, ROW)
TEXEL_STEPS = minmax.Steps(NUMBERS, *4 * (np.zeros(64, np.int64),), *2 * (ROW,))
STEPS = lines.Steps(*4 * (NUMBERS,), *2 * (np.zeros(64, np.int64),), *2 * (ROW,))
STRANDS = fragments.Strands(PLACES, TABLE, ROW, ONE, SLOPE, 1)
CALLS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "tangents": (tangents.find_tangents, (BLOCKS, 0, None, True, ROW)),
    "pieces": (
        piece_counts.count_pieces,
        (BLOCKS, 0, None, ROW, piece_counts.Splitting(8, ONE, 0, ROW, True), WORK),
    ),
    "bezier": (curves.bezier, (ONE,) * 5),
    "cross_near_plane": (project.cross_near_plane, (TABLE, ROW, 1, 0, 4, ONE, ONE, ONE)),
    "to_screen": (project.to_screen, (WORK, 8, ROW)),
    "widen": (project.widen, (WORK, 8, 0, ROW, ONE, ONE, ONE, ONE, None)),
    "line": (lines.draw_line, (1, STEPS, lines.Window(0, 8, 8), np.uint64(1), KEYS)),
    "lines": (lines.prepare, (TABLE, 0, 1, lines.Window(0, 8, 8), STEPS)),
    "ribbon": (raster.draw_ribbon, (TABLE, 1, 0, 4, ONE, ONE, SLOPE, lines.Window(0, 8, 8), np.uint64(1), KEYS)),
    "draw across": (
        raster.draw_across,
        (RIBBON, raster.Sides(True, True, *4 * (ONE,), 1, 8), 1, SLOPE, np.uint64(1), KEYS),
    ),
    "rows of a cell": (
        coverage_ribbon.rows_of_cell, (RIBBON, coverage_ribbon.Band(*8 * (ONE,)), 1, coverage_ribbon.Cells(0, 8, 0, 8)),
    ),
    "cover listed": (
        coverage_ribbon.cover_listed, (WORK, 8, RIBBON, coverage_ribbon.Band(*8 * (ONE,)), STRANDS, TILE),
    ),
    "add listed": (coverage_ribbon.add_listed, (WORK, 8, 1, 0, TILE, 0)),
    "shadow lines": (minmax.prepare, (TABLE, 0, 1, 0, 8, 8, ONE, ONE, TEXEL_STEPS)),
    "shadow line": (minmax.line, (1, TEXEL_STEPS, 0, 8, 8, np.ones((64, 2), np.float32))),
    "falloff": (minmax.falloff, (ONE, ONE, ONE)),
    "locate": (percentage_closer.locate, (LIT, 1, TABLE, 1, TABLE, 1, 8)),
    "percentage closer": (
        percentage_closer.transmittance,
        (LIT, 1, TABLE, 1, np.ones((4, 3), np.float32),
         strand_shadows.ShadowArrays(TABLE, np.ones(1024, np.float32), PLACES, PLACES + 4, TABLE)),
    ),
    "splats in an opacity map": (
        splats.add,
        (np.ones(splats.ROOM, np.float32), 3, lines.Window(0, 8, 8),
         splats.OpacityMap(np.ones((16, 4), np.float32), ONE, 5, np.ones(512, np.float32))),
    ),
    "dual angles": (dual.angles, (*3 * (3 * (ONE,),), 64)),
    "dual lobes": (dual.lobes, (ONE,) * 8),
    "dual scattered": (dual.scattered, (*(ONE,) * 4, 2 * (ONE,), 5 * (ONE,), 2 * (ONE,), ONE)),
    "around": (light.around, (np.ones((2, 9, 3), np.float32), 0, 0, ONE, ONE, ONE)),
    "toward": (light.toward, (TABLE, 1, 3 * (ONE,))),
    "colours": (shade_strands.load_colours, (StrandColour(ROW, np.ones((3, 3, 6), np.float32), ONE), LIT, 3)),
    "sphere": (sphere.meet, (TABLE, 1, *[ONE] * 6)),
    "capsule": (capsule.meet, (TABLE, 1, *[ONE] * 6)),
    "plane": (plane.meet, (TABLE, 1, *[ONE] * 6)),
    "box": (box.meet, (TABLE, 1, *[ONE] * 6)),
    "normal": (rays.normal, (SOLIDS, 1, ONE, ONE, ONE)),
    "penumbra of a box": (penumbra.box, (TABLE, 1, RAY, ONE, ONE)),
    "lit solids": (rays.visibility, (SOLIDS, *[ONE] * 8)),
    "soft shadows": (solid_shadows.soft_shadows, (LIT, 1, TABLE, 1, SOLIDS, ONE)),
    "encode": (film.encode, (np.ones(8, np.float32), ONE, ONE)),
    "marschner": (
        marschner.highlights,
        (LIT, 1, TABLE, 0, marschner.MarschnerArrays(ROW, *[np.ones((3, 3, k), np.float32) for k in (8, 2)])),
    ),
    "marschner's lobes": (marschner.longitudinal, (*3 * (3 * (ONE,),), ROW)),
    "chiang": (
        chiang.highlights,
        (LIT, 1, TABLE, 0, chiang.ChiangArrays(ROW, *[np.ones((3, 3, k), np.float32) for k in (12, 4)])),
    ),
    "chiang's lobes": (chiang.longitudinal, (*3 * (3 * (ONE,),), ROW)),
    "kajiya_diffuse": (dual.kajiya_diffuse, (ONE,) * 6),
}  # fmt: skip


def doubles(kernel: Any) -> list[str]:
    """Lines of Numba's typed listings in which arithmetic gives a double."""
    lines = [line for one in kernel.overloads.values() for line in str(one.type_annotation).splitlines()]
    assert lines
    return [line.strip() for line in lines if "$binop" in line and line.rstrip().endswith(":: float64")]


@pytest.mark.long
@pytest.mark.parametrize("name", CALLS)
def test_no_kernel_of_drawing_slips_into_double_precision(name: str) -> None:
    kernel, arguments = CALLS[name]
    kernel.compile(tuple(typeof(one) for one in arguments))  # some of them cannot be called from Python
    assert doubles(kernel) == []


def test_no_rule_slips_into_double_precision() -> None:
    scene = scene_of(EVERYTHING)
    solver = solver_of(scene)
    rows = solver.positions[0]
    moment = Moment(0.1, 0.1, scene)
    step: Any = solver._step  # type: ignore[attr-defined]
    scope = step.py_func.__globals__
    for number, one in enumerate(solver.passes):  # type: ignore[attr-defined]
        kernel: Callable[..., Any] = scope[f"pass_{number}"]
        p = one.prepare(moment)
        if one.stage == "root":
            kernel(rows[0], rows[1], rows[0].copy(), rows[1].copy(), p)
        elif one.stage == "lane":
            place = (ONE, ONE, ONE)
            kernel(place, place, place, ONE, tuple(p[1] if one.per_particle else p))
        else:
            kernel(rows[2], rows[1], rows[0], rows[1], solver.lengths[0], p, 1, 5)
        assert doubles(kernel) == [], one.function
    assert number > 8


def test_a_slip_would_be_seen() -> None:
    kernel = function(twice)
    kernel(ONE)
    assert doubles(kernel)


def twice(x: Any) -> Any:
    """An integer too many."""
    two = 2
    return x * two
