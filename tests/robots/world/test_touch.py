"""What a touch amounts to: the impulse from beginning to end of what presses by more than a brush."""

import pytest

from topple.planner.execution.judge import LIMITS
from topple.robots.world.tolerances import BRUSH
from topple.robots.world.touch import Touch, note_touches

STEP = 1 / 240


def touched(*forces: float) -> Touch:
    """One thing after steps in which this presses on it."""
    found: dict[str, Touch] = {}
    for force in forces:
        note_touches(found, [("can", "hand", force / 2), ("can", "finger", force / 2)] * (force > 0.0), STEP)
    return found["can"]


def test_a_touch_is_a_hit_by_its_impulse_and_not_by_the_force_of_a_step():
    pinned, pushed, brushed = touched(15.0), touched(*[15.0] * 12), touched(*[BRUSH] * 480)
    assert pinned.hit == pytest.approx((15.0 - BRUSH) * STEP) and pinned.hit < LIMITS.hit
    assert pushed.hit == pytest.approx(12 * (15.0 - BRUSH) * STEP) and pushed.hit > LIMITS.hit
    assert pushed.force == pinned.force == 15.0 and pushed.links == {"hand", "finger"}
    assert brushed.hit == 0.0 and brushed.impulse == pytest.approx(2.0 * BRUSH)


def test_what_chatters_is_one_touch_and_what_comes_back_is_another():
    once = touched(20.0).hit
    assert touched(20.0, 0.0, 0.0, 20.0).hit == pytest.approx(2.0 * once)
    assert touched(20.0, *[0.0] * 12, 20.0).hit == pytest.approx(once)
