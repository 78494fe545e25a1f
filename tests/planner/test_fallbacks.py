"""Every way out stands in one list, with when it applies."""

from topple.planner.fallbacks import FALLBACKS, Fallback


def test_every_fallback_is_told_of_in_words_of_its_own() -> None:
    assert list(FALLBACKS) == list(Fallback)
    told = [text for each in FALLBACKS.values() for text in (each.when, each.tries)]
    assert all(told) and len(set(told)) == len(told)
    assert len({str(each) for each in Fallback}) == len(Fallback)
