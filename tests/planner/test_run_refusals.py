"""Runs that cannot begin, that have nothing to do, and that somebody ends."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence

import pytest

from topple.planner.execution.loop import ClosedLoop
from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import around, pose_at
from topple.robots.world.camera import Camera
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World


@pytest.fixture
def world() -> Iterator[World]:
    with World() as made:
        made.add_table(size=(2.0, 1.2))
        yield made


def loop(world: World, goal: str, cameras: Sequence[Camera] | None = None) -> ClosedLoop:
    arm = SimulatedArm(world, robot("panda"), pose_at(-0.55, 0.0, 0.0))
    return ClosedLoop.simulated(world, arm, cameras or around((0.0, 0.0, 0.03)), goal)


def test_a_goal_that_holds_already_needs_no_action(world):
    world.add(shapes.block("blue"), pose_at(0.0, 0.0, 0.0))
    world.add(shapes.block("green"), pose_at(0.0, 0.0, 0.0502))
    world.settle()
    record = loop(world, "green on blue").run()
    assert record.success and record.steps == () and record.violations == ()


def test_an_arm_that_stands_in_something_does_not_move(world):
    world.add(shapes.box("shelf", (0.12, 0.12, 0.55)), pose_at(-0.24, 0.0, 0.0))
    afar = Camera.looking_at((1.0, 0.8, 0.9), (-0.2, 0.0, 0.3))
    record = loop(world, "free shelf", [afar]).run()
    assert not record.success and record.steps == ()
    assert "the arm starts in collision" in record.violations[0] and "inside shelf" in record.violations[0]


def test_what_is_out_of_reach_is_named(world):
    world.add(shapes.can("can"), pose_at(0.45, 0.0, 0.0))
    world.settle()
    record = loop(world, "free can").run()
    assert not record.success and record.steps == ()
    assert "cannot move can" in record.violations[0] and "out of reach" in record.violations[0]


@pytest.mark.slow
def test_an_interrupted_demo_leaves_its_report(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-m", "topple.planner.cli.main", "demo", "dishes", "-o", str(tmp_path)],
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        # a shell starts what it puts in the background deaf to Ctrl-C, and children inherit that
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as done:
        assert done.stderr is not None
        for line in done.stderr:  # until it acts
            if ": remove " in line:
                break
        time.sleep(1.0)
        done.send_signal(signal.SIGINT)
        assert done.wait(120) == 130
    run = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert run["interrupted"] and not run["success"]
    assert any("interrupted after" in text for text in run["violations"])
    assert "interrupted after" in (tmp_path / "report.html").read_text(encoding="utf-8")
