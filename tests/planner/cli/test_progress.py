"""The progress line: only after a second, only on stderr, wiped on a terminal."""

import io
import time

import pytest

from topple.planner.cli import progress as module
from topple.planner.cli.progress import Progress


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_what_is_quick_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with Progress("relate") as progress:
        progress("scene.npz")
        time.sleep(0.3)
    assert capsys.readouterr() == ("", "")


def test_what_takes_long_says_each_message_once(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_PATIENCE", 0.05)
    monkeypatch.setattr(module, "_WAITING", 0.05)
    monkeypatch.setattr(module, "_TICK", 0.02)
    monkeypatch.setattr(module, "_PAUSE", 0.1)
    with Progress("relate") as progress:
        for message in ("first.npz", "second.npz"):
            progress(message)
            time.sleep(0.3)
    out, err = capsys.readouterr()
    assert out == ""
    assert [line.split(" (")[0] for line in err.splitlines()] == [
        "topple relate: first.npz",
        "topple relate: second.npz",
    ]


def test_a_log_that_waits_for_the_processor_says_nothing_yet(capsys: pytest.CaptureFixture[str]) -> None:
    with Progress("relate") as progress:
        progress("scene.npz")
        time.sleep(1.5)
    assert capsys.readouterr() == ("", "")


def test_a_log_has_a_line_once_a_second_was_worked(capsys: pytest.CaptureFixture[str]) -> None:
    with Progress("relate") as progress:
        progress("scene.npz")
        end = time.process_time() + 2.2
        while time.process_time() < end:
            sum(range(1000))
    assert capsys.readouterr().err.startswith("topple relate: scene.npz (")


def test_a_terminal_is_left_clean(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = _Terminal()
    monkeypatch.setattr(module.sys, "stderr", terminal)
    monkeypatch.setattr(module, "_PATIENCE", 0.05)
    monkeypatch.setattr(module, "_TICK", 0.02)
    with Progress("relate") as progress:
        progress("scene.npz")
        time.sleep(0.3)
    assert "scene.npz" in terminal.getvalue()
    assert terminal.getvalue().endswith("\r\x1b[K")
    assert "\n" not in terminal.getvalue()


def test_a_terminal_has_a_bar_and_what_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_PATIENCE", 0.0)
    monkeypatch.setattr(module, "_TICK", 0.01)
    terminal = _Terminal()
    monkeypatch.setattr(module.sys, "stderr", terminal)
    with Progress("bench") as progress:
        progress("setting up")  # nothing is counted yet: the bar wanders
        time.sleep(0.05)
        for number in range(1, 5):
            progress(f"pile {number} of 4")
            time.sleep(0.05)
    lines = terminal.getvalue().split("\r\x1b[K")
    assert any("[" in line and "setting up" in line for line in lines)
    assert not any("left" in line for line in lines if "pile 1" in line)
    last = next(line for line in lines if "pile 4 of 4" in line)
    assert last.count("#") > 10 and "s left, pile 4 of 4" in last
