"""Picking: which object to take next, as a Gymnasium environment."""

from copy import deepcopy
from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from topple.planner.decide.goal import Goal, parse_goal
from topple.planner.environment.hands import put, take
from topple.planner.environment.tolerances import EFFORT
from topple.planner.environment.view import Observation, show, space_of
from topple.planner.execution.attained import truly_unmet
from topple.planner.execution.look import Observer
from topple.robots import scenario
from topple.robots.scenarios import Scenario
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.rigid import move_points
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

SLOTS = 12  # more than any built-in scene has objects
SAMPLES, TABLE_SAMPLES = 1500, 10_000  # points of a whole surface, as fine as cameras see them
SEEDS = 2**31


class Picking(gymnasium.Env[Observation, np.int64]):
    """Takes things out of a settled scene one after the other, until its goal is reached.

    An action is the slot of the object to take next; `action_mask` says which there are, and one that may not
    be taken does nothing. Whether the goal is reached is told from the world's own poses and forces, not from
    relations. What the goal puts somewhere (the lemon) is put there, all else is taken away.
    Hands are ideal: lifts are straight and rigid, nothing else is touched. The reward of a step is 1 where
    the goal is reached by it, less 0.05 for the effort, less 1 for each other object that moved by more than
    1 cm or 10 degrees. An episode ends with the goal, or where a thing that it needs is lost.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 1}  # noqa: RUF012 (as Gymnasium declares it)

    def __init__(
        self,
        scenario: str = "pile",
        cameras: int = 0,
        slots: int = SLOTS,
        points: int = 0,
        render_mode: str | None = None,
    ) -> None:
        """Say what is played; nothing is simulated before `reset`.

        Args:
            scenario: One of `topple.robots.scenarios.SCENARIOS`, whose goal frees or puts things.
            cameras: How many noisy depth cameras look on, 1 to 3; 0 shows the whole surfaces as they are,
                which is three times as fast.
            slots: How many objects there may be.
            points: How many points of each cloud are shown.
            render_mode: "rgb_array", or None.

        Raises:
            InvalidInput: An argument is none of these.
        """
        if not 0 <= cameras <= 3 or slots < 1 or points < 0:
            raise InvalidInput(
                f"cameras={cameras}, slots={slots}, points={points}: expected 0 to 3, 1 or more, 0 or more"
            )
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InvalidInput(f"render_mode={render_mode!r}: expected 'rgb_array' or None")
        self.render_mode = render_mode
        self._scenario, self._cameras, self._slots, self._points = scenario, cameras, slots, points
        self.observation_space = space_of(slots, points)
        self.action_space = gymnasium.spaces.Discrete(slots)
        self._stage: Scenario | None = None
        self._goal = Goal("")
        self._names: tuple[str, ...] = ()
        self._taken: set[str] = set()
        self._situation: Situation | None = None
        self._steps = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Settle a scene.

        Args:
            seed: Of this and all later episodes.
            options: {"scene": N} plays the scene of that seed, as `topple demo --seed N` does.

        Returns:
            The observation, and `names` of the slots, `goal` and `scene`.

        Raises:
            InvalidInput: The scene has more objects than there are slots.
        """
        super().reset(seed=seed)
        self.close()
        number = int((options or {}).get("scene", self.np_random.integers(SEEDS)))
        self._stage = stage = scenario(self._scenario, number)
        names = sorted(stage.world.movable)
        if len(names) > self._slots:
            raise InvalidInput(f"{self._scenario} {number} has {len(names)} objects: give slots={len(names)}")
        self._names = tuple(str(name) for name in self.np_random.permutation(names))  # no slot tells anything
        self._taken, self._steps = set(), 0
        rng = np.random.default_rng(int(self.np_random.integers(SEEDS)))
        self._eyes = Observer(stage.world, stage.cameras[: self._cameras], rng, stage.fixed, stage.up)
        self._situation = self._look()
        self._goal = parse_goal(stage.goal, self._whole(stage))
        self._shown = self._observation()
        return deepcopy(self._shown), {"names": self._names, "goal": stage.goal, "scene": number}

    def step(self, action: np.int64) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Take the object of a slot, or put it where the goal says.

        Args:
            action: The slot.

        Returns:
            Observation, reward, whether the goal is reached or cannot be any more, whether the episode is cut
            off after three times as many steps as there are objects, and `object`, `disturbed`, `reached`.
        """
        stage = self._stage
        if stage is None:
            raise InvalidInput("step before reset: call reset() first")
        self._steps += 1
        disturbed: tuple[str, ...] = ()
        name = self._names[action] if action < len(self._names) else ""
        allowed = bool(self.action_masks()[action])
        if allowed:
            place = next((place for place in self._goal.places if place.object == name), None)
            if place is not None:
                disturbed = put(stage.world, name, place.where)
            else:
                disturbed = take(stage.world, name)
                self._taken.add(name)
            self._situation = self._look()
            self._shown = self._observation()
        reached = allowed and self._is_reached(stage)
        lost = any(
            one not in stage.world.names for one in self._goal.names if one not in self._taken
        ) or not any(self.action_masks())
        reward = float(reached) - EFFORT - len(disturbed)
        info = {"object": name if allowed else None, "disturbed": disturbed, "reached": reached}
        cut = self._steps >= 3 * len(self._names)
        return deepcopy(self._shown), reward, reached or lost, cut and not reached, info

    def action_masks(self) -> NDArray[np.bool_]:
        """(slots,) which objects may be taken: those seen, but for what the goal puts things into."""
        mask = np.zeros(self._slots, dtype=np.bool_)
        mask[: len(self._names)] = [self._takeable(name) for name in self._names]
        return mask

    def render(self) -> NDArray[np.uint8] | None:  # type: ignore[override] # Gymnasium's own type is open
        """(H, W, 3) what the first camera sees; None without `render_mode`."""
        if self.render_mode is None or self._stage is None:
            return None
        return self._stage.cameras[0].picture(self._stage.world)

    def close(self) -> None:
        """End the simulation."""
        if self._stage is not None:
            self._stage.world.close()
            self._stage = None

    def _takeable(self, name: str) -> bool:
        kept = {place.where for place in self._goal.places}
        return self._situation is not None and name in self._situation.movable and name not in kept

    def _is_reached(self, stage: Scenario) -> bool:
        if any(name not in self._taken for name in self._goal.free):
            return False
        rest = replace(self._goal, free=())  # what is free is out of the world
        return not truly_unmet(rest, stage.world, stage.up)

    def _look(self) -> Situation | None:
        """Observe the scene; None where nothing that can move is seen."""
        stage = self._stage
        if stage is None or not stage.world.movable:
            return None
        scene = self._eyes.look().scene if self._cameras else self._whole(stage)
        return Situation(scene) if scene.movable else None

    def _whole(self, stage: Scenario) -> Scene:
        """Every surface all around, always the same points of it."""
        clouds = {}
        for name in stage.world.names:
            pose, count = stage.world.pose(name), TABLE_SAMPLES if name in stage.fixed else SAMPLES
            points = stage.world.body(name).surface(count, np.random.default_rng(0))
            clouds[name] = move_points(points, pose)
        return Scene(clouds, stage.fixed, stage.up)

    def _observation(self) -> Observation:
        takeable = {name: self._takeable(name) for name in self._names}
        rng = np.random.default_rng(0)
        return show(self._situation, self._names, self._goal.names, takeable, self._slots, self._points, rng)
