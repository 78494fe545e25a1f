"""A step towards a goal, where the arm stands before it, and what says in which order to take things."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, cast, runtime_checkable

from topple.planner.decide.arrange import Order
from topple.planner.decide.beliefs import Beliefs
from topple.planner.decide.goal import Action, Goal
from topple.planner.fallbacks import RELAXATIONS, Relaxation
from topple.planner.grasp.given import GraspsByObject
from topple.planner.grasp.grasp import Grasp
from topple.planner.placement.away import Receiver
from topple.planner.placement.placement import Placement
from topple.planner.planning.order import check_masks, check_targets, ordered
from topple.planner.simulate.sandbox import Sandbox
from topple.planner.transfer.transfer import Transfer
from topple.robots.arm.arm import Station
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.base.plugins import Table
from topple.topology.bodies.solids import Solids
from topple.topology.relations.relate import Relations
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


@dataclass(frozen=True, eq=False)
class NextStep:
    """A step that can be done now.

    Attributes:
        transfer: What the arm does.
        action: What it is for.
        reason: Why this object and why now.
        order: The order the step was chosen from, as it is carried out: the object is the first in it.
        fallbacks: What was tried to find it where the plain way failed; with those of the transfer,
            `all_fallbacks`.
        buffer: Whether the object only makes room and is taken again later, to where it shall be.
        grip: What the other arm takes hold of before it, and keeps still from then on; its segments end as
            the hand closes.
        let_go: What the other arm lets go of after it, where it is; its segments begin as the hand opens.
        by_second: Whether the second arm does it.
        then: The steps that follow it while the other arm holds on, decided with it.
    """

    transfer: Transfer
    action: Action
    reason: str
    order: Order
    fallbacks: tuple[Relaxation, ...] = ()
    buffer: bool = False
    grip: Transfer | None = None
    let_go: Transfer | None = None
    by_second: bool = False
    then: "tuple[NextStep, ...]" = ()

    def first(self) -> "NextStep":
        """The same as the first of its order, and each that follows it as the first of what is left."""
        left = self.order.order
        steps = (self, *self.then)
        found: list[NextStep] = []
        for step in steps:
            name = step.transfer.object
            rest = [other for other in left if other != name]
            found.append(replace(step, order=step.order.as_taken((name, *rest))))
            left = rest
        return replace(found[0], then=tuple(found[1:]))

    @property
    def all_fallbacks(self) -> tuple[Relaxation, ...]:
        """Everything that it stands on."""
        return (*self.fallbacks, *self.transfer.fallbacks)


@dataclass(frozen=True, eq=False)
class Context:
    """What a step is chosen in: the arm as it stands, what went before, and what the caller asks for.

    Attributes:
        station: The arm as it stands.
        done: Steps that were done, as (object, action).
        observed: Whether the scene was looked at after what was done: what is not seen to be where it was put
            is then moved again. In a plan, what was put somewhere is there.
        given_up: Objects that are not to be tried again, with the reason.
        avoid: Grasps that failed, by object.
        barred: Places that a check refuted: none of them is tried while there are others.
        placed: Grasps by which an object was put where it shall be, as it lies since.
        beliefs: What earlier looks made of the same things.
        upright: Objects that are kept upright, with what is in them.
        allow_drop: Whether what stays nowhere the arm can put it may be let go to fall. Where the scene is
            observed it always may: the next look shows where it lies.
        relaxations: What may be tried where the plain way fails.
        orderer: What decides in which order things are taken.
        grasps: Grasps of the caller's own, in the world: an object that has an entry is taken by those alone.
        seed: Of every search.
        second: A second arm, as it stands, for what takes two; None where there is one arm.
        obstacles: Bodies that are in the arm's way and no part of the scene: those of the other arm.
        clamped: What a fixture keeps where it stands until it is taken.
        away: Where things go that are taken; to free places on what is seen where None. What went there and
            is in the way is among the obstacles.
        sandbox: The simulated world in which things are let go.
        known: What an order from before leaves, which is not asked anew for the same targets.
    """

    station: Station
    done: Sequence[tuple[str, str]] = ()
    observed: bool = False
    given_up: Mapping[str, str] = field(default_factory=dict[str, str])
    avoid: Mapping[str, Sequence[Grasp]] = field(default_factory=dict[str, Sequence[Grasp]])
    barred: Sequence[Placement] = ()
    placed: Mapping[str, Sequence[Grasp]] = field(default_factory=dict[str, Sequence[Grasp]])
    beliefs: Beliefs | None = None
    upright: frozenset[str] = frozenset()
    allow_drop: bool = False
    relaxations: Collection[str] = RELAXATIONS
    orderer: "Orderer" = ordered
    grasps: GraspsByObject = field(default_factory=dict[str, Sequence[Grasp]])
    seed: int = 0
    second: Station | None = None
    obstacles: Solids = field(default_factory=dict[str, Sequence[FloatArray]])
    clamped: frozenset[str] = frozenset()
    away: Receiver | None = None
    sandbox: Sandbox = field(default_factory=Sandbox)
    known: Order | None = None

    def ask(self, situation: Situation, targets: Sequence[str]) -> Order:
        """Ask the orderer; see `ask`."""
        if self.known is not None and self.known.targets == tuple(targets):
            return self.known
        asked: dict[str, Any] = {"seed": self.seed, "beliefs": self.beliefs}
        asked |= {} if self.second is None else {"hands": 2}
        asked |= {"clamped": tuple(self.clamped)} if self.clamped else {}
        return ask(self.orderer, situation, targets, **asked)


@runtime_checkable
class Chooser(Protocol):
    """Says in one situation what to do next for a goal."""

    def unmet(self) -> tuple[str, ...]:
        """Say what is still missing for the goal."""
        ...

    def choose(self) -> NextStep | None:
        """The next step; None where nothing is left to do.

        Raises:
            NoSafePlan: Something is left to do, and nothing that may be done now can be.
        """
        ...


@runtime_checkable
class Task(Protocol):
    """What is to be reached, and what chooses the steps to it."""

    def in_frame(self, pose: FloatArray, up: FloatArray, /) -> "Task":
        """The same in another frame.

        Args:
            pose: (4, 4) rigid transform that leads there.
            up: (3,) against gravity there.
        """
        ...

    def goal(self, scene: Scene) -> Goal:
        """State the goal: what shall hold in the end.

        Args:
            scene: What is seen at the start.

        Raises:
            InvalidInput: It is no goal for this scene.
        """
        ...

    def chooser(self, situation: Situation, goal: Goal, context: Context) -> Chooser:
        """Make the chooser of the next step in a situation.

        Args:
            situation: What is seen, or what should be there by now.
            goal: What shall hold in the end.
            context: What it is chosen in.
        """
        ...


@runtime_checkable
class Orderer(Protocol):
    """Whoever says in which order to free targets: `topple.planner.order`, or a function of your own.

    It is asked before each step, of the situation as it is by then (`scene`, `relations`): objects that were
    put aside are in it, where they were put. It takes what it needs of the keywords and leaves the others to
    `**_`: with a second arm also `hands`, how many there are, and with a fixture `clamped`, what it keeps.

    Example:
        >>> from topple.planner.planning.order import order
        >>> def careful(situation, targets, **_):
        ...     return order(situation, targets, removal_risk=0.05, check_gravity=False)
    """

    def __call__(
        self,
        situation: Situation,
        targets: Sequence[str],
        /,
        *,
        seed: int,
        beliefs: Beliefs | None = None,
    ) -> Order:
        """Order what has to be taken to free some targets.

        Args:
            situation: What is seen, or what should be there by now, and what was read of it.
            targets: Names to free, each in the scene.
            seed: Of every search.
            beliefs: What earlier looks made of the same things, in a run.

        Returns:
            An order as `topple.planner.order` gives it, or `topple.planner.arrange` makes it of a
            `DependencyGraph`, the targets and a place (3,) for each object. Of the objects that no dependency
            holds back, the first that the arm can take goes; `unresolved` cycles end the plan.
        """
        ...


ORDERERS: Table[Orderer] = Table(
    "topple.orderers",
    "orderer",
    {
        "fewest": "topple.planner.planning.order:ordered",
        "cautious": "topple.planner.planning.order:cautious",
    },
    Order,
)
"""By name: the fewest removals, as in plans, the least risk, as in runs, and what other packages add."""


def ask(orderer: Orderer, situation: Situation, targets: Sequence[str], **asked: Any) -> Order:
    """Ask an orderer, and refuse what it must not answer.

    Args:
        orderer: Whoever says in which order to take things.
        situation: What is seen.
        targets: Names to free, each in the scene.
        **asked: What it is asked with; what is plain, as one hand and no fixture, is left out.

    Raises:
        InvalidInput: Its answer is no order.
        UnknownObject: It takes what is not there, or never moves.
    """
    chosen = cast(object, cast(Callable[..., Order], orderer)(situation, targets, **asked))  # whatever it is
    scene = situation.scene
    if not isinstance(chosen, Order):
        raise InvalidInput(
            f"the orderer gave {type(chosen).__name__}, expected an Order: topple.planner.order "
            "gives one, and topple.planner.arrange makes one"
        )
    for name in chosen.order:
        if name not in scene.movable:
            raise UnknownObject(name, scene.movable, role="object in the orderer's order")
    return chosen


def order_by(
    orderer: Orderer,
    scene: Scene,
    targets: Sequence[str] | None,
    relations: Relations | None,
    seed: int,
) -> Order:
    """The order that an orderer gives of a scene.

    Args:
        orderer: What orders.
        scene: The scene.
        targets: What is to be freed; everything where None.
        relations: The scene's relations where they are known.
        seed: Of every search.

    Raises:
        InvalidInput: A target is fixed or hangs on a wrong mask, or the answer is no order.
        UnknownObject: A target, or what the answer takes, is not in the scene.
    """
    wanted = check_targets(scene, targets)
    scene = check_masks(Situation(scene, relations), wanted)
    return ask(orderer, Situation(scene, relations), wanted or scene.movable, seed=seed, beliefs=None)
