"""The page that gathers results, read from the tables of the pages they stand on: docs/results.md.

python -m benchmarks.site.results            # prints the tables
python -m benchmarks.site.results --write    # and writes docs/results.md
"""

import re
from collections.abc import Iterator, Sequence

from benchmarks.pages import DOCS, filled, markdown, show

PAGE = DOCS / "results.md"
STUDIES = {  # name of a table of claims -> title, anchor on the page of studies
    "walker-turn": ("A walker that is turned", "a-walker-that-is-turned"),
    "walker-avoid": ("A walker held off an obstacle", "a-walker-that-is-held-off-an-obstacle"),
    "beam": ("A beam without disagreement", "a-beam-that-is-carried-without-disagreement"),
    "snapshots": ("Single wrenches, Figs. 2 to 8 and 17", "single-wrenches"),
    "dyads": ("Pairs of people, simulated", "pairs-of-people-simulated"),
}

COLUMNS = ("success", "time [s]", "γ")  # of the table of environments
OWN = "partner's wrench"  # a learner of the studies


def rows(page: str, name: str) -> list[dict[str, str]]:
    """A table of a page, a mapping a row."""
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8").split(f"<!-- {name} -->\n")[1]
    lines = [line[2:-2].split(" | ") for line in text.splitlines() if line.startswith("| ")]
    head, *rest = [line for line in lines if set(line) != {"---"}]
    return [dict(zip(head, line, strict=True)) for line in rest]


def claims() -> str:
    """How many claims of the paper hold, by study."""
    lines = []
    for name, (title, anchor) in STUDIES.items():
        verdicts = [row["verdict"] for row in rows("studies", f"{name} claims")]
        hold = verdicts.count("holds")
        lines.append((f"[{title}](studies.md#{anchor})", str(len(verdicts)), str(hold)))
    return markdown(("study", "claims", "that hold"), lines)


def solved() -> str:
    """Who solves which environment: the scripted controller, and PPO's joint policies."""
    scripted = {row["environment"]: row for row in rows("tasks", "learning")
                if row["policy"] == "scripted"}  # fmt: skip
    learned: dict[str, list[dict[str, str]]] = {}
    for row in rows("training", "baselines"):
        if row["policy"] == "joint":
            learned.setdefault(row["environment"], []).append(row)
    lines = [
        (
            name,
            *(mine[column] for column in COLUMNS),
            str(len(learned[name])),
            *(_range([row[column] for row in learned[name]]) for column in COLUMNS),
        )
        for name, mine in scripted.items()
    ]
    heads = [f"{kind}: {column}" for kind in ("scripted", "PPO") for column in COLUMNS]
    return markdown(("environment", *heads[:3], "PPO: seeds", *heads[3:]), lines)


def _range(found: Sequence[str]) -> str:
    """The lowest and the highest, once where they are the same."""
    lowest, *_, highest = sorted(found, key=lambda one: float(one.rstrip("%")))
    return lowest if lowest == highest else f"{lowest} to {highest}"


def answers() -> str:
    """Questions, and in one line what was measured."""
    return markdown(("question", "measured", "page"), list(_answers()))


def _answers() -> Iterator[tuple[str, str, str]]:
    told = {row["follower"]: row for row in rows("haptics", "haptics")[::-1]
            if (row["beam"], row["action"], row["seeds"]) == ("7.7 kg", "motion", "–")}  # fmt: skip
    yield (
        "How much of the goal gets through a beam of 7.7 kg to a hand that is not told it?",
        f"success {_spread(told, ('lets go', 'gives way', 'assists', 'is told'))}",
        "[haptics](haptics.md#measured)",
    )
    sensed = {row["learner"]: row["success"] for row in rows("studies", "partner")}
    yield (
        "What is it worth to a learner to sense the plausible internal wrench?",
        f"success {sensed['plausible']} beside {sensed['without']} without, "
        f"{sensed[OWN]} with the partner's own wrench",
        "[studies](studies.md#what-it-is-worth-to-sense-a-partner)",
    )
    prices = {row["price on"]: row for row in rows("results/reward_shaping", "wrench effects")
              if row["wanted share"] == "80/20"}  # fmt: skip
    named = [prices[f"internal force, {who}"]["time [s]"] for who in ("plausible", "Moore–Penrose")]
    yield (
        "What does a price on internal force cost a team that is to carry 80/20?",
        f"{named[0]} s by the plausible definition, {named[1]} s by Moore–Penrose",
        "[reward shaping](results/reward_shaping.md)",
    )
    beside = {row["partner"]: row for row in rows("partners", "success")}
    places = [name for name in beside["robot"] if name != "partner"]
    worst = min(float(beside["robot"][name].strip("*")) for name in places)
    yield (
        f"Beside which of {len(beside) - 1} partners can each of {len(places)} places be solved?",
        f"beside `robot` all, with at least {worst:g} %; the others by place",
        "[partners](partners.md#what-is-reached-beside-them)",
    )
    ends = [row for row in rows("training", "speed") if row["training"] == "until=0.98"]
    seconds = sorted(float(row["CPU [s]"]) for row in ends)
    yield (
        "How long until PPO carries the beam in 98 % of episodes?",
        f"{seconds[0]:g} to {seconds[-1]:g} s of one core, {len(seconds)} seeds",
        "[training](training.md#how-fast)",
    )
    loop = {(row["loop"], row["collector"]): row for row in rows("decomposition", "latency")}
    pair, trio = (loop[name, "off"] for name in ("a pair in the plane", "a trio in space"))
    yield (
        "How long does a decomposition take in a control loop, without the garbage collector?",
        f"median {pair['median [µs]']} µs a pair in the plane, {trio['median [µs]']} µs a trio in "
        "space",
        "[decomposition](decomposition.md#control-loops)",
    )
    physics = {row["substeps"]: row for row in rows("accuracy", "table")}["5"]
    yield (
        "How exact is free motion, and how deep do bodies overlap, at 5 substeps?",
        f"{physics['free motion: worst error']} m; {physics['deepest overlap']}",
        "[accuracy](accuracy.md)",
    )
    yield ("Do the tests notice a fault in the code?", _mutants(), "[mutants](mutants.md#score)")
    trials = rows("reliability", "soak")
    failed = sum(int(row["failed"].split()[0]) for row in trials)
    count = sum(int(row["trials"].replace(",", "")) for row in trials)
    yield (
        "What do random trials of everything find?",
        f"{failed} of {count:,} trials failed of what is not mended since",
        "[reliability](reliability.md#what-random-trials-found)",
    )
    libraries = {row["library"] for row in rows("ecosystem", "libraries")}
    yield (
        "Which other libraries were run on the environments?",
        f"{len(libraries)}, each with what was asserted",
        "[libraries](ecosystem.md)",
    )


def _spread(told: dict[str, dict[str, str]], names: tuple[str, ...]) -> str:
    """Success of each, in percent with its interval."""
    return ", ".join(f"{told[name]['success [%]']} {name}" for name in names) + " [%]"


def _mutants() -> str:
    text = (DOCS / "mutants.md").read_text(encoding="utf-8").split("<!-- score -->\n")[1]
    scores = re.findall(r"seed (\d+): ([\d.]+ %) of (\d+)", text)
    return "; ".join(f"{score} of {count} (seed {seed})" for seed, score, count in scores)


def tables() -> dict[str, str]:
    """The page's tables by name."""
    return {"claims": claims(), "solved": solved(), "answers": answers()}


def page() -> str:
    """The page as it should be."""
    return filled(PAGE, tables())


def main() -> None:
    """Print, and write."""
    show(PAGE, tables())


if __name__ == "__main__":
    main()
