"""What an unknown option is answered by: the setting, or the option for it, that other programs call so."""

from __future__ import annotations

import pytest

from cli_runs import Runner


@pytest.mark.parametrize(
    ("option", "meant"),
    [
        ("--transparent", "'--transparent'; did you mean --set image.background=none? (see"),
        ("--resolution", "'--resolution'; did you mean --size? (see"),
        ("--motion-blur", "'--motion-blur'; did you mean --set camera.shutter=0.5? (see"),
        ("--fov", "'--fov'; did you mean --set camera.fov=…? (see"),
        ("--strnds", "'--strands'"),
    ],
)
def test_an_unknown_option_names_the_setting_that_is_meant(run: Runner, option: str, meant: str) -> None:
    done = run("render", "tiny.yaml", option)
    assert done.code == 2
    assert meant in done.error()


def test_commands_without_settings_suggest_none(run: Runner) -> None:
    assert "--set" not in run("compare", "--resolution", "a", "b").error()


def test_suggested_settings_are_taken(run: Runner) -> None:
    from strandcli.scene.absent import ELSEWHERE

    for setting in ELSEWHERE.values():
        assert run("plan", "tiny.yaml", "--set", setting).code == 0
