"""Scenes of others: `topple check` on the 130 tasks of LIBERO, against what MuJoCo lets happen there.

Lifelong-Robot-Learning/LIBERO (MIT) builds its tasks with robosuite, in an environment of its own:

    python3.11 -m venv .peers/libero
    .peers/libero/bin/pip install mujoco==3.3.0 robosuite==1.4.1 bddl easydict gym matplotlib
    .peers/libero/bin/python benchmarks/peers/libero_scenes.py CHECKOUT DIR

DIR has for each task the world as MJCF, three stored states and these after 4 s as keyframes, with what moved
in the second after each and the pairs that press on each other at rest. `--data DIR` reads that. What moves
by more than 1 cm or 10 degrees does not stand; what moves by less than 1 mm and 1 degree stands; between the
two, and of what is in something else and stays, neither recall nor precision is counted, but how often it
is said not to stand.
"""

import json
from collections import Counter, defaultdict
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from topple.benchmarks.row import Progress, Row
from topple.benchmarks.scores import share
from topple.planner.simulate.tolerances import STAYS, STAYS_TURNED
from topple.planner.stability.check import StabilityCheck, check
from topple.planner.stability.verdicts import Verdict
from topple.planner.tolerances import DISTURBED, TURNED
from topple.topology.base.errors import InvalidInput, ToppleError
from topple.topology.io.load import load_scene

SAMPLED = 13
"""With --quick every so-many task counts."""
PRESSES = 0.01
"""Share of what all presses on an object together below which a pair only touches: it carries nothing."""


def fate(moved: tuple[float, float]) -> bool | None:
    """Whether what moved so far [mm, degrees] stands; None where that is not clear."""
    far, turned = 1e-3 * moved[0], moved[1]
    if far > DISTURBED or turned > float(np.degrees(TURNED)):
        return False
    return True if far < STAYS and turned < STAYS_TURNED else None


def count_verdicts(found: StabilityCheck, moved: Mapping[str, tuple[float, float]]) -> Counter[str]:
    """Compare verdicts with what moved [mm, degrees]."""
    told: Counter[str] = Counter()
    for name, each in found.objects.items():
        stands = fate(moved[name])
        told["objects"] += 1
        if stands is None or (stands and each.verdict is Verdict.PENETRATES):
            told["unclear"] += 1
            told["unclear, told"] += not each.stands
        else:
            told["moves"] += not stands
            told["told"] += not stands and not each.stands
            told["vain"] += stands and not each.stands
    return told


def pairs_of(contacts: list[tuple[str, str, float]]) -> set[frozenset[str]]:
    """The pairs that press on each other, without what bears next to nothing of either."""
    load: dict[str, float] = defaultdict(float)
    for a, b, force in contacts:
        load[a] += force
        load[b] += force
    return {frozenset((a, b)) for a, b, force in contacts if force > PRESSES * min(load[a], load[b])}


def count_contacts(found: StabilityCheck, contacts: list[tuple[str, str, float]]) -> Counter[str]:
    """Compare what carries what with the pairs that press on each other [N], where any are given."""
    if not contacts:
        return Counter()
    carries = [(name, c.name, c.force) for name, each in found.objects.items() for c in each.carried_by]
    ours, theirs = pairs_of(carries), pairs_of(contacts)
    return Counter({"right": len(ours & theirs), "false": len(ours - theirs), "missed": len(theirs - ours)})


def rows(quick: bool, seed: int, progress: Progress, data: Path | None = None) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: One task of 13 alone.
        seed: Which ones.
        progress: Called before each task.
        data: The folder that `libero_scenes.py` wrote.

    Raises:
        InvalidInput: Nothing of it is there.
    """
    tasks = [] if data is None else sorted(data.glob("*.json"))
    if not tasks:
        raise InvalidInput(
            "libero needs --data DIR: the folder that benchmarks/peers/libero_scenes.py writes"
        )
    told: Counter[str] = Counter()
    wrong: list[str] = []
    for task in tasks[seed % SAMPLED :: SAMPLED] if quick else tasks:
        progress(task.stem)
        told["tasks"] += 1
        try:
            for state in json.loads(task.read_text("utf-8"))["states"]:
                found = check(load_scene(task.with_suffix(".xml"), keyframe=state["key"]))
                counts = count_verdicts(found, state["moved"])
                counts |= count_contacts(found, state.get("contacts", []))
                told += counts
                if counts["vain"] + counts["false"] + counts["missed"] or counts["told"] < counts["moves"]:
                    moved = {name: state["moved"][name] for name in found.objects}
                    wrong.append(f"{task.stem} {state['key']}: {found.sentence()}; moved {moved}")
            told["read"] += 1
        except ToppleError as error:
            wrong.append(f"{task.stem}: {error}")
    return [row.to_json() for row in _rows(told, wrong)]


def _rows(told: Mapping[str, int], wrong: list[str]) -> list[Row]:
    bad = told["false"] + told["missed"]
    return [
        _share("tasks that are read and checked", told["read"], told["tasks"], "100"),
        _share("pairs at rest that carry: false or missed", bad, told["right"] + bad, "<= 1"),
        _share("recall of what moves within 1 s", told["told"], told["moves"], ">= 98", wrong=wrong[:12]),
        _share("precision of what is said not to stand", told["told"], told["told"] + told["vain"], ">= 95"),
        _share("neither, and said not to stand", told["unclear, told"], told["unclear"], None),
    ]


_share = partial(share, counted=True)
