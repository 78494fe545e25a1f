"""Public names: those of a package, each imported when it is first used, and what some were called before.

`topple --help` must not wait for scipy, nor `import topple` for PyBullet.
"""

import sys
import warnings
from collections.abc import Callable, Container, Mapping
from importlib import import_module
from typing import Any

OLD_NAMES = {
    "base": "pose_base_to_world",
    "bench models": "meshes",
    "check": "verify",
    "dropped": "why",
    "eyes": "viewpoints",
    "labels": "masks",
    "most_bytes": "max_bytes",
    "most_objects": "max_objects",
    "rank object": "target",
    "robot": "robot_bodies",
    "robot o": "report",
    "robot output": "report",
    "second_base": "pose_second_to_world",
    "view": "fov",
}
"""Parameters, attributes, and options, some of one command alone, that had other names in version 0.1."""
RENAMED = "{} is now {}: the old name goes with the next version"


def lazy_names(
    package: str, homes: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Make a package's `__getattr__` and `__dir__`.

    Args:
        package: The package's name.
        homes: Module below it -> the public names that it holds, with blanks between them.

    Returns:
        What finds a public name, any other raises AttributeError; and what lists them, for completion.
    """
    home_of = {name: module for module, names in homes.items() for name in names.split()}

    def find(name: str) -> Any:
        if name not in home_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(f"{package}.{home_of[name]}"), name)
        setattr(sys.modules[package], name, value)
        return value

    def list_names() -> list[str]:
        names = vars(sys.modules[package])
        return sorted({*names, *names["__all__"]})

    return find, list_names


def new_name(name: str, known: Container[str], where: str = "") -> str:
    """Give the name that something has now.

    Args:
        name: What somebody wrote.
        known: All that may be written there: what is among it is no old name.
        where: The command whose option it is.
    """
    new = OLD_NAMES.get(f"{where} {name}", OLD_NAMES.get(name, name))
    return new if name not in known and new in known else name


def with_new_names(keywords: dict[str, Any], known: Container[str]) -> dict[str, Any]:
    """Keyword arguments by the names that they have now; each old one warns."""
    return {_warned(name, known): value for name, value in keywords.items()}


def old_attribute(old: str) -> property:
    """Make an attribute under its old name, which warns."""
    return property(lambda owner: getattr(owner, _warned(old, (OLD_NAMES[old],))))


def _warned(name: str, known: Container[str]) -> str:
    """The new name; an old one warns at the line that called topple, whatever of topple is between."""
    import inspect

    new = new_name(name, known)
    if new != name:
        modules = [frame.frame.f_globals.get("__name__", "") for frame in inspect.stack(0)]
        outside = [level for level, module in enumerate(modules, 1) if module.split(".")[0] != "topple"]
        warnings.warn(RENAMED.format(name, new), DeprecationWarning, stacklevel=next(iter(outside), 1))
    return new
