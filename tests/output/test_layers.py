"""Layers as files: exact round trips, what PNGs show, and files that are none."""

from __future__ import annotations

import io
import json
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from cli_runs import TINY, Runner
from strandcli.errors import UsageError
from strandcli.output import png
from strandcli.output.layers import exr_channels, layer_files, require_exr, viewable, write_layers
from strandcli.scene.model import AOVS


def read_layer(path: Path) -> np.ndarray:
    """The array of a file, which is named as the file is up to its number."""
    with np.load(path, allow_pickle=False) as data:
        return data[path.stem.rpartition("_")[0]]


SHAPES = st.tuples(st.integers(1, 9), st.integers(1, 9))
FLOATS = st.floats(allow_nan=False, width=32)


@settings(max_examples=50, deadline=None)
@given(st.data(), SHAPES)
def test_what_is_written_is_read_again_bit_for_bit(data: st.DataObject, shape: tuple[int, int]) -> None:
    layers = {
        "depth": data.draw(hnp.arrays(np.float32, shape, elements=FLOATS)),
        "strand_id": data.draw(hnp.arrays(np.int32, shape, elements=st.integers(-2, 2**31 - 1))),
        "tangent": data.draw(hnp.arrays(np.float32, (*shape, 3), elements=st.floats(-1, 1, width=32))),
    }
    with tempfile.TemporaryDirectory() as folder:
        write_layers(Path(folder), 7, layers)
        assert sorted(path.name for path in Path(folder).iterdir()) == sorted(layer_files(7, list(layers), False))
        for name, array in layers.items():
            found = read_layer(Path(folder) / f"{name}_0007.npz")
            assert found.dtype == array.dtype
            np.testing.assert_array_equal(found, array)


@settings(max_examples=50, deadline=None)
@given(st.data(), st.sampled_from([(), (3,)]), SHAPES)
def test_sixteen_bits_survive_png(data: st.DataObject, colour: tuple[int, ...], shape: tuple[int, int]) -> None:
    """Rebuilt by hand, for Pillow reads colours of eight bits only."""
    image = data.draw(hnp.arrays(np.uint16, (*shape, *colour)))
    content = b"".join(png.encode(image))
    with Image.open(io.BytesIO(content)) as opened:
        opened.load()
        assert opened.size == shape[::-1]
        if not colour:
            np.testing.assert_array_equal(np.asarray(opened).astype(np.uint16), image)
        else:
            np.testing.assert_allclose(np.asarray(opened).astype(int), image >> 8, atol=1)


def test_what_the_pngs_show() -> None:
    depth = np.array([[1, 2, 3, np.inf]], np.float32)
    shown, text = viewable("depth", depth)
    assert shown.tolist() == [[65535, 32768, 1, 0]]
    assert text == {"range": "1 3"}
    assert viewable("depth", np.full((1, 2), np.inf, np.float32))[0].tolist() == [[0, 0]]
    assert viewable("mask", np.float32([[0, 0.5, 1]]))[0].tolist() == [[0, 32768, 65535]]
    assert viewable("tangent", np.float32([[[-1, 0, 1]]]))[0].tolist() == [[[0, 32768, 65535]]]
    colours, _ = viewable("orientation", np.float32([[0, np.pi / 2, -1]]))
    assert colours.tolist() == [[[255, 64, 64], [0, 191, 191], [0, 0, 0]]]
    ids, _ = viewable("strand_id", np.arange(-2, 500, dtype=np.int32)[None])
    assert len({tuple(one) for one in ids[0].tolist()}) > 490
    assert ids[0, 1].tolist() == [0, 0, 0]


def test_the_command_writes_layers_and_keeps_them_on_resume(run: Runner) -> None:
    asked = ",".join(AOVS)
    run.fine("render", "tiny.yaml", "-f", "1-2", "-o", "out", "--aov", asked, "--quiet")
    names = {path.name for path in Path("out").iterdir()}
    expected = {name for frame in (1, 2) for name in layer_files(frame, AOVS, False)}
    assert names == expected | {"frame_0001.png", "frame_0002.png", "report.html", "report.json"}
    depth, ids = (read_layer(Path("out") / f"{name}_0002.npz") for name in ("depth", "strand_id"))
    assert depth.shape == ids.shape == (48, 64)
    assert (np.isfinite(depth) == (ids != -1)).all()
    assert "already has" in run.refused("render", "tiny.yaml", "-f", "1", "-o", "out", "--aov", "depth")
    # a picture without its layers is drawn again; one with them is kept
    Path("out/depth_0001.npz").unlink()
    again = run.fine("render", "tiny.yaml", "-f", "1-2", "-o", "out", "--aov", asked, "--resume", "--quiet", "--json")
    kept = [entry.get("kept", False) for entry in json.loads(again.out)["frames"]]
    assert kept == [False, True]
    assert Path("out/depth_0001.npz").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--aov", "depht"], "Invalid value for '--aov': unknown layer 'depht'; did you mean 'depth'?"),
        (["--aov", "depth,depth"], "the layer 'depth' is listed twice"),
        (["--set", "image.crop=40x40+30+0"], "the window 40x40+30+0 reaches beyond the picture of 64x48"),
        (["--set", "image.crop=[1, 2, 3]"], "must be a part of the picture"),
        (["--set", "camera.shutter=1.5"], ": must be a number of at least 0 and of at most 1"),
        (["--set", "camera.aperture=1", "--set", "camera.kind=orthographic"], "an orthographic camera has no lens"),
    ],
)
def test_bad_input_is_one_clear_line(run: Runner, options: list[str], message: str) -> None:
    assert message in run.refused("render", "tiny.yaml", "-f", "1", "-o", "out", *options)
    assert not Path("out").exists()


def test_panels_have_no_layers(run: Runner) -> None:
    Path("two.yaml").write_text(TINY + "panels: [{label: one}, {label: two}]\n")
    for option in (["--aov", "depth"], ["--exr"]):
        done = run.refused("render", "two.yaml", "-f", "1", "-o", "out", *option)
        assert "a preset of several panels has no layers" in done


def test_without_the_extra_exr_tells_how_to_install_it(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    assert run.refused("render", "tiny.yaml", "-f", "1", "-o", "out", "--exr").endswith(" 'OpenEXR>=3.3'")
    assert not Path("out").exists()


def test_strands_that_a_float_cannot_number_are_refused() -> None:
    pytest.importorskip("OpenEXR", minversion=None)
    with pytest.raises(UsageError, match="number at most 16,777,216 strands"):
        require_exr((1 << 24) + 1)


def test_channels_of_exr_hold_what_the_layers_do() -> None:
    layers = {
        "depth": np.float32([[1, np.inf]]),
        "strand_id": np.int32([[-1, (1 << 24) - 1]]),
        "tangent": np.arange(6, dtype=np.float32).reshape(1, 2, 3),
        "linear": np.arange(6, dtype=np.float32).reshape(1, 2, 3) + 10,
    }
    found = dict(exr_channels(layers))
    assert list(found) == ["Z", "strand_id", "tangent.X", "tangent.Y", "tangent.Z", "R", "G", "B", "A"]
    assert found["strand_id"].tolist() == [[-1, (1 << 24) - 1]]
    np.testing.assert_array_equal(found["tangent.Y"], [[1, 4]])
    np.testing.assert_array_equal(found["B"], [[12, 15]])
    np.testing.assert_array_equal(found["A"], [[1, 1]])
    bare = dict(exr_channels({"mask": np.float32([[0.5]]), "linear": np.float32([[[1, 2, 3, 0.25]]])}))
    assert {name: channel.item() for name, channel in bare.items()} == {"mask": 0.5, "R": 1, "G": 2, "B": 3, "A": 0.25}


def test_exr_files_are_read_by_their_own_library_again(run: Runner) -> None:
    OpenEXR = pytest.importorskip("OpenEXR")
    for folder, changes in (("out", ()), ("bare", ("--set", "image.background=none"))):
        words = ("--exr", "--aov", "depth,strand_id,mask", "--quiet", *changes)
        run.fine("render", "tiny.yaml", "-f", "3", "-o", folder, *words)
    found = {}
    for folder in ("out", "bare"):
        with OpenEXR.File(f"{folder}/frame_0003.exr", separate_channels=True) as file:
            found[folder] = {name: channel.pixels for name, channel in file.channels().items()}
    channels, bare = found["out"], found["bare"]
    assert set(channels) == set(bare) == {"R", "G", "B", "A", "Z", "strand_id", "mask"}
    assert (channels["A"] == 1).all()
    np.testing.assert_array_equal(channels["mask"], bare["mask"])
    np.testing.assert_array_equal(bare["A"], read_layer(Path("bare/linear_0003.npz"))[..., 3])
    assert 0 < bare["A"].mean() < 1
    np.testing.assert_array_equal(channels["Z"], read_layer(Path("out/depth_0003.npz")))
    np.testing.assert_array_equal(channels["strand_id"], read_layer(Path("out/strand_id_0003.npz")))
    np.testing.assert_array_equal(channels["G"], read_layer(Path("out/linear_0003.npz"))[..., 1])


def test_an_exr_file_without_a_layer_that_is_asked_for_is_written_again(run: Runner) -> None:
    OpenEXR = pytest.importorskip("OpenEXR")
    for names in ("depth", "mask", "depth"):
        run.fine("render", "tiny.yaml", "-f", "3", "-o", "out", "--exr", "--aov", names, "--resume", "--quiet")
    with OpenEXR.File("out/frame_0003.exr", separate_channels=True) as file:
        assert "Z" in file.channels()


def test_a_layer_that_is_cut_short_is_written_again(run: Runner) -> None:
    words = ("render", "tiny.yaml", "-f", "3", "-o", "out", "--aov", "depth", "--quiet")
    assert run(*words).code == 0
    path = Path("out/depth_0003.npz")
    whole = path.read_bytes()
    path.write_bytes(whole[:100])
    assert run(*words, "--resume").code == 0
    np.testing.assert_array_equal(read_layer(path), np.load(io.BytesIO(whole))["depth"])
