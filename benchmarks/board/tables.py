"""Tables of the benchmark, from the summaries in docs/benchmark: docs/benchmark.md, measures.md."""

from collections.abc import Sequence

from benchmarks.pages import DOCS, markdown
from coopenv.agents.benchmark import SUITES, Scenario, Suite, Summary, read_summary
from coopenv.agents.benchmark.measures import MEASURES, SUCCESS, shown
from coopenv.agents.benchmark.suites.partners import CROSS_PLAY
from coopenv.agents.benchmark.trained import UNTOLD, exceeds, said

FOLDER = DOCS / "benchmark"
PAGE, REST = DOCS / "benchmark.md", FOLDER / "measures.md"
TOLERANCES = ("success_at_half", SUCCESS, "success_at_double")
NONE = "–"
ORDER = ("nobody", "random", "scripted", "alone", "gives_way", "assists", "told")
MATRIX = {  # entries that partners of the cross-play are, and their names there
    "scripted": CROSS_PLAY[0],
    "pretrained-joint": CROSS_PLAY[1],
    "pretrained-shared": CROSS_PLAY[2],
}


def summaries(suite: Suite) -> list[Summary]:
    """What has been entered in a suite, in the order of the tables."""
    found = [read_summary(path) for path in (FOLDER / suite.label).glob("*.json")]
    places = {name: place for place, name in enumerate(ORDER)}
    return sorted(found, key=lambda one: (places.get(one.entry, len(places)), one.entry))


def success(suite: Suite) -> str:
    """Success of each entry in each scenario."""
    entered = summaries(suite)
    rows = [
        [scenario.name, *(_cell(one, suite, scenario, SUCCESS) for one in entered)]
        for scenario in suite.scenarios
    ]
    return markdown(("scenario", *(one.entry for one in entered)), rows)


def tolerances(suite: Suite) -> str:
    """Success at half the tolerances, at them, at double."""
    rows = [
        [scenario.name, one.entry, *(_cell(one, suite, scenario, name) for name in TOLERANCES)]
        for scenario in suite.scenarios
        for one in summaries(suite)
        if scenario.name in one.results
    ]
    return markdown(("scenario", "entry", "half", "as they are", "double"), rows)


def cross_play() -> str:
    """Success and γ of each of a few in the one seat, with each of them in the other."""
    suite = SUITES["partners"]
    entered = {one.entry: one for one in summaries(suite)}
    beside = {one.name: one for one in suite.scenarios}
    rows = [
        [entry, *(_pair(entered[entry], suite, beside[name]) for name in MATRIX.values())]
        for entry in MATRIX
        if entry in entered
    ]
    return markdown(("entered", *(f"beside {name}" for name in MATRIX.values())), rows)


def rest(suite: Suite) -> str:
    """Every measure but success, for each scenario and entry."""
    names = [name for name in MEASURES if name not in TOLERANCES]
    told = [MEASURES[name] for name in names]
    heads = [f"{title} [{unit}]" if unit else title for title, unit in told]
    rows = [
        [scenario.name, one.entry, *(_cell(one, suite, scenario, name) for name in names)]
        for scenario in suite.scenarios
        for one in summaries(suite)
        if scenario.name in one.results
    ]
    return markdown(("scenario", "entry", *heads), rows)


def entered() -> str:
    """What each entry is and sees, and how much training is behind it."""
    every = [one for suite in SUITES.values() for one in summaries(suite)]
    rows = []
    for entry, one in {one.entry: one for one in every}.items():
        mine = [each for each in every if each.entry == entry]
        told = [trained for each in mine for trained in each.trained]
        rows.append((entry, f"`{one.given}`", one.sees, said(told), budget(mine)))
    return markdown(("entry", "given as", "sees", "trained [control steps]", "budget"), rows)


def budget(mine: Sequence[Summary]) -> str:
    """Whether the training behind an entry is within the budgets of the suites that it is in."""
    over = [one.suite for one in mine if exceeds(one.trained, SUITES[one.suite].budget)]
    if over:
        return f"over, in {' and '.join(f'`{name}`' for name in over)}"
    told = [trained for one in mine for trained in one.trained]
    return NONE if said(told) == UNTOLD else "within"


def versions() -> str:
    """Suites, their versions and digests."""
    rows = [
        (
            f"`{suite.name}`",
            str(suite.version),
            str(len(suite.scenarios)),
            f"{suite.budget:,}",
            f"`{suite.digest()[:16]}`",
        )
        for suite in SUITES.values()
    ]
    return markdown(
        ("suite", "version", "scenarios", "budget [control steps]", "digest begins"), rows
    )


def tables() -> dict[str, str]:
    """The tables of the page by their marks."""
    return {
        "versions": versions(),
        "entered": entered(),
        **{f"{name} success": success(suite) for name, suite in SUITES.items()},
        "cross-play": cross_play(),
        "team tolerances": tolerances(SUITES["team"]),
        "haptics tolerances": tolerances(SUITES["haptics"]),
    }


def measures() -> dict[str, str]:
    """The tables of the page of all measures."""
    return {name: rest(suite) for name, suite in SUITES.items()}


def _cell(one: Summary, suite: Suite, scenario: Scenario, name: str) -> str:
    """An estimate with its interval, of this version alone."""
    result = one.results.get(scenario.name)
    if result is None or result.digest != suite.digest_of(scenario):
        return NONE
    return shown(name, result.measures[name])


def _pair(one: Summary, suite: Suite, scenario: Scenario) -> str:
    told: Sequence[str] = [_cell(one, suite, scenario, name) for name in (SUCCESS, "relative_cost")]
    return NONE if NONE in told else f"{told[0]} %, γ {told[1]}"
