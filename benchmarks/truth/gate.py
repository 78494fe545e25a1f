"""`topple bench truth`: how much topple tells rightly, held against floors or against another commit.

The scenes are of four generators that are unlike, labelled by lifting each object in simulation; each is
given as whole surfaces and as depth images of one and of three noisy cameras (`views`). Told are, with 95 %
intervals (Wilson's of shares, else of scenes drawn anew), relations and false contacts, dependencies,
cycles, safe orders, first removals that disturb, needless removals, and the Brier score of risks.

- `--quick`: 60 scenes against the floors in `truth.json`. A floor is the figure when it was raised, less
  what chance alone moved it by; `--write` raises floors, none ever falls.
- Every third of the 60 is asked with masks as segmentations give them (`mask_faults`), from one camera; in a
  quick run ragged by two pixels and with one in ten missing, else in every way, recorded frames as well.
- Full: 400 scenes that the commit draws, so that nobody works towards them; the 60 again under jitter that
  must change nothing (0.2 mm of noise, half of the points, a kilometre off, turned with its grids), and
  looked at five times: how much of the answers stays.
- `--against COMMIT`: the same scenes by that commit, in processes of its own; per figure the paired
  difference. A change is refused where it loses more than `worst` of a figure, or anything significantly;
  a step that claims to change nothing shows it by how many answers are the same to the last digit.
- `--data DIR`, `--piles DIR`: recorded frames and piles too, reported and never worked towards.

Answers are kept in `.truth` and not asked again, so that a run that was stopped goes on.
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np

from topple.benchmarks.row import Progress, Row
from topple.benchmarks.scores import share_interval
from topple.benchmarks.truth.answers import Question, answers
from topple.benchmarks.truth.border_pixels import border_rows, pictures_of
from topple.benchmarks.truth.cases import Case, drawn, few, masked_cases, pool_cases, recorded_cases
from topple.benchmarks.truth.counts import (
    BINS,
    COLUMN,
    FIGURES,
    Counts,
    Figure,
    base_brier,
    chances,
    count,
    difference,
    interval,
    words,
)
from topple.benchmarks.truth.floors import POOL, Floors
from topple.benchmarks.truth.mask_faults import INACCURATE, WRONG
from topple.benchmarks.truth.pool import SETS
from topple.benchmarks.truth.views import VIEWS
from topple.benchmarks.versions import Version, commit_now, of_commit, today
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.base.files import write_whole

FOLDER = Path(".truth")
FLOORS = Path(__file__).parents[1] / "truth.json"
FREEING = ("noise 1", "turn 45")
"""Of the variants, those that are asked about every target as well."""

VARIANTS = ("noise 1", "noise 2", "noise 3", "half", "offset", "turn 22.5", "turn 45", "turn 67.5")
MASKED_VIEW, MASKED_EVERY = "1 camera", 3
"""View, and every how manieth scene of every run, that is asked with masks as segmentations give them."""

ALWAYS_MASKED = ("ragged 2", "missing")
"""Of the ways in which masks are inaccurate or wrong, those that every run asks."""

OF_TARGETS = ("first removals that disturb", "needless removals")
LOOKS = 5
Answers = Mapping[Question, Mapping[str, Any]]


def rows(
    quick: bool,
    seed: int,
    progress: Progress,
    data: Path | None = None,
    piles: Path | None = None,
    against: str | None = None,
    write: bool = False,
    executor: Executor | None = None,
) -> list[dict[str, Any]]:
    """Ask and count.

    Args:
        quick: The 60 scenes of every run alone, against the floors.
        seed: 0: what is judged has seeds of its own.
        progress: Called as answers come.
        data: A folder of annotated frames.
        piles: A folder of recorded piles; `piles` beside `data` where None.
        against: A commit to be compared with.
        write: Raise the floors.
        executor: Whose workers render.

    Returns:
        The bench's rows.

    Raises:
        InvalidInput: There is no pool, no such commit, or a folder lacks what it should hold.
    """
    if seed:
        raise InvalidInput(f"--seed {seed}: the scenes have seeds of their own: leave --seed out")
    version = today(FOLDER / "versions")
    short = few()
    known = pool_cases(short, FOLDER / "given", progress, 1 if quick else LOOKS, executor)
    cases = list(known)
    if not quick:
        more = [scene for scene in drawn((commit_now() or "").rstrip("+")) if scene not in short]
        cases += pool_cases(more, FOLDER / "given", progress, 1, executor)
    cases += recorded_cases(data, piles, FOLDER / "given")
    some = [case for case in known if case.view == MASKED_VIEW][::MASKED_EVERY]
    some += [case for case in cases if case.set == "recorded frames"]
    masked = list(masked_cases(some, ALWAYS_MASKED if quick else (*INACCURATE, *WRONG), FOLDER / "given"))
    cases += masked
    found = _asked(version, [case.question for case in cases], progress)
    told = [*_figures(cases, found), *_called(cases, found)]
    chance: dict[tuple[str, str, str], float] = {}
    if not quick or write:
        jittered, chance = _jitter(version, known, found, progress)
        told += jittered
    if not quick:
        told += [*_seen_again(version, known, found, progress), *_bins(cases, found), *_borders(cases)]
    floors = Floors.read(FLOORS)
    of_few = {case.name for case in known}
    often = [case for case in cases if case not in masked or case.view in ALWAYS_MASKED]
    kept = [case for case in often if case.name in of_few or case.set not in SETS]
    if write:
        chance |= _chance_of_masked(masked, found, chance)
        floors = floors.raised(_values(kept, found), chance, version.name)
        write_whole(FLOORS, floors.text())
    documents = [row.to_json() for row in (*told, *floors.rows(_values(kept, found)))]
    if against is not None:
        documents += _compared(version, of_commit(against, FOLDER / "versions"), cases, found, progress)
    return documents


def broken(floors: Floors, cases: Sequence[Case], found: Answers) -> list[str]:
    """Floors that answers are below, in words.

    Args:
        floors: The floors.
        cases: Scenes of every run in every view.
        found: The answers.
    """
    rows = floors.rows(_values(cases, found))
    return [f"{row.what}: {row.value:.4g}, {row.bar}" for row in rows if row.ok is False]


def _asked(version: Version, questions: Sequence[Question], progress: Progress) -> Answers:
    return answers(version, questions, FOLDER / "answers", progress)


def _groups(cases: Sequence[Case]) -> dict[tuple[str, str], list[Case]]:
    """Cases by set and view; those of the pool together as well."""
    found: dict[tuple[str, str], list[Case]] = {}
    for case in cases:
        if case.set in SETS:
            found.setdefault((POOL, case.view), []).append(case)
    for case in cases:
        found.setdefault((case.set, case.view), []).append(case)
    return found


def _table(cases: Sequence[Case], found: Answers) -> FloatArray:
    """(N, K) counts."""
    return np.array([_counts(case, found).array() for case in cases])


def _figures(cases: Sequence[Case], found: Answers) -> list[Row]:
    """Every figure of every set and view."""
    told: list[Row] = []
    for (which, view), some in _groups(cases).items():
        table = _table(some, found)
        sums = table.sum(axis=0)
        for figure in FIGURES:
            if not figure.counted(sums):
                continue
            what = f"{figure.what}: {which}, {len(some)} scenes"
            value, chance = float(figure.value(sums)), _interval(figure, table)
            told.append(Row(what, value, "", interval=chance, column=view))
        told.append(Row(f"Brier score of one risk for all: {which}", base_brier(sums), "", column=view))
    return told


def _interval(figure: Figure, table: FloatArray) -> tuple[float, float]:
    if not figure.part:
        return interval(figure, table)
    part, whole = (round(table[:, COLUMN[key]].sum()) for key in (figure.part, figure.whole))
    low, high = share_interval(part, whole)
    return low / 100, high / 100


def _values(cases: Sequence[Case], found: Answers) -> dict[tuple[str, str, str], float]:
    """What floors are about: (set, view, figure) -> value, better the more it is."""
    values: dict[tuple[str, str, str], float] = {}
    for (which, view), some in _groups(cases).items():
        sums = _table(some, found).sum(axis=0)
        if which not in SETS:
            values |= {
                (which, view, figure.what): figure.better * float(figure.value(sums))
                for figure in FIGURES
                if figure.worst is not None and figure.counted(sums)
            }
    return values


def _jitter(
    version: Version, cases: Sequence[Case], found: Answers, progress: Progress
) -> tuple[list[Row], dict[tuple[str, str, str], float]]:
    """How much of the answers stays under what must change nothing, and by how much figures fall at most."""
    questions = {
        (case, variant): replace(
            case.question, variant=variant, targets=case.question.targets if variant in FREEING else ()
        )
        for case in cases
        for variant in VARIANTS
    }
    jittered = _asked(version, list(questions.values()), progress)
    base = _values(cases, found)
    lowest = dict(base)
    for variant in VARIANTS:
        answered = {case.question: jittered[questions[case, variant]] for case in cases}
        for key, value in _values(cases, answered).items():
            if variant in FREEING or key[2] not in OF_TARGETS:
                lowest[key] = min(lowest[key], value)
    told = [
        Row(f"jitter: {figure}, {which}", base[key] - lowest[key], "", column=view)
        for key in base
        for which, view, figure in [key]
    ]
    for view, variant in product(VIEWS, VARIANTS):
        some = [case for case in cases if case.view == view]
        pairs = [(found[case.question], jittered[questions[case, variant]]) for case in some]
        shown = {
            "relations kept": _kept(pairs, "relations"),
            "edges kept": _kept(pairs, "dependencies"),
            "orders that change": sum(a.get("order") != b.get("order") for a, b in pairs),
            "scenes whose edges change": sum(_edges(a) != _edges(b) for a, b in pairs),
        }
        told += [Row(f"{variant}: {what}", value, "", column=view) for what, value in shown.items()]
    return told, {key: max(base[key] - lowest[key], _one_case(key, cases, found)) for key in base}


def _chance_of_masked(
    masked: Sequence[Case], found: Answers, chance: Mapping[tuple[str, str, str], float]
) -> dict[tuple[str, str, str], float]:
    """By how much chance moves figures of spoilt masks: that of the same view, of so many scenes fewer."""
    return {
        key: max(
            MASKED_EVERY**0.5 * chance.get((POOL, MASKED_VIEW, key[2]), 0.0),
            _one_case(key, [case for case in masked if case.set == key[0]], found),
        )
        for key in _values(masked, found)
    }


def _one_case(key: tuple[str, str, str], cases: Sequence[Case], found: Answers) -> float:
    """What one case more or less makes of a share: of that no figure is surer."""
    figure = next(one for one in FIGURES if one.what == key[2])
    if not figure.whole:
        return 0.0
    table = _table([case for case in cases if case.view == key[1]], found)
    return 1.0 / max(float(table[:, COLUMN[figure.whole]].sum()), 1.0)


def _edges(answer: Mapping[str, Any], key: str = "dependencies") -> set[tuple[str, ...]]:
    """Dependencies without reason and chance, or relations."""
    return {tuple(entry[: 2 if key == "dependencies" else 3]) for entry in answer.get(key, ())}


def _kept(pairs: Sequence[tuple[Mapping[str, Any], Mapping[str, Any]]], key: str) -> float:
    """Share of what either answer has that both have."""
    both = sum(len(_edges(a, key) & _edges(b, key)) for a, b in pairs)
    either = sum(len(_edges(a, key) | _edges(b, key)) for a, b in pairs)
    return both / max(either, 1)


def _seen_again(version: Version, cases: Sequence[Case], found: Answers, progress: Progress) -> list[Row]:
    """How often another look at the same scene changes what is said."""
    again = _asked(version, [look for case in cases for look in case.looks], progress)
    told: list[Row] = []
    for view in VIEWS:
        pairs = [
            (found[case.question], again[look]) for case in cases if case.view == view for look in case.looks
        ]
        if pairs:
            changes = {
                "first removal": sum(a.get("order", [])[:1] != b.get("order", [])[:1] for a, b in pairs),
                "set that is free now": sum(_free(a) != _free(b) for a, b in pairs),
                "graph": sum(_edges(a) != _edges(b) for a, b in pairs),
            }
            told += [
                Row(f"seen again {len(pairs)} times: other {name}", n / len(pairs), "", column=view)
                for name, n in changes.items()
            ]
    return told


def _free(answer: Mapping[str, Any]) -> set[str]:
    return set(answer.get("objects", ())) - {then for _, then in _edges(answer)}


def _bins(cases: Sequence[Case], found: Answers) -> list[Row]:
    """How often dependencies that were told with a chance are true, by that chance."""
    told: list[Row] = []
    for (which, view), some in _groups(cases).items():
        every = [pair for case in some for pair in chances(found[case.question], case.labels)]
        for low, high in pairwise(BINS):
            signs = [sign for chance, sign in every if low <= chance < high or chance == high == 1.0]
            if signs and which == POOL:
                low_held, high_held = (share / 100 for share in share_interval(sum(signs), len(signs)))
                what = f"true, told with {low:g} to {high:g}: {view}, {len(signs)}"
                told.append(Row(what, sum(signs) / len(signs), "", interval=(low_held, high_held)))
    return told


def _called(cases: Sequence[Case], found: Answers) -> list[Row]:
    """How many of the steps that are called sure, likely or a guess disturb something."""
    told = list[Row]()
    for view in VIEWS:
        asked = (case for case in cases if case.set in SETS and case.view == view)
        every = [step for case in asked for step in words(found[case.question], case.labels)]
        for word in sorted({word for word, _ in every}):
            signs = [sign for called, sign in every if called == word]
            what, bounds = f"that disturb: {view}, {len(signs)}", share_interval(sum(signs), len(signs))
            told.append(Row(f"steps called {word} {what}", 100 * float(np.mean(signs)), "%", interval=bounds))
    return told


def _borders(cases: Sequence[Case]) -> list[Row]:
    """What pixels at borders are, in rendered pictures and in recorded frames."""
    rendered = [case.question.path for case in cases if case.set in SETS and case.view == MASKED_VIEW]
    recorded = [case.question.path for case in cases if case.set == "recorded frames"]
    return [
        *border_rows("rendered", pictures_of(rendered)),
        *(border_rows("recorded", pictures_of(recorded)) if recorded else []),
    ]


def _compared(
    ours: Version, theirs: Version, cases: Sequence[Case], found: Answers, progress: Progress
) -> list[dict[str, Any]]:
    """Paired differences to another version, and the scenes that differ."""
    other = _asked(theirs, [case.question for case in cases], progress)
    documents: list[dict[str, Any]] = []
    for (which, view), some in _groups(cases).items():
        mine, its = _table(some, found), _table(some, other)
        for figure in (figure for figure in FIGURES if figure.counted(mine + its)):
            value, (low, high) = difference(figure, mine, its)
            decides = figure.worst is not None and which == POOL
            most = None if not decides else "<= 0" if high < 0.0 else f"<= {figure.worst:g}"
            row = Row(
                f"{figure.what}, lost: {which}, {view}, {len(some)} scenes", -value + 0.0, "", theirs.name,
                float(figure.value(its.sum(axis=0))), bar=most, interval=(-high + 0.0, -low + 0.0),
            )  # fmt: skip
            documents.append(row.to_json())
    differ = [
        {
            "what": case.question.name,
            "parts": [name for name in COLUMN if before[COLUMN[name]] != after[COLUMN[name]]],
            "was": _words(its), "now": _words(mine),
        }
        for case in cases
        for mine, its in [(_counts(case, found), _counts(case, other))]
        for before, after in [(its.array(), mine.array())]
        if (before != after).any()
    ]  # fmt: skip
    summary = Row(
        f"scenes and views that are counted otherwise than by {theirs.name}, of {len(cases)}", len(differ), ""
    )
    same = sum(found[case.question] == other[case.question] for case in cases)
    equal = Row(f"answers that are those of {theirs.name} to the last digit, of {len(cases)}", same, "")
    return [*documents, equal.to_json(), {**summary.to_json(), "differences": differ}]


def _counts(case: Case, found: Answers) -> Counts:
    return count(found[case.question], case.labels, case.relations, case.mask_faults)


def _words(counts: Counts) -> str:
    return (
        f"{counts.related} of {counts.pairs} relations, {counts.right} right, {counts.false} false, "
        f"{counts.missed} missed, {'safe' if counts.safe else 'refused' if counts.unanswered else 'unsafe'}"
    )
