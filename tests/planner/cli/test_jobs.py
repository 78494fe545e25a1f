"""Many scenes on several processes give what one after the other gives."""

from pathlib import Path

import numpy as np
import pytest

from topple.planner.cli.main import main


def scene(path: Path, gap: float) -> str:
    """Two plates on a table, one further away than in the next scene."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(0, 0.1, 20), np.linspace(0, 0.1, 20)))
    one = np.column_stack([x, y, np.full(len(x), 0.02)])
    table = np.column_stack([4 * x - 0.1, 4 * y - 0.1, np.zeros(len(x))])
    np.savez(
        path, one=one, other=one + np.array([0.1 + gap, 0, 0]), table=table, fixed=["table"], up=[0, 0, 1]
    )
    return str(path)


@pytest.mark.slow
def test_two_processes_print_what_one_does(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = [scene(tmp_path / f"{k}.npz", 0.01 * k) for k in range(3)]
    assert main(["relate", *paths, "--json"]) == 0
    alone = capsys.readouterr().out
    assert main(["relate", *paths, "--json", "--jobs", "2"]) == 0
    assert capsys.readouterr().out == alone
    assert len(alone.splitlines()) == 3


def test_no_number_of_processes_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["relate", scene(tmp_path / "0.npz", 0.0), "--jobs", "0"]) == 2
    assert "a whole number from 1 on" in capsys.readouterr().err
