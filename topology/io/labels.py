"""What the numbers of a mask, or of labelled points, are called."""

from collections.abc import Mapping, Sequence

import numpy as np

from topple.topology.base.arrays import IntArray
from topple.topology.base.errors import InvalidInput
from topple.topology.io.archive import Array
from topple.topology.io.clouds import names_in
from topple.topology.io.tolerances import MOST_OBJECTS

NAMING = ("names", "ids")
"""Arrays that name the labels."""


def fixed_labels(arrays: Mapping[str, Array], names: Mapping[int, str]) -> list[str]:
    """The names in `fixed`; a label there stands for its name."""
    if "fixed" not in arrays:
        return []
    known = {str(number): name for number, name in names.items()}
    return [known.get(name, name) for name in names_in(arrays["fixed"])]


def label_names(arrays: Mapping[str, Array], label: Array) -> dict[int, str]:
    """Read what the labels are called.

    Args:
        arrays: The file's arrays; `names` and `ids` may be among them.
        label: The mask, or the labels of points.

    Returns:
        The name of each label that has one and occurs; none where there are no `names`.

    Raises:
        InvalidInput: If there are more labels than any scene has objects, or `names` is no text, does not say
            which label a name belongs to, or names one twice.
    """
    if label.dtype.kind not in "iufb":
        raise InvalidInput(f"the labels are {label.dtype}: expected whole numbers, 0 = background")
    present = {int(number) for number in np.unique(label) if number > 0}
    if len(present) > MOST_OBJECTS:
        raise InvalidInput(f"{len(present)} labels: expected one per object, at most {MOST_OBJECTS} of them")
    if "names" not in arrays:
        return {}
    names = arrays["names"]
    if names.ndim != 1 or names.dtype.kind not in "US":
        raise InvalidInput(
            f"names holds {names.dtype} of shape {names.shape}: expected one text per label (M,)"
        )
    if "ids" in arrays:
        ids = arrays["ids"]
        if ids.dtype.kind not in "iu" or ids.shape != names.shape:
            raise InvalidInput(
                f"ids is {ids.shape} of {ids.dtype}: expected one whole number per name, {names.shape}"
            )
        numbers = [int(number) for number in ids]
        if len(set(numbers)) < len(numbers):
            raise InvalidInput("ids names a label twice: expected each label once")
    else:
        numbers = list(range(len(names)))
        if present and len(names) <= max(present):
            raise InvalidInput(
                f"names has {len(names)} entries and the labels reach {max(present)}: expected names[i] for "
                "label i, the background's at 0; or whole numbers ids, one per name, that say whose it is"
            )
    named = zip(numbers, names_in(names), strict=True)
    return {number: name for number, name in named if number in present and name.strip()}


def label_of_stack(masks: Array, names: Sequence[object]) -> tuple[IntArray, list[str]]:
    """Make one mask of many.

    Args:
        masks: (N, H, W) of true and false, a mask per object, N >= 1.
        names: What they are called, for the note.

    Returns:
        (H, W) labels from 1 on, in their order; and the sentence on masks that overlap, if any do: of two the
        smaller one has the pixels, being in front.

    Raises:
        InvalidInput: A mask is empty, or smaller ones have all of its pixels.
    """
    label, claims = np.zeros(masks[0].shape, dtype=np.int64), np.sum(masks, axis=0)
    for place in sorted(range(len(masks)), key=lambda k: -int(masks[k].sum())):
        label[masks[place]] = place + 1
    empty = [str(names[k]) for k in range(len(masks)) if not (label == k + 1).any()]
    if empty:
        raise InvalidInput(
            f"masks of {', '.join(empty)} are empty, or all within smaller ones: expected pixels of an "
            "object in each; leave them out"
        )
    shared = [repr(names[k]) for k, mask in enumerate(masks) if (mask & (claims > 1)).any()]
    said = f"masks of {', '.join(shared)} overlap: of two the smaller one has the pixels"
    return label, [said] if shared else []
