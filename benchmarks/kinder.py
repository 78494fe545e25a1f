"""Tasks of others: KinDER's Obstruction3D-o4 and Packing3D-p3 (RSS 2026), planned at once and played there.

A Gen3 with a 2F-85 puts a block on a region where four others lie, and three parts with pegs into a rack. Its
engine moves what the hand holds, undoes a motion that touches anything, and takes hold of the one object that
is where the pads meet, with a hand that comes in wide open; so do the grasps here. A plan has one try. Where
the parts go in the rack is drawn here; where the blocks that bar the region go is left to the plan.

    python3.11 -m venv .peers/kinder
    .peers/kinder/bin/pip install kindergarden

Its parts begin 1 cm above its table, level with the rack's floor: here the table is that much higher.
"""

import json
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from topple.benchmarks.peers import python_of
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.scores import share
from topple.planner.errors import NoSafePlan
from topple.planner.formats.plan_structs import PlacementData
from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.grasp import Grasp
from topple.planner.placement.resting import about
from topple.planner.planning.plan import plan
from topple.planner.planning.plan_format import Plan
from topple.planner.rearranging.arrangement import Arrangement
from topple.planner.rearranging.task import ArrangementTask
from topple.robots import robot
from topple.robots.arm.arm import Arm
from topple.robots.collision.fcl_bodies import apart
from topple.robots.poses import pose_from
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, ToppleError
from topple.topology.bodies.solids import move_parts
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.samples import sampled_with_normals
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

OBSTRUCTION, PACKING = "Obstruction3D-o4", "Packing3D-p3"
SEEDS, QUICK = 50, 2

SPACING = 0.003
"""[m] of the points on an object; on what is fixed they are twice as far apart."""

DEEP = 0.03
"""[m] of the table below its top; the rest of it is out of reach."""

ROOM = 0.01
"""[m] between parts in the rack, and to its walls: two cells of the heights that a part is lowered onto."""

BESIDE = 0.02
"""[m] that what lies on the region is to be off the block's place: a finger."""

HEADINGS, TRIES, AGAIN = 8, 20_000, 0.02
"""Of a part in the rack, how often places are drawn, and the share of failures after which all are anew."""

THINNED = 0.05
"""[rad] that a joint turns by between the states that are sent."""

HANDS = {"grasp": -1.0, "release": 1.0}


def rows(quick: bool, seed: int, progress: Progress) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Two seeds of each.
        seed: The first.
        progress: Called before each plan.

    Raises:
        InvalidInput: KinDER is not installed.
    """
    python = python_of("kinder")
    if python is None:
        raise InvalidInput("kinder needs kindergarden in .peers/kinder: see topple/benchmarks/kinder.py")
    seeds = list(range(seed, seed + (QUICK if quick else SEEDS)))
    found = [row for name in (OBSTRUCTION, PACKING) for row in _rows_of(name, seeds, python, progress)]
    return [row.to_json() for row in found]


def _rows_of(name: str, seeds: Sequence[int], python: Path, progress: Progress) -> list[Row]:
    progress(f"{name}: starts")
    given = _asked(python, {"asked": {"environment": name, "seeds": seeds}}, "starts")
    arm, base = robot(given["urdf"]), pose_from(given["base"][:3], given["base"][3:])
    seconds, plans, wrong = list[float](), list[dict[str, Any]](), list[str]()
    for episode in given["episodes"]:
        progress(f"{name}, seed {episode['seed']}")
        begun = process_time()
        try:
            made = planned(name, episode, arm, base, given["start"])
            plans.append({"seed": episode["seed"], "pieces": pieces(made)})
        except NoSafePlan as error:
            wrong.append(f"{name}, seed {episode['seed']}: {error}")
        seconds.append(process_time() - begun)
    progress(f"{name}: playing")
    played = _asked(python, {"plans": {"environment": name, "plans": plans}}, "played")
    wrong += [
        f"{name}, seed {one['seed']}: {one['why'] or 'at its end, goal not reached'}"
        for one in played
        if not one["reached"]
    ]
    held = sum(one["reached"] for one in played)
    return [
        share(f"{name}: goals reached", held, len(seeds), "100", counted=True, wrong=wrong),
        *(
            Row(f"{name}: CPU of a plan, {what}", float(np.quantile(seconds, part)), "s")
            for what, part in (("median", 0.5), ("worst", 1.0))
        ),
    ]


def _asked(python: Path, given: Mapping[str, Any], wanted: str) -> Any:
    """What KinDER says, run by the Python that has it."""
    script = Path(__file__).with_name("peers") / "kinder_episodes.py"
    with tempfile.TemporaryDirectory() as folder:
        for name, document in given.items():
            (Path(folder) / f"{name}.json").write_text(json.dumps(document), encoding="utf-8")
        run = subprocess.run([python, script, folder], capture_output=True, text=True, check=False)
        if run.returncode:
            raise ToppleError(f"kinder in {python} failed; it said: {run.stderr.strip()[-300:]}")
        return json.loads((Path(folder) / f"{wanted}.json").read_text(encoding="utf-8"))


def planned(
    name: str, episode: Mapping[str, Any], arm: Arm, base: FloatArray, start: Sequence[float]
) -> list[Plan]:
    """Plan an episode: what bars the block's place, then the block; or the parts at once.

    Args:
        name: Of the environment.
        episode: Its seed, parts of its objects, and which are fixed.
        arm: Of the environment.
        base: (4, 4) where it stands.
        start: (7,) its joints [rad].

    Raises:
        NoSafePlan: There is none.
    """
    parts = {key: [np.array(each) for each in some] for key, some in episode["parts"].items()}
    top = parts["table"][0][:, 2].max()
    if name == PACKING:
        parts["rack"] = parts["rack"][1:]  # its floor is as high as what the parts begin on
        top = min(corners[:, 2].min() for key in parts if key.startswith("part") for corners in parts[key])
    parts["table"][0][:, 2] = np.where(parts["table"][0][:, 2] < 0.0, top - DEEP, top)
    clouds = {key: seen(some, key in episode["fixed"]) for key, some in parts.items()}
    now = Situation(Scene(clouds, fixed=episode["fixed"], up=(0, 0, 1), robot_base=base))
    grasps = {key: open_wide(key, now.scene, arm) for key in now.scene.movable}
    options: dict[str, Any] = {"robot": arm, "q_start": np.array(start), "grasps": grasps}
    if name == PACKING:
        return [plan(now.scene, ArrangementTask(Arrangement(packed(parts, now))), **options)]
    pose = centred(parts)
    block = move_parts(parts["target_block"], pose)
    barring = [key for key in now.movable if not apart(now.solids[key], block, BESIDE)]
    made = list[Plan]()
    if barring := [key for key in barring if key != "target_block"]:
        made.append(plan(now.scene, barring, **options))
        for step in made[0].steps:
            now = now.moved((step.object,), lowered(step.placement))
        options["q_start"] = pieces(made)[-1][2][-1]
    goal = Arrangement(now.moved(("target_block",), pose))
    return [*made, plan(now.scene, ArrangementTask(goal), **options)]


def seen(parts: Sequence[FloatArray], fixed: bool) -> FloatArray:
    """Points (N, 3) of an object's whole surface; of what is fixed without undersides, as cameras have it."""
    points, normals = sampled_with_normals(parts, 2.0 * SPACING if fixed else SPACING)
    return points[normals[:, 2] > -0.5] if fixed else points


def lowered(placed: PlacementData) -> FloatArray:
    """(4, 4) motion to where an object lies once it was let go."""
    pose = np.array(placed.pose_before_to_after)
    pose[2, 3] -= placed.drop
    return pose


def open_wide(name: str, scene: Scene, arm: Arm) -> list[Grasp]:
    """Grasps of an object on what is fixed, the hand as wide as it opens all the way in."""
    alone = Scene({key: scene.clouds[key] for key in (name, *scene.fixed)}, fixed=scene.fixed, up=scene.up)
    widest = arm.open_hand.opening
    return [replace(grasp, opening=widest) for grasp in grasp_candidates(name, alone, arm)]


def centred(parts: Mapping[str, Sequence[FloatArray]]) -> FloatArray:
    """(4, 4) motion of the block to the middle of the region."""
    block, region = parts["target_block"][0], parts["target_region"][0]
    pose = np.eye(4)
    pose[:3, 3] = region.mean(axis=0) - block.mean(axis=0)
    pose[2, 3] = region[:, 2].max() - block[:, 2].min()
    return pose


def packed(parts: Mapping[str, Sequence[FloatArray]], now: Situation) -> Situation:
    """The parts in the rack, at the first places drawn at which their plates have room.

    Raises:
        NoSafePlan: None were found.
    """
    rng, walls = np.random.default_rng(0), np.vstack(parts["rack"])
    thick = min(float(np.ptp(wall[:, 0])) for wall in parts["rack"]) + ROOM
    lower, upper = walls.min(axis=0)[:2] + thick, walls.max(axis=0)[:2] - thick
    names, there = [name for name in parts if name.startswith("part")], dict[str, FloatArray]()
    for _ in range(TRIES):
        name = names[len(there)]
        pose = np.eye(4)
        pose[:3, :3] = about(now.up, 2.0 * np.pi * rng.integers(HEADINGS) / HEADINGS)
        turned = move_points(parts[name][0], pose)[:, :2]
        pose[:2, 3] = rng.uniform(lower, upper - np.ptp(turned, axis=0)) - turned.min(axis=0)
        plate = move_parts(parts[name][:1], pose)
        if all(apart(plate, move_parts(parts[other][:1], there[other]), ROOM) for other in there):
            there[name] = pose
        elif rng.random() < AGAIN:
            there.clear()
        if len(there) == len(names):
            for key, place in there.items():
                now = now.moved((key,), place)
            return now
    raise NoSafePlan("no places in the rack were found", tuple(names))


def pieces(made: Sequence[Plan]) -> list[tuple[str, float, list[list[float]]]]:
    """Kind, what the hand does after it, and (k, 7) states [rad] of each piece of the plans' motions."""
    found: list[tuple[str, float, list[list[float]]]] = []
    for segment in (segment for one in made for step in one.steps for segment in step.segments):
        states = np.empty((0, 7)) if segment.motion is None else segment.motion.positions
        turned = np.cumsum(np.abs(np.diff(states, axis=0)).max(axis=1)) if len(states) else np.empty(0)
        kept = np.flatnonzero(np.diff(turned // THINNED, append=np.inf))
        found.append((str(segment.kind), HANDS.get(str(segment.kind), 0.0), states[kept + 1].tolist()))
    return found
