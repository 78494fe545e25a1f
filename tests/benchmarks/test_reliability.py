"""What is left behind, leaks, or breaks is found by the measures of `topple bench reliability`."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace

import pytest

from topple.benchmarks import kills, soak
from topple.benchmarks.commands.bench import _print
from topple.benchmarks.faults.inject import FAULTS, Fault, FaultCount, Run
from topple.benchmarks.reliability import rows
from topple.benchmarks.row import Row
from topple.benchmarks.scores import share
from topple.robots.engine import pybullet
from topple.topology.base.errors import InvalidInput

ORPHAN = (
    "import subprocess, time\n"
    "print(subprocess.Popen(['sleep', '20'], start_new_session=True).pid, flush=True)\n"
    "time.sleep(20)"
)


def test_what_is_half_written_is_found(tmp_path):
    (tmp_path / "demo").mkdir()
    assert kills._halves(tmp_path) == []
    (tmp_path / "plan.json").write_text('{"format": "topple.pl')
    (tmp_path / "show.html").write_text("<html><body>")
    (tmp_path / "run.html.part").write_text("")
    (tmp_path / "demo" / "order.json").write_text("{}")
    assert kills._halves(tmp_path) == [
        "run.html.part was left",
        "plan.json is no JSON",
        "show.html has no end",
        "of a demo there is only order.json",
    ]


def test_a_worker_that_outlives_its_parent_is_found(monkeypatch, tmp_path):
    monkeypatch.setattr(kills, "GONE_WITHIN", 0.3)
    (tmp_path / "tmp").mkdir()
    with subprocess.Popen([sys.executable, "-c", ORPHAN], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        orphan = int(parent.stdout.readline())
        try:
            assert kills._ended(tmp_path, parent) == [f"worker {orphan} outlived its parent"]
        finally:
            os.kill(orphan, signal.SIGKILL)


def test_a_command_that_finds_room_where_there_should_be_none_is_found(tmp_path):
    scene = kills._scene(tmp_path)
    said = kills._refusal(tmp_path, ("relate", *scene), None, None)
    assert said.startswith("exit code 0") and "0 lines" in said


def test_kills_are_counted_by_what_they_leave():
    assert kills._killed("plan -o", [[], ["a", "b"], []]) == kills.Killed("plan -o", 3, 2, ("a", "b"))


def test_a_simulation_that_is_left_open_is_found():
    before = sum(soak._is_open(client) for client in range(soak.CLIENTS))
    client = pybullet.connect(pybullet.DIRECT)
    try:
        assert sum(soak._is_open(client) for client in range(soak.CLIENTS)) == before + 1
    finally:
        pybullet.disconnect(physicsClientId=client)


def test_a_run_survives_by_its_goal_or_by_naming_the_fault_and_never_by_either_alone():
    fault: Fault = FAULTS[0]
    well = Run(fault.name, 0, reached=True)
    named = Run(fault.name, 1, named=True)
    bad = [Run(fault.name, 2), *(replace(well, **{key: 1}) for key in ("disturbed", "lied", "crashed"))]
    assert well.survived and named.survived
    assert not any(run.survived for run in bad)
    assert FaultCount(fault.name, (well, named, *bad)).survived == 2


def test_a_missed_bar_is_printed_with_what_went_wrong(capsys):
    fine = share("faults", 3, 3, ">= 100", counted=True)
    bad = share("splits", 2, 3, ">= 100", counted=True, wrong=["seed 7: no\nplan"])
    assert (fine.ok, bad.ok) == (True, False)
    rows = [fine.to_json(), bad.to_json(), Row("left out", 8, "", tried=0).to_json()]
    assert json.loads(json.dumps(rows))[1]["wrong"] == ["seed 7: no\nplan"]
    machine = {"processor": "x", "cores": 2}
    _print({"bench": "reliability", "quick": True, "seed": 0, "machine": machine, "rows": rows})
    out = capsys.readouterr().out
    assert "MISSED" in out and "1 of 2 bars cleared, 1 missed." in out
    assert "splits: seed 7: no plan\n" in out
    assert "baseline" not in out and "tried" in out


def test_a_part_that_there_is_not_is_refused():
    with pytest.raises(InvalidInput, match="no part 'noise': expected one of readers, sabotages"):
        rows(quick=True, seed=0, progress=lambda text: None, part="noise")
