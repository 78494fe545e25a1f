"""The progress line: only after a second, only on stderr, wiped on a terminal."""

import io
import re
import time

import pytest

from topple.planner.cli import progress as module
from topple.planner.cli.progress import Progress


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True

    def lines(self) -> list[str]:
        """What was written between two moves of the cursor."""
        return re.split(r"[\r\n]", re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", self.getvalue()))

    def screen(self) -> list[str]:
        """The lines that a terminal of 80 columns shows in the end."""
        shown, row, column = [""], 0, 0
        for move, text in re.findall(r"(\x1b\[[0-9;?]*[a-zA-Z]|[\r\n])|([^\x1b\r\n]+)", self.getvalue()):
            if move in ("\r", "\n"):
                row, column = row + (move == "\n"), 0
                shown += [""] * (row + 1 - len(shown))
            elif move.endswith("A"):
                row -= int(move[2:-1])
            elif move.endswith("K"):
                shown[row] = ""
            elif text:
                shown[row] = shown[row][:column].ljust(column) + text
                column += len(text)
        return [line for line in shown if line]


@pytest.fixture(autouse=True)
def _eighty_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "xterm")


def test_what_is_quick_says_nothing(capsys):
    with Progress("relate") as progress:
        progress("scene.npz")
        time.sleep(0.3)
    assert capsys.readouterr() == ("", "")


def test_what_takes_long_says_each_message_once(capsys, monkeypatch):
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


def test_a_log_that_waits_for_the_processor_says_nothing_yet(capsys):
    with Progress("relate") as progress:
        progress("scene.npz")
        time.sleep(1.5)
    assert capsys.readouterr() == ("", "")


def test_a_log_has_a_line_once_a_second_was_worked(capsys):
    with Progress("relate") as progress:
        progress("scene.npz")
        end = time.process_time() + 2.2
        while time.process_time() < end:
            sum(range(1000))
    assert capsys.readouterr().err.startswith("topple relate: scene.npz (")


def test_a_terminal_is_left_clean(monkeypatch):
    terminal = _Terminal()
    monkeypatch.setattr(module.sys, "stderr", terminal)
    monkeypatch.setattr(module, "_PATIENCE", 0.05)
    monkeypatch.setattr(module, "_TICK", 0.02)
    with Progress("relate") as progress:
        progress("scene.npz")
        time.sleep(0.3)
    assert "scene.npz" in terminal.getvalue()
    assert terminal.screen() == []


def test_a_line_is_no_wider_than_the_terminal_and_what_is_printed_stands_alone(monkeypatch):
    monkeypatch.setattr(module, "_PATIENCE", 0.0)
    monkeypatch.setattr(module, "_TICK", 0.01)
    terminal = _Terminal()
    monkeypatch.setattr(module.sys, "stderr", terminal)
    with Progress("order") as progress:
        for number in (1, 2):
            progress(f"{'a long name ' * 20} ({number} of 2)")
            time.sleep(0.1)
            progress.clear()
            terminal.write("take  because\n")
            time.sleep(0.1)
    assert "a long name" in terminal.getvalue()
    assert max(map(len, terminal.lines())) <= 80
    assert terminal.screen() == ["take  because", "take  because"]


def test_a_terminal_has_a_bar_and_what_is_left(monkeypatch):
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
    lines = terminal.lines()
    assert any("━" in line and "setting up" in line for line in lines)
    assert not any("left" in line for line in lines if "pile 1" in line)
    last = next(line for line in lines if "pile 4 of 4" in line)
    assert last.count("━") > 10 and "s left" in last
