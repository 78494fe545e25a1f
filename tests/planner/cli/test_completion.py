"""Completion in the shells themselves, and what `topple` says when it is called with nothing."""

import shutil
import subprocess
import sys
from contextlib import redirect_stdout

import pytest

from topple.planner.cli.completion import SHELLS
from topple.planner.cli.main import COMMANDS, main
from topple.robots.scenarios import SCENARIOS

ASKED = {  # the words typed so far, the last one to be completed -> some of what has to be offered
    "or": {"order"},
    "order --t": {"--target"},
    "plan --robot p": {"panda", "panda-suction"},
    "demo ": {"dishes", "lemon", "tower"},
    "export --to b": {"bt"},
}


@pytest.fixture(scope="module")
def scripts(tmp_path_factory):
    folder = tmp_path_factory.mktemp("completion")
    for shell in SHELLS:
        with (folder / shell).open("w", encoding="utf-8") as file, redirect_stdout(file):
            assert main(["--completion", shell]) == 0
    return folder


def offered(shell, script, typed):
    """What a shell offers after `topple `."""
    words = typed.split(" ")
    asks = {
        "bash": f"source {script}; COMP_WORDS=(topple {' '.join(words[:-1])} '{words[-1]}'); "
        f"COMP_CWORD={len(words)}; _topple; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
        "zsh": "autoload -U compinit && compinit -D; compadd() { print -l -- $@ }; "
        f"source {script}; words=(topple {' '.join(words[:-1])} '{words[-1]}'); CURRENT={len(words) + 1}; "
        "_bash_complete -o default -F _topple",
    }
    flags = {"zsh": ["-f"], "bash": ["--norc"]}[shell]
    done = subprocess.run([shell, *flags, "-c", asks[shell]], capture_output=True, text=True, timeout=30)
    assert done.stderr == ""
    return set(done.stdout.split())


@pytest.mark.parametrize("shell", SHELLS)
def test_a_shell_offers_what_can_follow(shell, scripts):
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell} here")
    for typed, wanted in ASKED.items():
        assert wanted <= offered(shell, scripts / shell, typed), typed


def test_bash_offers_every_command(scripts):
    assert set(COMMANDS) <= offered("bash", scripts / "bash", "")


def test_topple_alone_says_what_most_people_want(typed):
    calls = [line.split()[1] for line in typed().out.splitlines() if line.startswith("  topple")]
    assert calls == ["demo", "order", "show"]


def test_another_shell_is_refused_in_one_line(typed):
    assert len(typed("--completion", "tcsh", code=2).err.strip().splitlines()) == 1


def test_completion_needs_no_simulation_and_knows_every_demo():
    code = "import sys; sys.modules.update(pybullet=None, pybullet_data=None)\n"
    code += "from topple.planner.cli.main import main; sys.exit(main(['--completion', 'bash']))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert f'words="{" ".join(SCENARIOS)}"' in done.stdout
