"""What a run remembers of its actions: what was done, what failed, and what the looks made of the scene."""

from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

from topple.planner.decide.beliefs import Beliefs
from topple.planner.decide.goal import Action
from topple.planner.grasp.grasp import Grasp
from topple.planner.planning.step import Context, NextStep


@dataclass(frozen=True, eq=False)
class Memory:
    """Kept from action to action; what it will be after one that is only planned can be asked as well.

    Attributes:
        done: Steps that were done, as (object, action).
        attempts: Tries at each object since something was taken out of its way.
        tried: Objects that the arm has tried to take.
        failed: Grasps that failed, by object.
        placed: Grasps by which an object was put where it shall be, as it lies since, the last one last.
        beliefs: What the looks made of the scene.
    """

    done: tuple[tuple[str, str], ...] = ()
    attempts: Counter[str] = field(default_factory=Counter[str])
    tried: frozenset[str] = frozenset()
    failed: Mapping[str, tuple[Grasp, ...]] = field(default_factory=dict[str, tuple[Grasp, ...]])
    placed: Mapping[str, tuple[Grasp, ...]] = field(default_factory=dict[str, tuple[Grasp, ...]])
    beliefs: Beliefs = field(default_factory=Beliefs)

    def failures(self, name: str) -> int:
        """How many of the tries at an object did not do what was meant."""
        return self.attempts[name] - len(self.placed.get(name, ()))

    def after_action(self, chosen: NextStep, success: bool, stuck: bool = False) -> "Memory":
        """Remember the outcome of a step, before the look that follows.

        Args:
            chosen: The step.
            success: Whether it was done.
            stuck: Whether the hand does not let go: no other grasp is to be tried then.
        """
        name = chosen.transfer.object
        tried, attempts = self.tried | {name}, self.attempts + Counter((name,))
        if success:
            if chosen.action is not Action.PLACE:  # what shall stay there and does not is tried again
                attempts = Counter[str]()  # what could not be taken may be now that this is out of its way
            done = (*self.done, (name, str(chosen.action)))
            return replace(self, done=done, attempts=attempts, tried=tried, placed=self._grasps(chosen))
        if stuck:
            return replace(self, attempts=attempts, tried=tried)
        failed = dict(self.failed)
        for one in (chosen.transfer, chosen.grip):  # nobody knows which of two hands it was
            if one is not None:
                failed[one.object] = (*failed.get(one.object, ()), one.grasp)
        return replace(self, attempts=attempts, tried=tried, failed=failed)

    def _grasps(self, chosen: NextStep) -> Mapping[str, tuple[Grasp, ...]]:
        """The grasps by which things were put where they shall be, after one more step."""
        transfer, name = chosen.transfer, chosen.transfer.object
        others = {other: some for other, some in self.placed.items() if other != name}
        if chosen.action is not Action.PLACE:
            return others  # what made room lies elsewhere, and nobody looked whether it turned in the hand
        pose = transfer.placement.pose_before_to_after
        some = (*self.placed.get(name, ()), transfer.grasp)
        return {**others, name: tuple(one.move(pose) for one in some)}

    def after_look(
        self,
        chosen: NextStep,
        success: bool,
        surprises: Collection[str] = (),
        changed: Collection[str] = (),
        moved: Collection[str] = (),
    ) -> "Memory":
        """Remember the outcome of the look after a step.

        Args:
            chosen: The step.
            success: Whether it was done.
            surprises: Objects that were not seen where they should be.
            changed: Those of them that were seen elsewhere.
            moved: What moved as the object was lifted, which was put back then.
        """
        handled = {chosen.transfer.object, *chosen.transfer.riding}
        alone = handled if success and chosen.action is not Action.PLACE else ()
        beliefs = self.beliefs.after(chosen.order.chances, handled | set(surprises), alone)
        changed = {*changed, *(handled if success else ())}
        return replace(self, beliefs=beliefs.learn(changed, moved, chosen.transfer.object))

    def context(self, asked: Context, most: int) -> Context:
        """Make the context in which the next step is chosen.

        Args:
            asked: The same without what is remembered. Grasps of the caller's own count until the object was
                tried.
            most: Failed attempts at one object after which it is given up, or twice as many in all.
        """
        given_up = {
            name: f"{n} attempts failed" if self.failures(name) >= most else f"tried {n} times, misplaced"
            for name, n in self.attempts.items()
            if self.failures(name) >= most or n >= 2 * most
        }
        own = {name: some for name, some in asked.grasps.items() if name not in self.tried}
        return replace(
            asked, done=self.done, observed=True, given_up=given_up, avoid=self.failed, placed=self.placed,
            beliefs=self.beliefs, grasps=own, seed=asked.seed + self.attempts.total(),
        )  # fmt: skip
