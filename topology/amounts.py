"""Masses and coefficients of friction by name, refused where they enter if they cannot be true."""

from collections.abc import Iterable, Mapping
from sys import float_info

import numpy as np

from topple.topology.errors import InvalidInput, UnknownObject
from topple.topology.statics.matter import ROUGHEST, SLIPPERIEST
from topple.topology.tolerances import HEAVIEST
from topple.topology.values import FrozenDict


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
