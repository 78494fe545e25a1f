"""A fault of topple itself has an exit code of its own, one line, and its trace in a file."""

import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from topple.planner.cli import main as entry
from topple.topology import InvalidInput


def test_a_fault_is_told_apart_from_a_refusal(monkeypatch, capsys, tmp_path):
    broken = ModuleType("topple.planner.cli.broken")
    broken.add_arguments = lambda parser: None  # type: ignore[attr-defined]
    broken.execute = lambda args: 1 // 0  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "topple.planner.cli.broken", broken)
    monkeypatch.setitem(entry.COMMANDS, "broken", "a command with a fault")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert entry.main(["broken"]) == entry.CRASHED == 70
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "ZeroDivisionError" in said
    written = re.search(r"the trace is in (\S+)", said)
    assert written is not None
    text = Path(written.group(1)).read_text(encoding="utf-8")
    assert text.startswith("topple broken\n") and "Traceback" in text and "1 // 0" in text


@pytest.mark.parametrize(
    "closed", ["<&- >&- 2>&-", *(pytest.param(one, marks=pytest.mark.slow) for one in ("<&-", ">&-", "2>&-"))]
)
def test_closed_streams_are_no_fault(closed, tmp_path):
    np.savez(tmp_path / "scene.npz", a=np.random.default_rng(0).uniform(0.0, 0.1, (200, 3)))
    command = f'exec "{sys.executable}" -m topple.planner.cli.main relate '
    for scene, code in (("scene.npz", 0), ("missing.npz", 2)):
        done = subprocess.run(["sh", "-c", command + f"{scene} {closed}"], cwd=tmp_path, capture_output=True)
        assert done.returncode == code, done.stderr


def test_the_text_of_an_error_is_one_line():
    assert str(InvalidInput("two\nlines")) == "two lines"
