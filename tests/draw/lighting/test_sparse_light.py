"""Light on solids at every second pixel of every second row: which pixels take it from there, and what that changes."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli import load
from strandcli.draw import transmittance
from strandcli.draw.common.kernels.keys import EMPTY, FIRST, LOW, SHIFT
from strandcli.draw.lighting.kernels import lattice
from strandcli.draw.solids.solids import NONE
from strandcli.frame_renderer import FrameRenderer
from strandcli.stages import RunOptions, SimulationStage

WIDTH, HEIGHT = 23, 17
ALL, LIT, COATED = int(lattice.ALL), int(lattice.LIT), int(lattice.COATED)


@pytest.mark.parametrize(("down", "right"), [(0, 0), (1, 2), (2, 3), (3, 1)])
@pytest.mark.parametrize("rows", [(0, HEIGHT), (5, 12)])
def test_pixels_between_alike_ones_take_their_light(down, right, rows):
    """Against a twin that looks at one pixel after the other."""
    rng = np.random.default_rng(7)
    solid = rng.integers(0, 12, (HEIGHT, WIDTH)) == 0
    near = np.uint64(LOW - np.uint64(np.float32(1.0).view(np.uint32))) << SHIFT
    keys = np.where(rng.integers(0, 15, (HEIGHT, WIDTH)) == 0, EMPTY, near + FIRST + solid.astype(np.uint64))
    hidden = (rng.integers(0, 4, (HEIGHT, WIDTH)) == 0).astype(np.uint8)
    some = np.array([0.5, 0.5 + 0.9 * lattice.ALIKE, 0.9], np.float32)
    values = rng.choice(some, (HEIGHT, WIDTH, 1, 3), p=[0.9, 0.08, 0.02])
    values[rng.integers(0, 30, values.shape) == 0] = lattice.UNKNOWN
    values = np.concatenate([values, radiance()], 2)
    frame = lattice.Frame(*rows, WIDTH, down, right)
    asked = np.full((HEIGHT, WIDTH), 9, np.uint8)
    lattice.ask(keys.reshape(-1), hidden.reshape(-1), frame, asked.reshape(-1))
    own = range(max(rows[0] - 1, 0), min(rows[1] + 1, HEIGHT))
    spread_wanted(keys, values_wanted := values.copy(), asked_wanted := asked.copy(), own, frame)
    lattice.spread(keys.reshape(-1), np.ones(32, np.float32), frame, asked.reshape(-1), values)
    np.testing.assert_array_equal(asked, asked_wanted)
    np.testing.assert_allclose(values, values_wanted, rtol=1e-6)
    assert np.count_nonzero(asked == lattice.SPREAD) > 3
    found = hidden.copy()
    lattice.smooth_blocks(keys.reshape(-1), NONE, asked.reshape(-1), values, frame, found.reshape(-1))
    at_once = np.count_nonzero(found == lattice.SMOOTH)
    lattice.choose(
        keys.reshape(-1), np.zeros(32, np.float32), NONE, asked.reshape(-1), values, frame, found.reshape(-1)
    )
    wanted, needed = hidden.copy(), set()
    for y in range(*rows):
        for x in range(WIDTH):
            if hidden[y, x] or keys[y, x] == EMPTY:
                continue
            down_to, right_to = min(y + 2, HEIGHT), min(x + 2, WIDTH)
            near = [(j, i) for j in range(max(y - 1, 0), down_to) for i in range(max(x - 1, 0), right_to)]
            needed |= {(j, i) for j, i in near if on_lattice(j, i, frame) and keys[j, i] == keys[y, x]}
            about = corners(y, x, frame)
            if not (0 < x < WIDTH - 1) or any(not 0 <= j < HEIGHT or keys[j, i] != keys[y, x] for j, i in about):
                continue
            light = np.array([values[(j + down) // 2, (i + right) // 2, 0] for j, i in about])
            if light.min() >= 0 and np.all(np.ptp(light, axis=0) <= lattice.ALIKE):
                known = np.array([values[(j + down) // 2, (i + right) // 2] for j, i in about])
                wanted[y, x] = lattice.SMOOTH if even(known) else lattice.BETWEEN
    there = {(int(j), int(i)) for j, i in np.argwhere((asked != 0) & (asked != 9))}
    assert {place for place in there if place[0] in own and not coarse(*place, frame)} == {
        place for place in needed if not coarse(*place, frame)
    }
    assert needed <= there
    np.testing.assert_array_equal(found, wanted)
    counts = [np.count_nonzero(found == one) for one in (lattice.BETWEEN, lattice.SMOOTH)]
    assert min(counts) > 2
    assert sum(counts) > 20
    assert 0 < at_once < counts[1]


def spread_wanted(keys, values, asked, rows, frame):
    """`lattice.spread` of a flat surface, one pixel after the other."""
    for y in rows:
        for x in range(2, WIDTH - 2):
            if asked[y, x] != lattice.FINE:
                continue
            b, a = (y + frame.down) % 4, (x + frame.right) % 4
            about = [(y + j, x + i) for j in (-b, b) for i in (-a, a)]
            if not all(0 <= j < HEIGHT and 0 <= i < WIDTH and keys[j, i] == keys[y, x] for j, i in about):
                continue
            assert all(asked[place] == lattice.COARSE for place in about)
            light = np.array([values[(j + frame.down) // 2, (i + frame.right) // 2, 0] for j, i in about])
            if light.min() >= 0 and np.all(np.ptp(light, axis=0) <= lattice.CLOSELY):
                known = np.array([values[(j + frame.down) // 2, (i + frame.right) // 2] for j, i in about])
                values[(y + frame.down) // 2, (x + frame.right) // 2] = known.mean(0)
                if not even(known):
                    values[(y + frame.down) // 2, (x + frame.right) // 2, 1 + LIT, 0] = lattice.UNKNOWN
                asked[y, x] = lattice.SPREAD


def radiance():
    """(HEIGHT, WIDTH, `ALL`, 3) in the lattice, of which little is unknown or differs."""
    rng = np.random.default_rng(8)
    found = np.empty((HEIGHT, WIDTH, ALL, 3), np.float32)
    found[:, :, LIT] = rng.choice([0.5, 0.52, 0.7], (HEIGHT, WIDTH, 3), p=[0.9, 0.08, 0.02])
    found[:, :, COATED] = rng.choice([0.03, 0.032, 0.05], (HEIGHT, WIDTH, 3), p=[0.9, 0.08, 0.02])
    found[rng.integers(0, 30, (HEIGHT, WIDTH)) == 0, LIT, 0] = lattice.UNKNOWN
    return found


def even(known):
    """Whether radiance at so many places of the lattice (places, lights + `ALL`, 3) is known, and nearly the same."""
    light, coat = known[:, 1 + LIT], known[:, 1 + COATED]
    if light[:, 0].min() < 0:
        return False
    most = max(coat.max(), lattice.FAINT * light.max())
    return np.ptp(light, axis=0).max() <= lattice.ALIKE * light.max() and np.ptp(coat, axis=0).max() <= (
        lattice.ALIKE * most
    )


def coarse(y, x, frame):
    """Whether a pixel is one of those four apart."""
    return (y + frame.down) % 4 == 0 and (x + frame.right) % 4 == 0


def on_lattice(y, x, frame):
    """Whether a pixel is one of the lattice."""
    return (y + frame.down) % 2 == 0 and (x + frame.right) % 2 == 0


def corners(y, x, frame):
    """The pixels of the lattice about a pixel."""
    j, i = (y + frame.down) % 2, (x + frame.right) % 2
    return {(y + b, x + a) for b in (-j, j) for a in (-i, i)}


@pytest.fixture(scope="module")
def draw():
    """Draws the first frame of `fur`, few strands, linear."""
    settings = {"image.size": [160, 120], "time.preroll": 0, "children.count": 4}

    def drawn(**more):
        scene = load("fur", settings=settings | more)
        moved = SimulationStage(scene, range(1, 2), None, RunOptions())
        return FrameRenderer(moved)(moved.begin(1)).image.astype(float)

    return drawn


def test_picture_is_nearly_that_with_light_at_every_pixel(draw, monkeypatch):
    sparse = draw()
    monkeypatch.setattr(transmittance, "is_costly", lambda lighting: False)
    exact = draw()
    error = np.sqrt(np.mean((sparse - exact) ** 2)) / exact.mean()
    assert 0 < error < 0.003


def test_lattice_is_where_it_is_in_the_whole_picture(draw):
    """A crop window at an odd place has the pixels of the whole picture, but where rounding tells, and nearly so at its
    border, where pixels of the lattice are missing."""
    x, y, width, height = 61, 43, 50, 41
    part, whole = draw(**{"image.crop": [x, y, width, height]}), draw()[y : y + height, x : x + width]
    different = np.abs(part - whole).max(-1)
    assert different.max() <= 2
    assert different[3:-3, 3:-3].max() <= 1
    assert np.count_nonzero(different[3:-3, 3:-3]) <= 3
