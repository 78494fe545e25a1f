"""Masses, their centres and friction by name, refused where they enter if they cannot be true."""

from collections.abc import Iterable, Mapping
from sys import float_info

import numpy as np
from numpy.typing import ArrayLike

from topple.topology.base.arrays import FloatArray, bounds, freeze
from topple.topology.base.checks import numeric
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.base.tolerances import CENTRE_OUTSIDE, HEAVIEST
from topple.topology.base.values import FrozenDict
from topple.topology.scene.friction import ROUGHEST, SLIPPERIEST


def as_masses(given: Mapping[str, float] | None, names: Iterable[str]) -> Mapping[str, float]:
    """Check the masses of objects.

    Args:
        given: Mass in [kg] by name, above 0; None for none.
        names: The objects there are.

    Returns:
        The masses, read-only.

    Raises:
        InvalidInput: If a mass is not above 0 or over a thousand tonnes; names the object.
        UnknownObject: If a name is none of the objects.
    """
    masses = _numbers(given, names, "mass", "kilograms, such as 0.35")
    for name, mass in masses.items():
        if not 0 < mass <= HEAVIEST:
            raise InvalidInput(
                f"mass of {name!r} is {mass:g} kg: expected more than 0, up to {HEAVIEST:g}; leave "
                "out what nobody weighed, and name what never moves in fixed"
            )
    return masses


def as_friction(given: Mapping[str, float] | None, names: Iterable[str]) -> Mapping[str, float]:
    """Check the coefficients of friction of objects' surfaces.

    Args:
        given: Coulomb coefficient by name, 0 to 10; None for none.
        names: The objects there are.

    Returns:
        The coefficients, read-only.

    Raises:
        InvalidInput: If one is not from 0 to 10; names the object.
        UnknownObject: If a name is none of the objects.
    """
    friction = _numbers(given, names, "friction", "a Coulomb coefficient, such as 0.5")
    for name, coefficient in friction.items():
        if not SLIPPERIEST <= coefficient <= ROUGHEST:
            raise InvalidInput(
                f"friction of {name!r} is {coefficient:g}: expected a Coulomb coefficient from "
                f"{SLIPPERIEST:g} to {ROUGHEST:g}, mostly 0.2 to 1; neither an angle nor a percentage"
            )
    return friction


def as_centres(
    given: Mapping[str, ArrayLike] | None, clouds: Mapping[str, FloatArray]
) -> Mapping[str, FloatArray]:
    """Check the centres of mass of objects.

    Args:
        given: Place (3,) in [m] by name, in the frame of the clouds; None for none.
        clouds: Points (N, 3) in [m] of the objects there are.

    Returns:
        The centres, read-only.

    Raises:
        InvalidInput: If one is no place, or far outside of its object; names the object.
        UnknownObject: If a name is none of the objects.
    """
    checked: dict[str, FloatArray] = {}
    for name, place in (given or {}).items():
        if name not in clouds:
            raise UnknownObject(name, clouds, role="object with a centre of mass")
        centre = numeric(place, f"centre of mass of {name!r}")
        if centre.shape != (3,) or not np.isfinite(centre).all():
            raise InvalidInput(
                f"centre of mass of {name!r} is {np.array2string(centre, threshold=6)}: expected three "
                "finite numbers x, y, z in metres, in the frame of the clouds"
            )
        lower, upper = bounds(clouds[name])
        slack = CENTRE_OUTSIDE * float(np.linalg.norm(upper - lower))
        if (centre < lower - slack).any() or (centre > upper + slack).any():
            raise InvalidInput(
                f"centre of mass of {name!r} is {centre.round(4).tolist()}, outside of its points, which "
                f"reach from {lower.round(4).tolist()} to {upper.round(4).tolist()}: expected it in [m] in "
                "the frame of the clouds, not in the object's own"
            )
        checked[name] = freeze(centre)
    return FrozenDict(checked)


def _numbers(
    given: Mapping[str, float] | None, names: Iterable[str], one: str, expected: str
) -> Mapping[str, float]:
    """Finite numbers by name."""
    known = frozenset(names)
    checked: dict[str, float] = {}
    for name, value in (given or {}).items():
        if name not in known:
            raise UnknownObject(name, known, role=f"object with a {one}")
        number = float(value) if isinstance(value, np.floating) else value  # of other widths
        if not abs(number) < float_info.max:  # NaN, infinity, and whole numbers beyond all floats
            raise InvalidInput(f"{one} of {name!r} is not finite: expected a number, {expected}")
        checked[name] = float(value)
    return FrozenDict(checked)
