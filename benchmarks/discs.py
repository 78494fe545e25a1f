"""Rearranging discs within a bounded workspace: the fewest moves, with room for every buffer.

A disc that passes through a buffer needs a spot that nothing takes between its two moves. The order of the
moves says what is where at any time, so spots are looked for on a grid in the free area of the whole time;
where no spot is free that long, the disc moves on to another one when it has to. Orders and equally good
choices of what is buffered are drawn until no move is spent beyond the bound, as TRLB (Gao, Lau, Huang,
Bekris, Yu, "Fast High-Quality Tabletop Rearrangement in Bounded Workspace", ICRA 2022) does with its lazy
buffers.
"""

import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from topple.planner.rearranging.moves import Buffers, sequence
from topple.planner.rearranging.problem import Act, Move, Pair, Problem, To
from topple.topology.base.arrays import FloatArray, freeze
from topple.topology.base.errors import InvalidInput

SECONDS = 30.0
"""[s] after which the shortest sequence so far is taken."""

GRID = 90
"""Places looked at along each edge of a workspace: a tenth of the radius of the discs that fill it."""


@dataclass(frozen=True, eq=False)
class Discs:
    """Discs of one size on a rectangle, where they are and where they shall be.

    Attributes:
        start: (N, 2) centres; any unit of length.
        goal: (N, 2) centres in the goal.
        radius: Of every disc.
        size: (width, height) of the rectangle, which has a corner at the origin; discs lie within it.

    Raises:
        InvalidInput: The arrays do not fit each other, or discs overlap.
    """

    start: FloatArray
    goal: FloatArray
    radius: float
    size: tuple[float, float]

    def __post_init__(self) -> None:
        """Check shapes and overlaps."""
        if self.start.shape != self.goal.shape or self.start.ndim != 2 or self.start.shape[1] != 2:
            raise InvalidInput(
                f"starts of shape {self.start.shape} and goals of {self.goal.shape}: expected (N, 2) of both"
            )
        for what, places in (("starts", self.start), ("goals", self.goal)):
            object.__setattr__(self, what[:-1], freeze(places))
            apart = np.linalg.norm(places[:, None] - places[None], axis=2) + np.eye(len(places)) * 1e9
            if (apart < 2 * self.radius * (1 - 1e-9)).any():
                a, b = np.argwhere(apart < 2 * self.radius)[0]
                raise InvalidInput(f"the {what} of discs {a} and {b} overlap: move them apart")

    def problem(self) -> Problem:
        """What must be taken before what can be put."""
        near = np.linalg.norm(self.start[:, None] - self.goal[None], axis=2) < 2 * self.radius * (1 - 1e-9)
        pairs: set[Pair] = {
            ((Act.TAKE, str(a)), (Act.PUT, str(b))) for a, b in np.argwhere(near).tolist() if a != b
        }
        return Problem(tuple(map(str, range(len(self.start)))), (), frozenset(pairs))

    def grid(self) -> FloatArray:
        """(K, 2) spots a disc may have."""
        axes = [np.linspace(self.radius, side - self.radius, GRID) for side in self.size]
        return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)


@dataclass(frozen=True)
class Put:
    """One pick and place of a disc.

    Attributes:
        disc: Its row.
        place: (x, y) of its centre afterwards.
        buffer: Whether it only makes room.
    """

    disc: int
    place: tuple[float, float]
    buffer: bool


@dataclass(frozen=True)
class Puts:
    """Moves that rearrange discs.

    Attributes:
        puts: First to do first.
        bound: No sequence of moves is shorter, however large the workspace.
    """

    puts: tuple[Put, ...]
    bound: int


def rearrange_discs(discs: Discs, seconds: float = SECONDS, seed: int = 0) -> Puts | None:
    """Find the shortest sequence of moves with every buffer within the workspace.

    Args:
        discs: Where they are and shall be.
        seconds: How long to look for a sequence as short as the bound; then the best so far is taken.
        seed: Of the orders that are drawn.

    Returns:
        The moves; None where none were found in this time.
    """
    deadline = time.monotonic() + seconds
    problem, rng, grid = discs.problem(), np.random.default_rng(seed), discs.grid()
    programme = Buffers(problem)
    chosen = programme.solve()
    best: list[Put] | None = None
    number = 0
    while best is None or len(best) > programme.bound:
        if time.monotonic() > deadline:
            break
        if number:
            draw = dict(zip(problem.moving, rng.random(len(problem.moving)).tolist(), strict=True))
            if number % 4 == 0:
                aside = programme.costs * (1 + 0.9 / len(problem.moving) * rng.random(len(programme.costs)))
                chosen = programme.solve(aside)
            moves = sequence(problem, chosen, draw.__getitem__)
        else:
            moves = sequence(problem, chosen)
        found = _with_room(discs, moves, grid, rng)
        if found is not None and (best is None or len(found) < len(best)):
            best = found
        number += 1
    return None if best is None else Puts(tuple(best), programme.bound)


@dataclass(frozen=True, eq=False)
class _Taken:
    """Spots that are taken for a time: (M, 2) centres, and (M,) from when until when."""

    places: FloatArray
    since: FloatArray
    until: FloatArray


def _with_room(
    discs: Discs, moves: Sequence[Move], grid: FloatArray, rng: np.random.Generator
) -> list[Put] | None:
    """The moves with spots for what is buffered; None where at some time there is none.

    Move k happens at time 2 k, what moves on before it does so at 2 k - 1.
    """
    count = len(discs.start)
    take, put = np.zeros(count), np.zeros(count)
    for k, move in reversed(list(enumerate(moves))):
        take[int(move.object)] = 2 * k
    for k, move in enumerate(moves):
        put[int(move.object)] = 2 * k
    places = [*discs.start, *discs.goal]
    since, until = [*np.full(count, -np.inf), *put], [*take, *np.full(count, np.inf)]
    timed: list[tuple[float, Put]] = []
    for k, move in enumerate(moves):
        disc = int(move.object)
        if move.to is To.GOAL:
            x, y = discs.goal[disc].tolist()
            timed.append((2.0 * k, Put(disc, (x, y), buffer=False)))
            continue
        now = 2.0 * k
        while now < put[disc]:
            taken = _Taken(np.array(places), np.array(since), np.array(until))
            spot, last = _spot(discs, taken, grid, now, float(put[disc]), {disc, count + disc}, rng)
            if spot is None:
                return None
            x, y = spot.tolist()
            timed.append((now, Put(disc, (x, y), buffer=True)))
            places.append(spot)
            since.append(now)
            until.append(last)
            now = last
    return [each for _, each in sorted(timed, key=lambda one: one[0])]


def _spot(
    discs: Discs,
    taken: _Taken,
    grid: FloatArray,
    now: float,
    end: float,
    own: Collection[int],
    rng: np.random.Generator,
) -> tuple[FloatArray | None, float]:
    """The spot that stays free longest, and until when; of several one that has others close."""
    far = np.linalg.norm(grid[:, None] - taken.places[None], axis=2)
    others = np.array(
        [k not in own and taken.until[k] > now and taken.since[k] < end for k in range(len(taken.since))]
    )
    meets = (far < 2 * discs.radius) & others
    comes = np.where(taken.since > now, taken.since - 1, now)
    free_until = np.where(meets, comes, end).min(axis=1)
    longest = float(free_until.max())
    if longest <= now:
        return None, now
    best = np.flatnonzero(free_until == longest)
    close = np.where(others, far[best], np.inf)
    rank = np.sort(close, axis=1)[:, :2].sum(axis=1) * rng.uniform(0.8, 1.2, len(best))
    return grid[best[int(np.argmin(rank))]], longest


def check(discs: Discs, puts: Sequence[Put]) -> str | None:
    """What is wrong with moves, in words: an overlap, the workspace's edge, or a goal not reached.

    Args:
        discs: Where they are and shall be.
        puts: First to do first.
    """
    places = discs.start.copy()
    for number, put in enumerate(puts, start=1):
        spot = np.array(put.place)
        apart = np.linalg.norm(places - spot, axis=1)
        apart[put.disc] = np.inf
        if (spot < discs.radius - 1e-6).any() or (spot > np.array(discs.size) - discs.radius + 1e-6).any():
            return f"move {number} puts disc {put.disc} beyond the edge"
        if apart.min() < 2 * discs.radius * (1 - 1e-9):
            return f"move {number} puts disc {put.disc} onto disc {int(np.argmin(apart))}"
        places[put.disc] = spot
    left = np.linalg.norm(places - discs.goal, axis=1) > 1e-9
    return f"disc {int(np.argmax(left))} is not at its goal" if left.any() else None
