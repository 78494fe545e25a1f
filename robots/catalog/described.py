"""URDFs of arms and hands by name, from the packages of descriptions that are installed."""

import re
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

DESCRIPTIONS = {
    "airo-models": "airo_models",
    "example-robot-data": "cmeel.prefix/share/example-robot-data/robots",
}
"""Distribution -> its folder of URDFs. Their files are read, their code is not run."""


def find_urdf(name: str) -> Path | None:
    """The URDF of that name that an installed package ships; None where none does.

    Args:
        name: Of the file, without its ending: `ur5e`, `robotiq_2f_85`.
    """
    if not re.fullmatch(r"\w[\w-]*", name):
        return None
    for package, folder in DESCRIPTIONS.items():
        try:
            place = Path(str(distribution(package).locate_file(folder)))
        except PackageNotFoundError:
            continue
        for found in sorted(place.rglob(f"{name}.urdf")):
            return found
    return None
