"""Arms of others, from the files their packages ship: read, tried, planned for and run."""

import re
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path

import pytest

from topple.benchmarks.arms import (
    BARE,
    BEGIN,
    END,
    SHIPPED,
    TRIED,
    VERDICTS,
    Shipped,
    _together,
    asked,
    planned,
)
from topple.planner.execution.examine import examine
from topple.robots.arm.torques import springs
from topple.topology.base.errors import InvalidInput, NotInstalled

DOCS = Path(__file__).parents[2] / "docs"
PAGE, ANSWERS = ((DOCS / page).read_text(encoding="utf-8") for page in ("robots.md", "transcripts/arms.md"))
ROWS = PAGE[PAGE.index(BEGIN) : PAGE.index(END)].splitlines()[3:]
LINES = ANSWERS[ANSWERS.index(BEGIN) : ANSWERS.index(END)].splitlines()[2:-2]
WORKING = [shipped for shipped in TRIED if not any(shipped.name in row and "**no**" in row for row in ROWS)]


def test_the_page_has_every_arm_and_most_work():
    assert [row.split(" | ")[0].removeprefix("| ") for row in ROWS] == [shipped.name for shipped in TRIED]
    assert len(WORKING) >= 6


def test_the_page_of_answers_has_every_arm_and_their_count():
    said = [next(verdict for verdict in VERDICTS if line.startswith(verdict)) for line in LINES]
    names = {f"{shipped.name}, {shipped.hand}" for shipped in SHIPPED}
    assert {line[14:].split(": ")[0] for line in LINES} == names and len(LINES) == len(SHIPPED)
    count = [said.count(verdict) for verdict in VERDICTS]
    assert ", ".join(f"{k} {verdict}" for k, verdict in zip(count, VERDICTS, strict=True)) + "." in ANSWERS
    assert f"of {len(LINES)} arms asked there {count[0]} are accepted" in PAGE


@pytest.mark.parametrize("name", ["Franka Panda", "PAL Talos, left arm alone", "Alex, left hand of Psyonic"])
def test_an_arm_answers_as_the_page_has_it(name):
    (shipped,) = [shipped for shipped in SHIPPED if shipped.name == name]
    verdict, words = asked(installed(shipped))
    assert f"{verdict:14}{name}, {shipped.hand}: {words}" in LINES


def test_rows_of_some_arms_replace_theirs_and_the_others_stay():
    row = ["Franka FR3", "franky-sim", "its own", "7", "0.00", "0", "0.0", "yes", "yes"]
    again = _together("\n".join(["| a |", "| - |", *ROWS]), [row])
    assert [cells[0] for cells in again] == [shipped.name for shipped in TRIED]
    others = [line for line in ROWS if "Franka FR3" not in line]
    assert [f"| {' | '.join(cells)} |" for cells in again if cells[0] != row[0]] == others
    assert row in again


def test_a_package_that_is_missing_is_named_with_what_installs_it():
    with pytest.raises(NotInstalled, match="example-robot-datum, which ships the arm, is not installed: pip"):
        Shipped("x.urdf", package="example-robot-datum").arm()
    assert all(name in BARE for name in ("franky-sim", "robosuite", "mani-skill"))
    for shipped in SHIPPED:
        if shipped.package in BARE and not is_installed(shipped.package):
            with pytest.raises(InvalidInput, match=f"{shipped.package}, which .* {re.escape(BARE)}"):
                shipped.arm()


def is_installed(package: str) -> bool:
    try:
        return distribution(package) is not None
    except PackageNotFoundError:
        return False


def installed(shipped: Shipped) -> Shipped:
    """It; skips where a package is not there, or the one that ships the hands."""
    for package in (shipped.package, "airo-models"):
        if not is_installed(package):
            pytest.skip(f"{package} is not installed")
    return shipped


@pytest.mark.slow
@pytest.mark.parametrize("shipped", WORKING, ids=lambda shipped: shipped.name)
def test_an_arm_is_understood_planned_for_and_takes_the_block(shipped):
    if find_spec("collada") is None:
        pytest.skip("pycollada is not installed: pip install '.[arms]'")
    arm = installed(shipped).arm()
    found = examine(arm)
    assert found.solved >= 0.995 * found.poses > 0
    assert found.grasped is not None and found.grasped.success, found.grasped
    assert not planned(found)


def test_the_arm_that_drops_the_block_cannot_carry_itself():
    """A PR2 rests on springs that its URDF leaves out: gravity asks more of its shoulder than its effort."""
    (shipped,) = [shipped for shipped in TRIED if shipped not in WORKING]
    arm = installed(shipped).arm()
    assert springs(arm) == ("l_shoulder_lift_joint",)
    assert any("l_shoulder_lift_joint" in words for words in arm.assumptions)
