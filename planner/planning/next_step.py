"""The next thing to do for a goal: which object, why, and a collision-free transfer of it.

Planning a whole sequence and running one in closed loop ask the same question again: of the scene as it
should be by then, and of the scene as it is seen.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import takewhile

import numpy as np

from topple.planner.decide.arrange import Order
from topple.planner.decide.goal import Action, Goal, Place, PlaceRelation, holds, parse_goal
from topple.planner.decide.turn import may_begin, may_go, why_first
from topple.planner.errors import NoSafePlan
from topple.planner.failure import TransferFailure
from topple.planner.fallbacks import Relaxation
from topple.planner.placement.drops import pick_staying
from topple.planner.placement.placement import Placement
from topple.planner.placement.stacking import over, placements_on
from topple.planner.placement.tolerances import GENTLE
from topple.planner.planning.holding import HoldPlanner
from topple.planner.planning.step import Chooser, Context, NextStep, Task
from topple.planner.planning.tolerances import CHOICE, MORE_CHOICE
from topple.planner.planning.transfers import MORE_HANDS, Transfers
from topple.planner.transfer.limits import TRANSFER_LIMITS, TransferLimits
from topple.planner.transfer.transfer import Transfer
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


class StepChooser:
    """Chooses the next step in one situation.

    Args:
        situation: What is seen, or what should be there by now.
        goal: What shall hold in the end.
        context: What it is chosen in: a freed target stays free, and nothing is taken out of the way twice.
    """

    def __init__(self, situation: Situation, goal: Goal, context: Context) -> None:
        self.situation, self.scene, self.goal, self.context = situation, situation.scene, goal, context
        self._needed: set[str] = set()  # what orders said has to be taken
        self.transfers = Transfers(situation, context)

    def unmet(self) -> tuple[str, ...]:
        """Say what is still missing for the goal."""
        free = [f"{name} is not free" for name in self._not_free()]
        return (*free, *self.goal.unmet(self.situation.relations, self.scene.fixed, self.situation.supports))

    def choose(self) -> NextStep | None:
        """The next step; None where nothing is left to do.

        Raises:
            NoSafePlan: Something is left to do, and nothing that may be done now can be.
        """
        gone = set[str]() if self.context.away is None else {name for name, _ in self.context.done}
        lost = [name for name in self.goal.names if name not in self.scene.clouds and name not in gone]
        if lost and self.unmet():
            raise NoSafePlan(words := f"{', '.join(lost)}: seen nowhere any more", (words,))
        step = self._step_to_goal()
        return None if step is None else step.first()

    def _step_to_goal(self) -> NextStep | None:
        if targets := self._not_free():
            return self.take_off(targets, Action.FREE)
        inside = self.goal.contents(self.situation.relations, self.scene.fixed) if self.goal.empty else {}
        if held := [name for names in inside.values() for name in names]:
            return self.take_off(held, Action.FREE)
        for place in self.goal.places:
            planned = not self.context.observed and (place.object, Action.PLACE) in self.context.done
            if not planned and not holds(place, self.situation.relations, self.situation.supports):
                return self._place(place)
        return None

    def _not_free(self) -> list[str]:
        return [name for name in self.goal.free if (name, Action.FREE) not in self.context.done]

    def take_off(self, targets: Sequence[str], action: Action, why: str = "") -> NextStep:
        """The step that gets on with freeing some targets.

        Raises:
            NoSafePlan: There is none, whatever is tried.
        """
        chosen = self._order(targets)
        failures: list[TransferFailure] = []
        longer = partial(self._in_turn, chosen, targets, action, why, [], longer=True)
        step = (
            self._in_turn(chosen, targets, action, why, failures)
            or self._by(Relaxation.MAKE_ROOM, partial(self._make_room, failures))
            or self._by(Relaxation.LOOK_LONGER, longer)
        )
        if step is not None:
            return step
        explained = tuple(self.transfers.explain(failure) for failure in failures)
        waiting = f"each of {', '.join(chosen.order)} has to go before another one"
        held = (f"with a second hand, {hold.sentence(chosen.order)}" for hold in chosen.holds)
        words = (*(tuple(str(failure) for failure in explained) or (waiting,)), *held)
        raise NoSafePlan("; ".join(words), words, explained)

    def _in_turn(
        self,
        chosen: Order,
        targets: Sequence[str],
        action: Action,
        why: str,
        failures: list[TransferFailure],
        longer: bool = False,
    ) -> NextStep | None:
        """The first object of an order that may go and can be taken; what the others fail of is noted.

        One at which the hand would come in unseen waits for the others: the next look may show more.
        """
        unseen: NextStep | None = None
        for name in self._alone(chosen):
            found = self.transfers.aside(name, self._still_needed(name), longer=longer)
            if isinstance(found, Transfer):
                is_target = name in targets
                reason = (why or "nothing has to go before it") if is_target else why_first(name, chosen)
                role = action if is_target else Action.REMOVE
                held = [hold.sentence(chosen.order) for hold in chosen.holds if hold.since == name]
                said = "; ".join([reason, *held, *map(str, failures)])
                fallbacks = (Relaxation.ANOTHER_FIRST,) if failures else ()
                step = NextStep(found, role, said, chosen, fallbacks=fallbacks)
                if not found.grasp.unseen:
                    return step
                unseen = unseen or step
            else:
                failures.append(found)
                if Relaxation.ANOTHER_FIRST not in self.context.relaxations:
                    return unseen
        if unseen is not None:
            return unseen
        holds = [hold for hold in chosen.holds if may_begin(hold, chosen)]
        if self.context.second is None or longer or not holds:
            return None
        hold = min(holds, key=lambda each: chosen.order.index(each.since))
        held = HoldPlanner(
            hold, chosen, self.situation, self.context, self._still_needed,
            lambda name: action if name in targets else Action.REMOVE,
        ).steps()  # fmt: skip
        if isinstance(held, NextStep):
            return replace(held, fallbacks=(Relaxation.ANOTHER_FIRST,)) if failures else held
        failures.append(held)
        return None

    def _alone(self, chosen: Order) -> list[str]:
        """Objects that may go now; with a second arm none from where that has to hold something on."""
        begins = {hold.since for hold in chosen.holds} if self.context.second is not None else set[str]()
        return list(takewhile(lambda name: name not in begins, may_go(chosen)))

    def _make_room(self, failures: Sequence[TransferFailure]) -> NextStep | None:
        """Take away an object that bars the way to one that could not be taken, or stands beside it.

        Nothing goes twice to make room, so this comes to an end.
        """
        barred = {failure.object for failure in failures}
        for failure in failures:
            for other in self.transfers.barriers(failure):
                step = self._taken_away(other, barred, f"it is in the way to {failure.object} ({failure})")
                if step is not None:
                    return step
        return None

    def _taken_away(self, other: str, barred: Collection[str], why: str) -> NextStep | None:
        """The first step to take an object away, once, that is about none of the barred ones."""
        try:
            chosen = self._order([other])
        except NoSafePlan:
            return None
        for first in self._alone(chosen):
            if first in barred or (first, Action.REMOVE) in self.context.done:
                continue
            found = self.transfers.aside(first, self._still_needed(first))
            if isinstance(found, Transfer):
                return NextStep(found, Action.REMOVE, why, chosen)
        return None

    def _place(self, place: Place) -> NextStep:
        """The object to where the goal wants it, or first what has to go before it or is in the way there."""
        name, where = place.object, place.where
        if place.how == PlaceRelation.ON and (others := self._standing_on(place)):
            return self.take_off(others, Action.REMOVE, f"it is where {name} goes")
        chosen = self._order([name])
        if len(chosen.order) > 1:
            return self.take_off([name], Action.PLACE)
        if (later := self._stands_on_later(place)) is not None:
            why = f"{later} below it has to come out before {name} is put there"
            return self.take_off([where], Action.REMOVE, why)
        contents = self._in_the_way(place) if place.how == PlaceRelation.WITHIN else []
        return self._place_in_spots(place, chosen, contents)

    def _place_in_spots(self, place: Place, chosen: Order, contents: Sequence[str]) -> NextStep:
        """The object to the best spots; into a vessel with contents only where it pushes none of them.

        Raises:
            NoSafePlan: No way works, of the contents out in their safe order neither.
        """
        name, failed = place.object, list[TransferFailure]()
        done, stuck = (name, Action.PLACE) in self.context.done, list[NoSafePlan]()

        def into(spots: Sequence[Placement], limits: TransferLimits) -> NextStep | None:
            room = [spot for spot in spots if spot.drop <= GENTLE]
            if done and contents:
                room = []  # it was tried, and it is not there: more room is needed
            found = self.transfers.to(name, room, limits) if room else no_room(place)
            if isinstance(found, Transfer):
                return NextStep(found, Action.PLACE, f"it goes {place.how} {place.where}", chosen)
            failed.append(found)
            return None

        def straight() -> NextStep | None:
            every, gentle, kept = self.spots(place, CHOICE)
            return into(gentle if contents else gentle or kept or every, TRANSFER_LIMITS)

        def empty() -> NextStep | None:
            try:
                return self.take_off(contents, Action.REMOVE, f"{name} needs room in {place.where}")
            except NoSafePlan as error:
                stuck.append(error)
                return None

        def longer() -> NextStep | None:
            return into(self.spots(place, MORE_CHOICE)[1], MORE_HANDS)

        step = straight()
        if contents:
            step = step or self._by(Relaxation.LOOK_LONGER, longer) or self._by(Relaxation.EMPTY, empty)
        if step is not None:
            return step
        raise stuck[0] if stuck else NoSafePlan(str(failed[-1]), (str(failed[-1]),), (failed[-1],))

    def _by(self, name: Relaxation, attempt: Callable[[], NextStep | None]) -> NextStep | None:
        """Make an attempt, under the name of its relaxation, where that may be tried."""
        step = attempt() if name in self.context.relaxations else None
        return None if step is None else replace(step, fallbacks=(name, *step.fallbacks))

    def spots(self, place: Place, limit: int) -> tuple[list[Placement], list[Placement], list[Placement]]:
        """Where an object could go, where it stays there and pushes nothing, and all where it stays."""
        name, where = place.object, place.where
        found = placements_on(name, self.situation, where, place.how, limit=limit)
        if place.how != PlaceRelation.WITHIN:
            return found, found, found
        lying = [other for other in self.transfers.inside(where) if other != name]
        return found, *pick_staying(found, name, where, self.situation, lying)

    def _stands_on_later(self, place: Place) -> str | None:
        """An object that a later placement moves and that comes out only once the base is off: base first."""
        for later in self.goal.places[self.goal.places.index(place) + 1 :]:
            if later.object != place.where and (later.object, Action.PLACE) not in self.context.done:
                if place.where in self._order([later.object]).order:
                    return later.object
        return None

    def _in_the_way(self, place: Place) -> list[str]:
        """Objects in a container that do not belong there."""
        settled = {other.object for other in self.goal.places if other.where == place.where}
        return [
            other for other in self.transfers.inside(place.where) if other not in settled | {place.object}
        ]

    def _standing_on(self, place: Place) -> tuple[str, ...]:
        """Objects on a supporter that are not to stand there."""
        settled = {other.object for other in self.goal.places if other.where == place.where}
        return tuple(
            support.supported
            for support in self.situation.supports
            if support.supporter == place.where
            and support.supported not in settled
            and (support.kind == "rests" or over(self.situation, support.supported, place.where))
        )

    def _order(self, targets: Sequence[str]) -> Order:
        situation = self._with_riders(targets)
        chosen = self.context.ask(situation, targets)
        if chosen.unresolved:
            cycles = tuple(f"cycle: {words}" for words in chosen.certificate)
            raise NoSafePlan(f"no safe order frees {', '.join(targets)}: {cycles[0]}", cycles)
        self._needed.update(chosen.order)
        return chosen

    def _with_riders(self, targets: Sequence[str]) -> Situation:
        """The situation to order: what rides in a container that is kept upright is one thing with it."""
        scene = self.scene
        for name in self.context.upright:
            riders = [rider for rider in self.transfers.riders(name) if rider not in targets]
            for rider in riders:
                cloud = np.vstack([scene.clouds[name], scene.clouds[rider]])
                together: dict[str, float] = {}
                if name in scene.masses or rider in scene.masses:
                    guessed = {one: self.situation.statics.weights[one].mass for one in (name, rider)}
                    together = {name: sum({**guessed, **scene.masses}[one] for one in (name, rider))}
                scene = scene.without(rider).with_cloud(name, cloud).weighed(together)
        return self.situation if scene is self.scene else Situation(scene)

    def _still_needed(self, name: str) -> frozenset[str]:
        """Objects still to be taken once one is gone, or to have something put on or into them."""
        left = (place for place in self.goal.places if (place.object, Action.PLACE) not in self.context.done)
        named = {other for place in left for other in (place.object, place.where)}
        return frozenset(named.union(self._needed, self._not_free()) - {name})


@dataclass(frozen=True)
class GoalTask:
    """A task in words, or as names of what is to be freed: see `topple.planner.decide.goal.parse_goal`."""

    words: str | Collection[str]

    @staticmethod
    def of(goal: str | Collection[str] | Task) -> Task:
        """Make a task of a goal; a task stays as it is."""
        return goal if isinstance(goal, Task) else GoalTask(goal)

    def in_frame(self, _pose: FloatArray, _up: FloatArray, /) -> Task:
        """The same: words hold in any frame."""
        return self

    def goal(self, scene: Scene) -> Goal:
        """The goal, read for a scene."""
        return parse_goal(self.words, scene)

    def chooser(self, situation: Situation, goal: Goal, context: Context) -> Chooser:
        """Make the chooser of the steps."""
        return StepChooser(situation, goal, context)


def no_room(place: Place) -> TransferFailure:
    """That an object would not stay where it shall go."""
    return TransferFailure.no_place(place.object, f"{place.object} would not stay {place.how} {place.where}")
