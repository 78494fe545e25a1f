import json

import numpy as np

from topple.planner.motion.benchmark import rows
from topple.planner.motion.collision import Checker
from topple.planner.motion.one_by_one import OneByOne
from topple.planner.motion.problems import clutter
from topple.robots.catalog import robot


def test_the_baseline_checker_gives_the_same_answers() -> None:
    arm = robot("panda")
    rng = np.random.default_rng(3)
    checker = Checker(arm, np.eye(4), clutter(rng, 6))
    q = rng.uniform(arm.lower, arm.upper, (500, 7))
    assert np.array_equal(OneByOne(arm, checker.model).all(q), checker.free(q))


def test_rows_are_complete_and_no_certified_path_touches() -> None:
    said: list[str] = []
    found = rows(quick=True, progress=said.append)
    json.dumps(found)
    by_name = {row["what"]: row for row in found}
    keys = {"what", "value", "unit", "baseline", "baseline_value", "ratio", "bar", "ok"}
    assert all(set(row) == keys for row in found)
    assert by_name["disagreements on 2000 states"]["value"] == 0
    for kind in ("pick", "transfer"):
        assert by_name[f"{kind}: paths that touch something, looked at every 0.002 rad"]["value"] == 0
    assert said
