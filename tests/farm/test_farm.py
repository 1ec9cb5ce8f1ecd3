"""`strandcli farm`: what is generated is run by stand-ins for the schedulers, to the very frames of a plain run."""

from __future__ import annotations

import json
import os
import re
import stat
import subprocess
from pathlib import Path

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from cli_runs import TINY, Runner, environment
from strandcli import farm as jobs
from strandcli.cli.values import FrameRange
from strandcli.common.limits import cores as usable_cores
from strandcli.output import png

SBATCH = """\
#!/bin/sh
# Runs a job at once, each task of an array by itself, if what it depends on went well; prints its number.
id=$(($(cat "$JOBS.count" 2>/dev/null || echo 100) + 1)); echo $id > "$JOBS.count"
array=0-0; depends=""
while [ $# -gt 0 ]; do
  case "$1" in
    --array=*) array="${1#--array=}" ;;
    --dependency=afterok:*) depends="${1#--dependency=afterok:}" ;;
    --chdir=*) cd "${1#--chdir=}" ;;
    --*) ;;
    *) break ;;
  esac
  shift
done
echo "$id $2 ${depends:-none} $array" >> "$JOBS"
if [ -n "$depends" ] && ! grep -qx "$depends" "$JOBS.well"; then echo "$id"; exit 0; fi
copy="$(mktemp)"; cp "$1" "$copy"; shift  # as Slurm does: the script's own folder is another one
for task in $(seq "${array%-*}" "${array#*-}"); do
  SLURM_CPUS_PER_TASK=1 SLURM_ARRAY_TASK_ID=$task sh "$copy" "$@" >&2 || { rm "$copy"; echo "$id;cluster"; exit 0; }
done
rm "$copy"; echo "$id" >> "$JOBS.well"; echo "$id;cluster"
"""


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Runner:
    """In a folder with a blank in its name."""
    folder = tmp_path / "my films"
    folder.mkdir()
    (folder / "tiny.yaml").write_text(TINY)
    monkeypatch.chdir(folder)
    return Runner(folder, capsys)


def shell(folder: Path, command: list[str], tool: str, text: str) -> subprocess.CompletedProcess[str]:
    """Run a script with a stand-in of a scheduler's command on the PATH."""
    tools = folder / "tools"
    tools.mkdir(exist_ok=True)
    (tools / tool).write_text(text)
    (tools / tool).chmod(stat.S_IRWXU)
    told = {**environment(), "PATH": f"{tools}{os.pathsep}{os.environ['PATH']}", "JOBS": str(folder / "jobs.log")}
    return subprocess.run(command, cwd=folder, env=told, capture_output=True, text=True)


def hashes(folder: str) -> dict[str, str]:
    return {path.name: png.pixels_sha256(png.read(path)) for path in sorted(Path(folder).glob("frame_*.png"))}


def plain(run: Runner) -> dict[str, str]:
    """Frames of a plain run with the options that the tests hand to the farm."""
    assert run("render", "tiny.yaml", "-o", "plain", "-f", "1-9x2", "--set", "wind.strength=3", "-q").code == 0
    return hashes("plain")


FARM = ["farm", "tiny.yaml", "-f", "1-9x2", "--set", "wind.strength=3", "--chunk", "2", "--threads", "1", "-q"]


def test_slurm_draws_the_frames_of_a_plain_run_and_again_what_is_missing(run: Runner) -> None:
    assert run(*FARM, "--target", "slurm", "-o", "job", "--animate", "gif").code == 0
    Path("tiny.yaml").write_text(TINY.replace("0.6", "0.3"))  # which the job does not care for
    submit = ["sh", "job/submit.sh", "--partition=short"]
    done = shell(run.folder, submit, "sbatch", SBATCH)
    assert done.returncode == 0, done.stderr
    log = [line.split() for line in Path("jobs.log").read_text().splitlines()]
    assert log == [
        ["101", "warmup", "none", "0-0"], ["102", "simulate", "101", "0-0"], ["103", "draw", "102", "0-2"],
        ["104", "join", "103", "0-0"],
    ]  # fmt: skip
    assert "the last job is 104" in done.stdout
    Path("tiny.yaml").write_text(TINY)
    found = hashes("job/frames")
    assert found == plain(run)
    assert Path("job/frames/animation.gif").exists()
    assert Path("job/frames/report.html").exists()
    assert json.loads(Path("job/frames/report.json").read_text())["status"] == "complete"
    kept = Path("job/frames/frame_0001.png").stat().st_mtime_ns
    Path("job/frames/frame_0005.png").unlink()
    Path("job/positions/positions_0007.npz").write_bytes(b"torn")
    assert shell(run.folder, submit, "sbatch", SBATCH).returncode == 0
    assert hashes("job/frames") == found
    assert Path("job/frames/frame_0001.png").stat().st_mtime_ns == kept


def test_open_job_description_draws_the_frames_of_a_plain_run(run: Runner) -> None:
    """By a stand-in that fills parameters in and runs the steps in the order of their dependencies."""
    assert run(*FARM, "--target", "openjd", "-o", "job").code == 0
    template = yaml.safe_load(Path("job/job.yaml").read_text())
    known = {f"Param.{one['name']}": one["default"] if one["type"] == "STRING" else str(Path("job", one["default"]))
             for one in template["parameterDefinitions"]}  # fmt: skip

    def filled(text: str, more: dict[str, str]) -> str:
        return re.sub(r"\{\{([\w.]+)\}\}", lambda match: (known | more)[match[1]], text)

    ran: list[str] = []
    for step in template["steps"]:
        assert all(one["dependsOn"] in ran for one in step.get("dependencies", []))
        space = step.get("parameterSpace", {}).get("taskParameterDefinitions", [{"name": "", "range": [""]}])
        for value in space[0]["range"]:
            action = step["script"]["actions"]["onRun"]
            words = [filled(word, {f"Task.Param.{space[0]['name']}": value}) for word in action["args"]]
            assert filled(action["command"], {}) == "strandcli"
            assert run(*words).code == 0
        ran.append(step["name"])
    assert ran == ["Warm up", "Simulate", "Draw", "Join"]
    assert hashes("job/frames") == plain(run)


def test_templates_are_valid(run: Runner) -> None:
    """By the model that the specification's authors publish, where it is installed."""
    model = pytest.importorskip("openjd.model")
    for name, chunks in (("hair", ("1-8",)), ("{{odd}}\n" * 50, tuple(str(i) for i in range(1, 1001)))):
        job = jobs.Job(name, "1-8", chunks, "1-8", 4, 900, "gif")
        model.decode_job_template(template=jobs.template(job))
        model.decode_job_template(template=jobs.template(jobs.Job(name, "1", chunks, "", 1, 300)))


def test_a_scene_without_motion_is_not_simulated(run: Runner) -> None:
    Path("still.yaml").write_text(TINY.partition("rules:")[0] + "rules: []\ntime: {frames: 12}\n".partition("time")[0])
    assert run("farm", "still.yaml", "--target", "slurm", "-q").code == 0
    text = Path("farm/still/submit.sh").read_text() + Path("farm/still/job.sh").read_text()
    assert "--from-cache" not in text
    assert '--dependency="afterok:$warm" "$@" job.sh draw' in text
    assert "add --overwrite" in run.refused("farm", "still.yaml", "--target", "slurm")


@given(st.text(max_size=30))
@example("0" * 13)
def test_no_name_gets_out_of_its_comment_or_its_quotes(name: str) -> None:
    job = jobs.Job(f"$(touch x)`touch x`'\"\n{name}", "1", ("1",), "1", 1, 300, "", ())
    for target in ("slurm", "parallel"):
        for file, text in jobs.files(job, target, 4).items():
            if file.endswith(".sh"):
                code = [line for line in text.splitlines() if not line.lstrip().startswith("#")]
                assert "touch x)" not in "\n".join(code)
                if not re.fullmatch(r"[\w.-]*", name, re.ASCII):  # such a name says nothing to a shell
                    assert not [line for line in code if name.strip() and len(name) > 12 and name in line]


@given(st.sets(st.integers(1, 5000), min_size=1, max_size=300), st.none() | st.integers(1, 40))
def test_chunks_are_all_frames_once(frames: set[int], size: int | None) -> None:
    numbers = sorted(frames)
    chunks = jobs.chunks_of(numbers, size)
    found = [list(FrameRange.parse(chunk).numbers()) for chunk in chunks]
    assert [number for chunk in found for number in chunk] == numbers
    assert all(len(chunk) == (size or jobs.USUAL_CHUNK) for chunk in found[:-1])


def test_too_many_tasks_are_refused_with_what_fits() -> None:
    with pytest.raises(ValueError, match=r"makes 5,000 tasks; at most 1,000: take 5"):
        jobs.chunks_of(range(1, 5001), 1)
    assert len(jobs.chunks_of(range(1, 100_001))) == jobs.MOST_CHUNKS


def test_no_task_asks_for_more_threads_than_there_are(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    cores = usable_cores()
    monkeypatch.setenv("STRANDCLI", "echo")
    monkeypatch.setenv("OMP_NUM_THREADS", "500")
    for threads, most in (([], min(4, cores)), (["--threads", "999"], cores)):
        more = [*threads, "--target", "parallel", "-o", "job", "--overwrite"]
        assert run("farm", "tiny.yaml", "-f", "1-2", "-q", *more).code == 0
        for stage in ("warmup", "simulate", "draw 1", "join"):
            words = ["sh", "job/job.sh", *stage.split()]
            done = subprocess.run(words, capture_output=True, text=True, check=True)
            assert done.stdout.split()[-2:] == ["--threads", str(most)]


def test_jobs_ask_for_the_memory_that_is_planned(run: Runner) -> None:
    planned = json.loads(run("plan", "tiny.yaml", "--threads", "1", "--json").out)["memory_at_once_bytes"]
    for target, file in (("slurm", "job/submit.sh"), ("openjd", "job/job.yaml")):
        assert (
            run("farm", "tiny.yaml", "--threads", "1", "--target", target, "-o", "job", "-q", "--overwrite").code == 0
        )
        text = Path(file).read_text()
        asked = [int(one or two) for one, two in re.findall(r"--mem=(\d+)M|worker.memory\n *min: (\d+)", text)]
        draws, compiles = min(asked), max(asked)
        assert 1.15 * planned < 0.81 * draws * 2**20 < 1.5 * planned  # within 15 %, and a run is not refused
        assert compiles == 2 * jobs.COMPILER > draws
