"""`strandcli render` and `simulate` with the real pipeline on a tiny scene: files, report, resuming, interruption."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import strandcli
from cli_runs import TINY, Runner, child, report
from strandcli.output import frames, png
from strandcli.run import pipeline

PANELS = TINY + "panels:\n  - {label: one}\n  - {label: two, set: {image.size: [32, 24]}}\n"


def names(folder: str) -> list[str]:
    return sorted(os.listdir(folder))


def hashes(folder: str) -> dict[int, str]:
    return {entry["frame"]: entry["pixels_sha256"] for entry in report(folder)["frames"]}


def test_quality_is_an_option_and_wins_over_the_preset(run: Runner) -> None:
    Path("fine.yaml").write_text(TINY + "quality: best\n")
    assert run("render", "fine.yaml", "-f", "1", "--quality", "draft", "-o", "a", "-q").code == 0
    assert run("render", "tiny.yaml", "-f", "1", "--set", "quality=draft", "-o", "b", "-q").code == 0
    assert hashes("a") == hashes("b")
    assert run("render", "tiny.yaml", "-f", "1", "--set", "quality=best", "-o", "c", "-q").code == 0
    assert hashes("a") != hashes("c")
    assert run("render", "tiny.yaml", "--quality", "fast").code == 2
    stages = json.loads(run("plan", "tiny.yaml", "--quality", "draft", "--json").out)["used"]
    assert "coverage" in {stage["stage"] for stage in stages}


def test_a_bare_name_is_a_file_here_and_a_shipped_name_that_hides_one_says_so(run: Runner) -> None:
    assert run("plan", "tiny").code == 0
    assert run("render", "tiny", "-f", "1", "-q").code == 0
    assert names("out/tiny") == ["frame_0001.png", "report.html", "report.json"]
    Path("minimal.yaml").write_text(TINY)
    told = run.fine("plan", "minimal")
    assert told.error() == "minimal: takes the shipped preset of this name; write minimal.yaml for yours"
    assert "150 strands" in run("plan", "minimal.yaml").out


def test_frames_and_report_are_what_the_design_page_says(run: Runner) -> None:
    result = run("render", "tiny.yaml", "-f", "1-3")
    assert (result.code, result.out) == (0, "")
    assert names("out/tiny") == ["frame_0001.png", "frame_0002.png", "frame_0003.png", "report.html", "report.json"]
    data = report("out/tiny")
    assert data["schema_version"] == 1
    assert data["strandcli"] == strandcli.__version__
    assert data["status"] == "complete"
    assert data["preset"]["name"] == "tiny"
    assert data["preset"]["sha256"] == strandcli.load("tiny.yaml").sha256
    assert set(data["machine"]) >= {"cpu", "cores", "threads", "threading_layer", "python", "numba", "llvm"}
    assert {"stage": "rule collision", "why": "the preset does not list it"} in data["plan"]["left_out"]
    for entry, frame in zip(data["frames"], pipeline.render(strandcli.load("tiny.yaml"), [1, 2, 3]), strict=True):
        assert entry["frame"] == frame.number
        image = png.read(Path("out/tiny", entry["file"]))
        np.testing.assert_array_equal(image, frame.image)
        assert entry["pixels_sha256"] == png.pixels_sha256(image)
        assert set(entry["seconds"]) >= {"simulate", "curves", "shadow", "shade", "raster", "write", "total"}
        assert entry["seconds"]["total"] == pytest.approx(
            sum(value for name, value in entry["seconds"].items() if name != "total" and value is not None)
        )
        assert entry["counts"]["strands"] == 150
        assert set(entry["error"]) >= {"stretch_max", "penetration_max", "residual_max", "curve_px_max", "nonfinite"}
    assert data["totals"]["frames_per_second"] > 0


def test_json_is_alone_on_stdout_and_the_same_as_the_file(run: Runner) -> None:
    assert json.loads(run("render", "tiny.yaml", "-f", "2", "-o", "a", "--json").out) == report("a")
    assert run("render", "tiny.yaml", "-f", "2", "-o", "b", "-q").err == ""
    assert "frame 2: " in run("render", "tiny.yaml", "-f", "2", "-o", "c", "-v").err


def test_the_common_options_change_the_scene(run: Runner) -> None:
    options = ["--size", "20x30", "--strands", "70", "--particles", "4", "--set", "wind.strength=9", "--seed", "1"]
    data = json.loads(run("render", "tiny.yaml", "-f", "2", "--json", *options).out)
    assert data["frames"][0]["counts"]["strands"] == 70
    assert data["frames"][0]["counts"]["particles"] == 280
    assert png.read(Path("out/tiny/frame_0002.png")).shape == (30, 20, 3)


def test_existing_frames_resume_and_overwrite(run: Runner) -> None:
    run("render", "tiny.yaml", "-o", "a", "-f", "1-3")
    first = report("a")
    assert "frame_0002.png, frame_0003.png" in run.refused("render", "tiny.yaml", "-o", "a", "-f", "2-4")
    Path("a/frame_0002.png").write_bytes(b"half")
    stamp = Path("a/frame_0001.png").stat().st_mtime_ns
    result = run.fine("render", "tiny.yaml", "-o", "a", "-f", "1-4", "--resume")
    assert "2 frames" in result.err
    assert "2 kept" in result.err
    assert Path("a/frame_0001.png").stat().st_mtime_ns == stamp
    second = report("a")
    assert [entry["frame"] for entry in second["frames"]] == [1, 2, 3, 4]
    assert [entry.get("kept", False) for entry in second["frames"]] == [True, False, True, False]
    assert second["frames"][0] == {**first["frames"][0], "kept": True}
    assert second["frames"][1]["pixels_sha256"] == first["frames"][1]["pixels_sha256"]
    other = run.refused("render", "tiny.yaml", "-o", "a", "-f", "1-4", "--resume", "--seed", "9")
    assert "was made from another scene" in other
    assert run("render", "tiny.yaml", "-o", "a", "-f", "1-4", "--overwrite", "--seed", "9").code == 0
    assert hashes("a")[1] != first["frames"][0]["pixels_sha256"]


@pytest.mark.parametrize(("command", "name"), [("render", "report.json"), ("simulate", "manifest.json")])
@pytest.mark.parametrize("text", ['{"frames": []}', "no json"])
def test_what_somebody_else_wrote_is_not_replaced_unasked(run: Runner, command: str, name: str, text: str) -> None:
    Path("a").mkdir()
    Path("a", name).write_text(text)
    for more in ([], ["--resume"]):
        refused = run.refused(command, "tiny.yaml", "-f", "1", "-o", "a", *more)
        assert f"a/{name}: was not written by strandcli; add --overwrite" in refused
        assert Path("a", name).read_text() == text
    assert names("a") == [name]
    assert run(command, "tiny.yaml", "-f", "1", "-o", "a", "--overwrite").code == 0
    assert run(command, "tiny.yaml", "-f", "2", "-o", "a").code == 0


def test_runs_of_one_scene_report_all_its_frames_in_the_folder(run: Runner) -> None:
    run("render", "tiny.yaml", "-o", "a", "-f", "1-3")
    first = report("a")["frames"]
    Path("a/frame_0003.png").unlink()
    result = run("render", "tiny.yaml", "-o", "a", "-f", "5", "--json")
    assert "kept" not in result.err  # of what was asked for
    assert json.loads(result.out) == report("a")
    entries = report("a")["frames"]
    assert [entry["frame"] for entry in entries] == [1, 2, 5]
    assert entries[:2] == [{**entry, "kept": True} for entry in first[:2]]
    assert "kept" not in entries[2]
    run("render", "tiny.yaml", "-o", "a", "-f", "2", "--overwrite")
    assert [entry.get("kept", False) for entry in report("a")["frames"]] == [True, False, True]
    run("render", "tiny.yaml", "-o", "a", "-f", "2,6", "--overwrite", "--seed", "9")
    assert [entry["frame"] for entry in report("a")["frames"]] == [2, 6]
    run("render", "tiny.yaml", "-o", "b", "-f", "2", "--seed", "9")
    Path("a/frame_0006.png").write_bytes(Path("a/frame_0001.png").read_bytes())  # another scene's
    run("render", "tiny.yaml", "-o", "a", "-f", "7", "--seed", "9")
    assert [entry["frame"] for entry in report("a")["frames"]] == [2, 7]


def test_frames_of_two_scenes_in_one_folder_are_told(run: Runner) -> None:
    assert run("render", "tiny.yaml", "-o", "a", "-f", "1-2").code == 0
    assert "warning" not in run("render", "tiny.yaml", "-o", "a", "-f", "3").err
    other = run.fine("render", "tiny.yaml", "--seed", "7", "-o", "a", "-f", "3-4", "--overwrite")
    (warning,) = (line for line in other.err.splitlines() if "warning" in line)
    assert "a: 2 frames there of another scene or other settings, such as frame_0001.png" in warning
    assert report("a")["warnings"] == [warning.partition("warning: ")[2]]
    assert "warning" not in run("render", "tiny.yaml", "-o", "a", "-f", "1-4", "--overwrite").err


C_LOCALE = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


@pytest.mark.parametrize(("name", "shown"), [(b"p\xff", "p\ufffd"), (b"p\xc3\xbc", "p\u00fc")], ids=["bytes", "umlaut"])
def test_names_that_are_no_text_end_in_a_report(
    run: Runner, monkeypatch: pytest.MonkeyPatch, name: bytes, shown: str
) -> None:
    Path(os.fsdecode(name + b".yaml")).write_text(TINY)
    for variable, value in C_LOCALE.items():
        monkeypatch.setenv(variable, value)
    preset, folder = os.fsdecode(name + b".yaml"), os.fsdecode(name)
    process = child(run.folder, "render", preset, "-f", "1", "-o", folder, "--json", "--no-progress", encoding="utf-8")
    out, err = process.communicate(timeout=240)
    assert process.returncode == 0, err
    assert json.loads(out)["preset"]["name"] == shown
    assert report(folder)["preset"]["name"] == shown
    assert len(err.splitlines()) == 1


def test_runs_at_once_report_each_others_frames(run: Runner) -> None:
    several = [child(run.folder, "render", "tiny.yaml", "-o", "a", "-f", f"{n}-12x3", "-q") for n in (1, 2, 3)]
    for process in several:
        out, err = process.communicate(timeout=240)
        assert (process.returncode, out, err) == (0, "", "")
    assert [entry["frame"] for entry in report("a")["frames"]] == list(range(1, 13))
    assert names("a") == [*(frames.frame_file(n) for n in range(1, 13)), "report.html", "report.json"]


def test_positions_are_kept_and_drawn_again_to_the_same_pixels(run: Runner) -> None:
    assert run("simulate", "tiny.yaml", "-o", "p", "-f", "1-4").code == 0
    assert names("p") == ["manifest.json", *(f"positions_000{frame}.npz" for frame in (1, 2, 3, 4))]
    with np.load("p/positions_0003.npz") as data:
        found = data["positions"]
    (frame,) = pipeline.render(strandcli.load("tiny.yaml"), [3], draw=False, keep_positions=True)
    assert found.shape == (150, 5, 3)
    np.testing.assert_array_equal(found, frame.positions)
    run("render", "tiny.yaml", "-o", "a", "-f", "2-4")
    manifest = json.loads(Path("p/manifest.json").read_text())
    for entry, drawn in zip(manifest["frames"][1:], report("a")["frames"], strict=True):
        assert entry["error"] == {key: drawn["error"][key] for key in entry["error"]}
        assert set(entry["error"]) >= {"stretch_max", "penetration_max", "segment_penetration_max", "nonfinite"}
    assert run("render", "tiny.yaml", "-o", "b", "-f", "2-4", "--from-cache", "p").code == 0
    assert hashes("a") == hashes("b")
    assert report("b")["frames"][0]["seconds"]["simulate"] is None
    assert run("render", "tiny.yaml", "-o", "all", "--from-cache", "p").code == 0  # what there is, without -f
    assert [frame["frame"] for frame in report("all")["frames"]] == [1, 2, 3, 4]
    assert run("render", "tiny.yaml", "-o", "m", "--from-cache", "p", "--set", "time.frames=3").code == 0
    assert [frame["frame"] for frame in report("m")["frames"]] == [1, 2, 3]
    lost = run.refused("render", "tiny.yaml", "-o", "c", "-f", "3-6", "--from-cache", "p")
    assert "no positions for frames 5, 6" in lost
    assert not Path("c").exists()
    other = run("render", "tiny.yaml", "-o", "c", "-f", "3", "--from-cache", "p", "--strands", "99")
    assert "shape (150, 5, 3), but the scene has 99 strands of 5 particles; give the preset" in other.error()
    assert run("simulate", "tiny.yaml", "-o", "p", "-f", "1-4").code == 2
    result = run("simulate", "tiny.yaml", "-o", "p", "-f", "1-5", "--resume", "--json")
    entries = json.loads(result.out)["frames"]
    assert [entry["frame"] for entry in entries] == [1, 2, 3, 4, 5]
    assert [entry["error"] for entry in entries[:4]] == [entry["error"] for entry in manifest["frames"]]
    assert "error" in entries[4]


def test_animations_are_made_from_the_frames(run: Runner) -> None:
    assert run("render", "tiny.yaml", "-f", "1-3", "--animate", "gif,webp").code == 0
    for suffix in ("gif", "webp"):
        with Image.open(f"out/tiny/animation.{suffix}") as film:
            assert (film.size, getattr(film, "n_frames", 1)) == ((64, 48), 3)
    again = run("render", "tiny.yaml", "-o", "b", "-f", "1-3", "--animate", "gif", "--set", "time.fps=100", "--verbose")
    assert "plays 50 frames a second, all that gif can; 100 were asked" in again.err


def test_panels_are_drawn_resumed_and_not_simulated(run: Runner) -> None:
    Path("panels.yaml").write_text(PANELS)
    assert run("render", "panels.yaml", "-f", "1-2").code == 0
    assert png.read(Path("out/panels/frame_0001.png")).shape[1] > 64 + 32
    assert "2 kept" in run("render", "panels.yaml", "-f", "1-2", "--resume").err
    assert "several panels" in run("simulate", "panels.yaml", "-o", "p").error()
    assert "several panels" in run("render", "panels.yaml", "-f", "1", "-o", "b", "--from-cache", "p").error()
