"""Many scenes on several processes give what one after the other gives."""

import json
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
def test_two_processes_print_what_one_does(tmp_path, typed):
    paths = [scene(tmp_path / f"{k}.npz", 0.01 * k) for k in range(3)]
    alone = typed("relate", *paths, "--json").out
    assert typed("relate", *paths, "--json", "--jobs", "2").out == alone
    assert len(alone.splitlines()) == 3


def test_no_number_of_processes_is_refused(tmp_path, typed):
    err = typed("relate", scene(tmp_path / "0.npz", 0.0), "--jobs", "0", code=2).err
    assert "a whole number from 1 on" in err


@pytest.mark.parametrize("command", ["relate", "order"])
def test_what_was_kept_is_not_answered_again(command, tmp_path, capsys, typed):
    paths = [scene(tmp_path / f"{k}.npz", 0.01 * k) for k in range(3)]
    whole, out = tmp_path / "whole.jsonl", tmp_path / "out.jsonl"
    assert typed(command, *paths, "-o", whole).out == f"{whole} has answers to 3 scenes.\n"
    assert main([command, *paths, "--json"]) == 0
    printed = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    lines = whole.read_text().splitlines(keepends=True)
    assert [{**one, "asked": {}} for one in printed] == [json.loads(line) for line in lines]
    out.write_text(lines[0] + lines[1][:40])  # killed as it wrote the second
    Path(paths[0]).unlink()  # what is kept is not read again
    assert main([command, *paths, "-o", str(out)]) == 0
    assert out.read_text() == lines[0] + lines[1][:40] + "\n" + "".join(lines[1:])


def test_answers_to_another_question_are_refused(tmp_path, typed):
    path, out = scene(tmp_path / "0.npz", 0.0), tmp_path / "out.jsonl"
    assert main(["order", path, "-o", str(out)]) == 0
    said = typed("order", path, "-o", out, "--target", "one", code=2).err
    assert "line 1 is no answer of this topple order" in said
    assert "expected {'target': ['one']}" in said
    out.write_text("{}\n")
    assert "line 1" in typed("order", path, "-o", out, code=2).err
