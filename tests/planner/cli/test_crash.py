"""A fault of topple itself has an exit code of its own, one line, and its trace in a file."""

import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

from topple.planner.cli import main as entry


def test_a_fault_is_told_apart_from_a_refusal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
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
