"""How few moves turn one arrangement into another, on instances that others published, against simple ways.

Given by `--data DIR` as `DIR/rearrange`:

- `mort`: cubes in up to seven layers (Xu, Gao, Feng, Yu, "Optimal and Stable Multi-Layer Object Rearrangement
  on a Tabletop", IROS 2023). Solved is what has as few moves as the bound proves; every arrangement on the
  way is set up in PyBullet at 10 cm a unit, where nothing may move by 1 cm or 10 degrees in a second; but
  not where the given start or goal would fall itself with its masses two millimetres aside.
- `trlb`: discs in a square (Gao, Lau, Huang, Bekris, Yu, "Fast High-Quality Tabletop Rearrangement in Bounded
  Workspace", ICRA 2022): any two files of one density and number are start and goal. Solved is what has its
  buffers within the square, after ten seconds at most; every move is checked for overlaps.

Without the data the same is made up: cubes and discs placed at random, from `--seed`.

The baselines move whatever can go to its goal, and where nothing can, put something out of the way: greedy
best-first what most others wait for, random topological anything that is free to go.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import permutations
from pathlib import Path
from statistics import mean
from time import perf_counter
from typing import Any

import networkx as nx
import numpy as np

from topple.benchmarks.cubes import cubes_problem, falling_cubes
from topple.benchmarks.discs import Discs, Put, check, rearrange_discs
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.scores import share
from topple.planner.rearranging.moves import contract, fewest_moves
from topple.planner.rearranging.problem import Move, Problem, To
from topple.planner.tolerances import DISTURBED, TURNED
from topple.robots import shapes
from topple.robots.poses import angle_between
from topple.robots.scenarios.scenario import pose_at
from topple.robots.tolerances import TOLERANCES
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray

SIDE = 0.6
"""Edge of a published cube, in its unit."""

UNIT = 0.1
"""[m] that a unit stands for."""

MARGIN = 2 * TOLERANCES.margin / UNIT
"""In their unit, two millimetres: simulated cubes have round edges, of both that meet. What needs masses more
precise than that to stand is told apart."""

SECONDS = 10.0
CUBES = {5: ">= 100", 10: ">= 100", 20: ">= 100", 30: None, 40: None}
DENSITIES = ("0.2", "0.3", "0.4")
RULES = ("greedy best-first", "random topological")

Places = Mapping[str, FloatArray]


def rows(quick: bool, seed: int, progress: Progress, *, data: Path | None = None) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Fewer and smaller instances.
        seed: Of what is drawn.
        progress: Called before each part.
        data: A folder with `rearrange/mort` and `rearrange/trlb`.

    Returns:
        The bench's rows.
    """
    found: list[Row] = []
    for count, bar in CUBES.items():
        if not quick or count <= 20:
            progress(f"{count} cubes")
            pairs = list(_cubes(data, count, seed))[: 3 if quick else None]
            found += _cube_rows(pairs, count, bar, seed)
    for density in DENSITIES:
        for count in (10, 20, 30):
            progress(f"{count} discs at density {density}")
            discs = list(_discs(data, density, count, seed))[: 3 if quick else None]
            found += _disc_rows(discs, f"{count} discs at density {density}", seed)
    return [row.to_json() for row in found]


def _cube_rows(
    pairs: Sequence[tuple[Places, Places]], count: int, bar: str | None, seed: int
) -> Iterable[Row]:
    lengths, bounds, seconds, stood = list[int](), list[int](), list[float](), list[bool]()
    theirs: dict[str, list[int]] = {rule: [] for rule in RULES}
    given = 0
    for start, goal in pairs:
        problem = cubes_problem(start, goal, SIDE)
        begun = perf_counter()
        best = fewest_moves(problem)
        seconds.append(perf_counter() - begun)
        assert problem.check(best.moves) is None, problem.check(best.moves)
        lengths.append(len(best.moves))
        bounds.append(best.bound)
        if count <= 20 and all(not _marginal(places) for places in (start, goal)):
            given += 1
            stood += _stands(start, goal, best.moves)
        for rule, moves in _by_rule(problem, seed).items():
            assert problem.check(moves) is None, problem.check(moves)
            theirs[rule].append(len(moves))
    optimal = [length == bound for length, bound in zip(lengths, bounds, strict=True)]
    what = f"{count} cubes"
    for rule in RULES:
        same = sum(length == bound for length, bound in zip(theirs[rule], bounds, strict=True))
        least, beside = bar if rule == RULES[0] else None, (rule, same, len(bounds))
        yield share(f"{what}: as few moves as the bound", sum(optimal), len(optimal), least, against=beside)
    for rule in RULES:
        yield Row(f"{what}: moves beyond the bound", _beyond(lengths, bounds), "%", rule,
                  _beyond(theirs[rule], bounds), bar="<= 3" if rule == RULES[0] else None)  # fmt: skip
    yield Row(f"{what}: moves, mean", mean(lengths), "", "the bound", mean(bounds))
    yield Row(f"{what}: longest time", max(seconds), "s", bar="<= 30")
    if stood:
        yield Row(f"{what}: given starts and goals that both stand", given, f"of {len(pairs)}")
        yield share(f"{what}: of these, arrangements on the way that stand", sum(stood), len(stood), ">= 100")


def _disc_rows(instances: Sequence[Discs], what: str, seed: int) -> Iterable[Row]:
    ours, seconds = list[tuple[int, int] | None](), list[float]()
    theirs: dict[str, list[tuple[int, int] | None]] = {rule: [] for rule in RULES}
    for discs in instances:
        begun = perf_counter()
        found = rearrange_discs(discs, SECONDS, seed)
        seconds.append(perf_counter() - begun)
        if found is not None:
            assert check(discs, found.puts) is None, check(discs, found.puts)
        bound = len(discs.start) if found is None else found.bound
        ours.append(None if found is None else (len(found.puts), bound))
        for rule in RULES:
            puts = _discs_by_rule(discs, rule, np.random.default_rng(seed))
            theirs[rule].append(None if puts is None else (len(puts), bound))
    solved = [one is not None for one in ours]
    for rule in RULES:
        others = rule, sum(one is not None for one in theirs[rule]), len(theirs[rule])
        least = ">= 95" if rule == RULES[0] else None
        yield share(f"{what}: solved within the square", sum(solved), len(solved), least, against=others)
    for rule in RULES:
        yield Row(f"{what}: moves beyond the bound", _over(ours), "%", rule, _over(theirs[rule]),
                  bar="<= 5" if rule == RULES[0] else None)  # fmt: skip
    yield Row(f"{what}: longest time", max(seconds), "s")


def _over(each: Sequence[tuple[int, int] | None]) -> float:
    solved = [one for one in each if one is not None]
    return _beyond([one[0] for one in solved], [one[1] for one in solved]) if solved else 100.0


def _beyond(lengths: Sequence[int], bounds: Sequence[int]) -> float:
    return 100.0 * (sum(lengths) / max(sum(bounds), 1) - 1.0)


def _cubes(data: Path | None, count: int, seed: int) -> Iterator[tuple[Places, Places]]:
    """Published pairs of arrangements, or such as are drawn."""
    if data is None:
        rng = np.random.default_rng([seed, count])
        for _ in range(12):
            yield _drawn_cubes(rng, count), _drawn_cubes(rng, count)
        return
    for path in sorted((data / "rearrange" / "mort").glob(f"start_{count}_*.txt"), key=lambda p: p.name):
        yield _read(path), _read(path.with_name(path.name.replace("start", "goal")))


def _read(path: Path) -> Places:
    lines = (line.partition(":") for line in path.read_text(encoding="utf-8").splitlines() if line.strip())
    return {name.strip(): np.array([float(part) for part in rest.split(",")]) for name, _, rest in lines}


def _drawn_cubes(rng: np.random.Generator, count: int) -> Places:
    """Cubes dropped in turn, each to the table or where the middle of a lower one carries it."""
    places: dict[str, FloatArray] = {}
    width = SIDE * float(np.sqrt(2.2 * count))
    while len(places) < count:
        spot = rng.uniform(0.0, width, 2)
        under = [p for p in places.values() if (abs(p[:2] - spot) < SIDE).all()]
        top = max((p[2] for p in under), default=-SIDE / 2)
        carriers = [p for p in under if p[2] == top]
        if not under or any((abs(p[:2] - spot) < SIDE / 4).all() for p in carriers):
            places[str(len(places))] = np.array([*spot, top + SIDE])
    return places


def _discs(data: Path | None, density: str, count: int, seed: int) -> Iterator[Discs]:
    """Published arrangements of discs in pairs, or such as are drawn."""
    if data is None:
        rng = np.random.default_rng([seed, count, round(10 * float(density))])
        radius = float(np.sqrt(1e6 * float(density) / (np.pi * count)))
        for _ in range(4):
            start, goal = _drawn_discs(rng, count, radius), _drawn_discs(rng, count, radius)
            yield Discs(start, goal, radius, (1000.0, 1000.0))
        return
    files = sorted((data / "rearrange" / "trlb").glob(f"disc_{density}_{count}_*.json"))
    read = [json.loads(path.read_text(encoding="utf-8")) for path in files]
    for a, b in permutations(read, 2):
        size = float(a["Workspace_Width"]), float(a["Workspace_Height"])
        start, goal = (np.array(one["point_list"], dtype=np.float64) for one in (a, b))
        yield Discs(start, goal, float(a["Object_Radius"]), size)


def _drawn_discs(rng: np.random.Generator, count: int, radius: float) -> FloatArray:
    while True:
        places: list[FloatArray] = []
        for _ in range(200 * count):
            spot = rng.uniform(radius, 1000.0 - radius, 2)
            if all(float(np.linalg.norm(spot - other)) > 2 * radius for other in places):
                places.append(spot)
            if len(places) == count:
                return np.array(places)


def _by_rule(problem: Problem, seed: int) -> dict[str, list[Move]]:
    """Moves by the rules of thumb."""
    rng = np.random.default_rng(seed)
    rules: dict[str, Callable[[list[str], nx.DiGraph[Any]], str]] = {
        RULES[0]: lambda free, waits: max(free, key=lambda n: (waits.out_degree(("take", n)), n)),
        RULES[1]: lambda free, waits: free[int(rng.integers(len(free)))],
    }
    return {name: _moves(problem, rule) for name, rule in rules.items()}


def _moves(problem: Problem, rule: Callable[[list[str], "nx.DiGraph[Any]"], str]) -> list[Move]:
    """What can go to its goal goes there; else the rule says what is put out of the way."""
    waits = contract(problem, (*problem.moving, *problem.staying))
    aside, moves = set[str](), list[Move]()
    left = set(problem.moving)
    while left:
        ready = [
            name
            for name in sorted(left)
            if (name in aside or waits.in_degree(("take", name)) == 0)
            and not set(waits.predecessors(("put", name))) - {("take", name)}
        ]
        if ready:
            name = ready[0]
            waits.remove_nodes_from([("take", name), ("put", name)])
            left.remove(name)
            moves.append(Move(name, To.GOAL))
            continue
        free = [n for n in sorted(left - aside) if waits.in_degree(("take", n)) == 0]
        name = rule(free, waits)
        waits.remove_node(("take", name))
        aside.add(name)
        moves.append(Move(name, To.BUFFER))
    return moves


def _discs_by_rule(discs: Discs, rule: str, rng: np.random.Generator) -> list[Put] | None:
    """Moves within the square by a rule of thumb; None where there is no room, or no end to it."""
    places, puts, grid = discs.start.copy(), list[Put](), discs.grid()
    while (there := np.linalg.norm(places - discs.goal, axis=1) > 0).any():
        away = np.flatnonzero(there)
        meets = np.linalg.norm(discs.goal[:, None] - places[None], axis=2) < 2 * discs.radius * (1 - 1e-9)
        np.fill_diagonal(meets, False)
        ready = [int(k) for k in away if not meets[k].any()]
        if ready:
            disc, spot = ready[0], discs.goal[ready[0]]
        else:
            blocking = meets[away].sum(axis=0)
            disc = int(np.argmax(blocking)) if rule == RULES[0] else int(rng.choice(away))
            apart = np.linalg.norm(grid[:, None] - np.delete(places, disc, axis=0)[None], axis=2).min(axis=1)
            room = np.flatnonzero(apart > 2 * discs.radius)
            if len(room) == 0 or len(puts) > 10 * len(places):
                return None
            spot = grid[int(rng.choice(room))]
        x, y = spot.tolist()
        puts.append(Put(disc, (x, y), buffer=not ready))
        places[disc] = spot
    return puts


def _marginal(places: Places) -> bool:
    """Whether some cube tips with masses two millimetres aside, where simulation need not agree."""
    return bool(falling_cubes(places, SIDE, MARGIN)(frozenset(places), frozenset()))


def _stands(start: Places, goal: Places, moves: Sequence[Move]) -> list[bool]:
    """Whether each arrangement on the way stands in simulation; what is buffered stands far away."""
    width = 3 * UNIT * float(max(np.abs(place).max() for place in (*start.values(), *goal.values())))
    with World() as world:
        reach = 2 * (width + 2 * SIDE * UNIT * (len(start) + 1))
        world.add_table(size=(reach, reach))
        aside = {name: np.array([width + k * 2 * SIDE * UNIT, 0.0, 0.0]) for k, name in enumerate(start)}
        now = {name: _base(place) for name, place in start.items()}
        for name, place in now.items():
            world.add(shapes.block(name, SIDE * UNIT), pose_at(*_xyz(place)))
        verdicts: list[bool] = []
        for move in moves:
            now[move.object] = _base(goal[move.object]) if move.to is To.GOAL else aside[move.object]
            poses = {name: pose_at(*_xyz(place)) for name, place in now.items()}
            for name, pose in poses.items():
                world.place(name, pose)
            world.step(round(1.0 / world.time_step))
            verdicts.append(
                all(
                    float(np.linalg.norm((world.pose(name) - pose)[:3, 3])) <= DISTURBED
                    and angle_between(world.pose(name), pose) <= TURNED
                    for name, pose in poses.items()
                )
            )
    return verdicts


def _base(centre: FloatArray) -> FloatArray:
    """Where the middle of a cube's underside is [m]."""
    return UNIT * (centre - [0.0, 0.0, SIDE / 2])


def _xyz(place: FloatArray) -> tuple[float, float, float]:
    x, y, z = place.tolist()
    return x, y, z
