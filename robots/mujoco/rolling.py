"""What resists rolling and spinning on MuJoCo: friction in the joint of each body, by what presses on it.

A contact of MuJoCo's has one cone for all that it resists: what slides in it rolls freely. Fruit that is
wedged in a bowl then gives way where on PyBullet it stays.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from topple.robots.mujoco.model import Shape
from topple.robots.mujoco.tolerances import HARD, STIFF
from topple.robots.world.touch import combined_friction


class Rolling:
    """Keeps what resists the turning of each body at what its contacts make of it, step by step.

    It is turning in the world: of two that roll on each other, each resists for itself. Contacts of an arm
    are left out: what it holds turns with the hand, by the cone of the pads.

    Args:
        model: MuJoCo's model.
        shapes: What collides in it, by name.
        turning: Name of each body that moves -> the first of its three degrees of freedom that turn.
    """

    def __init__(self, model: Any, shapes: Mapping[str, Shape], turning: Mapping[str, int]) -> None:
        own = {name: k for k, name in enumerate(turning)}
        every = [shapes[model.geom(k).name] for k in range(model.ngeom)]
        self._model = model
        self._frictions = np.array([one.frictions * (not one.robot) for one in every]).reshape(-1, 3).T
        self._owner = np.array([own.get(one.owner, -1) for one in every], dtype=int)
        self._turning = np.array(list(turning.values()), dtype=int)[:, None] + np.arange(3)
        model.dof_solref[self._turning], model.dof_solimp[self._turning] = STIFF, HARD

    def after_step(self, data: Any) -> None:
        """Take what presses now for what will in the next step."""
        found = data.contact
        pressing = np.flatnonzero(found.efc_address >= 0)
        a, b = found.geom[pressing].T
        _, _, lever = combined_friction(self._frictions[:, a], self._frictions[:, b])
        moments = lever * data.efc_force[found.efc_address[pressing]]
        resisted = np.zeros(len(self._turning))
        for one in (a, b):
            moved = self._owner[one] >= 0
            np.add.at(resisted, self._owner[one][moved], moments[moved])
        self._model.dof_frictionloss[self._turning] = resisted[:, None]
