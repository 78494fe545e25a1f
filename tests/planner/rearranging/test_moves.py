"""The fewest moves, against every sequence of moves."""

from itertools import permutations

import numpy as np
import pytest

from topple.benchmarks.cubes import cubes_problem
from topple.benchmarks.discs import Discs, check, rearrange_discs
from topple.planner import NoSafePlan
from topple.planner.rearranging.moves import fewest_moves
from topple.planner.rearranging.problem import Act, Move, Problem, To
from topple.planner.rearranging.steady import brace
from topple.topology import InvalidInput

TAKE, PUT = Act.TAKE, Act.PUT


def drawn(seed: int, count: int) -> Problem:
    """What must come before what in some start and some goal, and places that are taken."""
    rng = np.random.default_rng(seed)
    names = [str(k) for k in range(count)]
    first, last = rng.permutation(count), rng.permutation(count)
    couples = list(permutations(names, 2))
    pairs = {
        pair
        for a, b in couples
        for pair, likely in (
            (((TAKE, a), (TAKE, b)), 0.2 * (first[int(a)] < first[int(b)])),
            (((PUT, a), (PUT, b)), 0.2 * (last[int(a)] < last[int(b)])),
            (((TAKE, a), (PUT, b)), 0.3),
        )
        if rng.random() < likely
    }
    stays = count // 4 if seed % 3 == 0 else 0
    return Problem(tuple(names[stays:]), tuple(names[:stays]), frozenset(pairs))


def by_every_sequence(problem: Problem) -> int | None:
    """Length of the shortest sequence, level by level over all states; None where there is none."""
    names = (*problem.moving, *problem.staying)
    start = tuple("start" for _ in names)
    frontier, seen, depth = {start}, {start}, 0

    def done(state: tuple[str, ...]) -> bool:
        where = dict(zip(names, state, strict=True))
        kept = {name for name in problem.staying if where[name] == "start"}
        late = any(
            then in {(PUT, n) for n in kept} and first[1] not in kept for first, then in problem.before
        )
        return not late and all(where[name] == "goal" for name in names if name not in kept)

    while frontier:
        if any(map(done, frontier)):
            return depth
        depth += 1
        following = {
            (*state[:k], to, *state[k + 1 :])
            for state in frontier
            for k, where in enumerate(state)
            for to in ("buffer", "goal")
            if where != "goal" and where != to and allowed(problem, names, state, k, to)
            if not (where == "start" and to == "goal" and names[k] in problem.staying)
        }
        frontier = following - seen
        seen |= frontier
    return None


def allowed(problem: Problem, names: tuple[str, ...], state: tuple[str, ...], k: int, to: str) -> bool:
    """Whether all that has to happen before this move has, what stays counting as put but not as taken."""
    where = dict(zip(names, state, strict=True))

    def happened(event: tuple[Act, str]) -> bool:
        act, name = event
        if name == names[k] and act is TAKE:
            return True
        if act is TAKE:
            return where[name] != "start"
        return where[name] == "goal" or (name in problem.staying and where[name] == "start")

    events = [(TAKE, names[k])] if state[k] == "start" else []
    events += [(PUT, names[k])] if to == "goal" else []
    return all(happened(first) for first, then in problem.before if then in events)


@pytest.mark.parametrize("seed", range(60))
def test_no_sequence_is_shorter(seed):
    problem = drawn(seed, 3 + seed % 4)
    best = by_every_sequence(problem)
    if best is None:
        with pytest.raises(NoSafePlan, match="cycle"):
            fewest_moves(problem)
        return
    found = fewest_moves(problem)
    assert problem.check(found.moves) is None
    assert len(found.moves) == best
    assert found.optimal


def test_two_things_that_change_places_take_one_buffer():
    problem = Problem(("a", "b"), (), frozenset({((TAKE, "a"), (PUT, "b")), ((TAKE, "b"), (PUT, "a"))}))
    found = fewest_moves(problem)
    assert (len(found.moves), found.bound, len(found.in_buffers)) == (3, 3, 1)


def test_what_stays_is_moved_only_where_something_must_get_by():
    under = frozenset({((TAKE, "lid"), (TAKE, "box")), ((PUT, "box"), (PUT, "lid"))})
    assert len(fewest_moves(Problem(("box",), ("lid",), under)).moves) == 3
    assert fewest_moves(Problem(("box",), ("lid",), frozenset({((PUT, "lid"), (PUT, "box"))}))).moves == (
        Move("box", To.GOAL),
    )


def test_a_tower_is_turned_over_in_place_and_beside():
    start = {str(k): np.array([0.0, 0.0, k + 0.5]) for k in range(4)}
    goal = {str(k): np.array([0.0, 0.0, 3 - k + 0.5]) for k in range(4)}
    problem = cubes_problem(start, goal, 1.0)
    assert len(fewest_moves(problem).moves) == by_every_sequence(problem)
    aside = {name: place + np.array([3.0, 0.0, 0.0]) for name, place in goal.items()}
    assert len(fewest_moves(cubes_problem(start, aside, 1.0)).moves) == 4


def test_a_counterweight_comes_before_its_load_and_a_second_one_only_where_needed():
    def falling(there: frozenset[str], held: frozenset[str]) -> frozenset[str]:
        return frozenset({"beam"} if "load" in there and "weight" not in there else ())

    below = [("foot", "beam"), ("beam", "load"), ("beam", "weight"), ("beam", "more")]
    graph = brace(["foot", "beam", "load", "more", "weight"], below, falling)
    assert set(graph.edges) - set(below) == {("weight", "load")}


def test_a_cycle_that_no_buffer_opens_is_named():
    problem = Problem(("a", "b"), (), frozenset({((TAKE, "a"), (TAKE, "b")), ((TAKE, "b"), (TAKE, "a"))}))
    with pytest.raises(NoSafePlan, match="take b before take a before take b"):
        fewest_moves(problem)


def test_an_object_nobody_knows_is_refused():
    with pytest.raises(InvalidInput, match="c"):
        Problem(("a",), (), frozenset({((TAKE, "c"), (PUT, "a"))}))


@pytest.mark.parametrize("seed", range(4))
def test_discs_get_where_they_shall_be_with_every_buffer_in_the_workspace(seed):
    rng = np.random.default_rng(seed)
    spots = np.array([(x, y) for x in (2.0, 5.0, 8.0) for y in (2.0, 5.0, 8.0)])
    start, goal = (spots[rng.permutation(9)[:6]] for _ in range(2))
    discs = Discs(start, goal, 1.2, (10.0, 10.0))
    found = rearrange_discs(discs, 5.0)
    assert found is not None
    assert check(discs, found.puts) is None
    best = by_every_sequence(discs.problem())
    assert found.bound == best
    assert len(found.puts) <= best + 1


def test_wrong_moves_of_discs_are_told():
    discs = Discs(np.array([[2.0, 2.0], [5.0, 5.0]]), np.array([[5.0, 5.0], [2.0, 2.0]]), 1.0, (10.0, 10.0))
    found = rearrange_discs(discs, 5.0)
    assert found is not None
    assert "is not at its goal" in str(check(discs, found.puts[:-1]))
    assert all(check(discs, puts) for puts in permutations(found.puts) if puts != found.puts)


def test_discs_that_overlap_are_refused():
    with pytest.raises(InvalidInput, match="overlap"):
        Discs(np.array([[2.0, 2.0], [3.0, 2.0]]), np.array([[2.0, 2.0], [6.0, 2.0]]), 1.0, (10.0, 10.0))
