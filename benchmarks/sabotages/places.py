"""Spoil where an object goes."""

from topple.benchmarks.sabotages.document import Document, backwards, first_step, last_step, shift, turn


def place_higher(d: Document) -> None:
    shift(last_step(d)["placement"]["pose_before_to_after"], 2, 0.1)


def place_aside(d: Document) -> None:
    shift(last_step(d)["placement"]["pose_before_to_after"], 0, 0.02)


def place_turned(d: Document) -> None:
    turn(last_step(d)["placement"]["pose_before_to_after"], 0.2)


def fall_upwards(d: Document) -> None:
    last_step(d)["placement"]["drop"] -= 0.1


def fall_through_the_table(d: Document) -> None:
    last_step(d)["placement"]["drop"] += 0.1


def put_into_another_thing(d: Document) -> None:
    placement, own = first_step(d)["placement"], first_step(d)["object"]
    placement["into"] = next(
        thing["name"]
        for thing in d["objects"]
        if thing["name"] not in (own, placement["into"]) and not thing["fixed"]
    )
    placement["how"] = "on"


def said_to_fall(d: Document) -> None:
    first_step(d)["placement"]["falls"] = True


def put_back_where_it_was(d: Document) -> bool:
    """A target that is lifted, let down again, and nothing else."""
    step = last_step(d)
    done = {part["kind"]: part for part in step["segments"]}
    back = [
        {**part, "kind": kind, "motion": backwards(part["motion"]), "holding": held}
        for part, kind, held in ((done["lift"], "place", step["object"]), (done["approach"], "retreat", None))
    ]
    release = {**done["release"], "hand": done["approach"]["hand"]}
    step["segments"] = [done[kind] for kind in ("move", "approach", "grasp", "lift")] + [
        back[0],
        release,
        back[1],
    ]
    still = [[float(row == column) for column in range(4)] for row in range(4)]
    step["placement"].update(pose_before_to_after=still, drop=0.0, into=None, how="", falls=False)
    return step["action"] == "free"
