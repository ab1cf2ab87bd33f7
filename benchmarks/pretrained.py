"""Policies that come with the package: ``python -m benchmarks.pretrained [--write]``.

Each is evaluated on held-out episodes of the environment that it was trained in. ``--take FOLDER``
puts runs of ``coopenv train`` beside them, ``FOLDER/BeamDoorway_joint/policy.zip`` and so on: one
that does better takes the place of the package's. ``--write`` keeps files, rows and the tables of
``docs/policies.md``.
"""

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import tyro
from rich.console import Console

from benchmarks.pages import DOCS, fill, markdown
from coopenv.agents.evaluate import Evaluation, evaluate
from coopenv.agents.pretrained import names
from coopenv.agents.pretrained.catalogue import ROW
from coopenv.agents.pretrained.naming import CONTROLS, WORD, file_of
from coopenv.agents.provenance import KEY, Provenance
from coopenv.agents.settings import TrainConfig
from coopenv.agents.trained.form import SUFFIX, Form, read_form
from coopenv.agents.trained.policy import PlainPolicy

TASKS = ("BeamTransport", "BeamDoorway", "BeamTracking", "BeamLift", "WalkerTurn", "WalkerAvoid")
PAGE = DOCS / "policies.md"
MADE = "made"  # entry of the notes: command and revision
COLUMNS = (
    *("policy", "success", "95 %", "sampled", "time [s]", "γ", "F_I [N]", "T_I [N·m]", "share"),
    "size [kB]",
)
HOW = ("policy", "control steps", "command", "revision")
_NOT_SAID = ("environment", "out", "threads", "checkpoint_every")  # of a run, in its command


@dataclass(frozen=True, kw_only=True)
class Pretrained:
    """Evaluate the package's policies, and take better ones."""

    take: Path | None = None
    """Folder of runs to compare them with."""
    revision: str = ""
    """Commit of the code that trained those runs."""
    after: int | None = None
    """Steps of the run that they went on from, if they did."""
    only: tuple[str, ...] = ()
    """BeamDoorway/joint and the like; none: all."""
    episodes: int = 500
    """Held-out episodes for each policy."""
    write: bool = False
    """Keep files, rows and tables."""


def taken(wanted: Pretrained, folder: Path, name: str) -> Form | None:
    """The policy of a run as the package ships it; ``None`` where there is no such run."""
    file = folder / name.replace("/", "_") / "policy.zip"
    if not file.is_file():
        return None
    from coopenv.agents.sb3 import SB3Policy

    form = SB3Policy.load(file).plain().form
    provenance = Provenance.from_notes(form.notes)
    assert provenance is not None
    command = command_of(provenance.training)
    if wanted.after is not None:
        before = command_of({**provenance.training, "steps": wanted.after})
        command = f"{before} && {command}"
    training = {**provenance.training, "out": f"runs/{name.replace('/', '_')}"}
    named = replace(provenance, training=training, command=shlex.split(command))
    return replace(
        form, notes={**named.to_notes(), MADE: {"command": command, "revision": wanted.revision}}
    )


def command_of(training: Mapping[str, Any]) -> str:
    """``coopenv train`` with what a run has other than the defaults, but for its folder."""
    default = TrainConfig().to_dict()
    words = ["coopenv", "train", "--env", training["environment"]["env"]]
    for name, value in [*training["environment"].items(), *training.items()]:
        known = default["environment"].get(name, default.get(name))
        if name in (*_NOT_SAID, "env") or value == known:
            continue
        values = value if isinstance(value, list) else [value]
        words += [f"--{name.replace('_', '-')}", *map(str, values)]
    return shlex.join(words)


def measured(form: Form, name: str, episodes: int) -> Form:
    """With its row: held-out episodes of its own environment."""
    provenance = Provenance.from_notes(form.notes)
    assert provenance is not None
    seen = evaluate(PlainPolicy(form), provenance.config(), episodes=episodes, name=name)
    return replace(form, notes={**form.notes, ROW: seen.plain()})


def row(form: Form) -> Evaluation:
    """What `measured` found."""
    return Evaluation.from_dict(form.notes[ROW])


def better(one: Form, other: Form) -> Form:
    """The one of which more episodes succeed; of as many, that which fights less."""
    return min(one, other, key=lambda form: (-row(form).success_rate, row(form).relative_cost))


def chosen(wanted: Pretrained, name: str) -> Form | None:
    """The package's policy, or the better one of ``take``."""
    found = []
    if name in names():
        found.append(read_form(file_of(f"{WORD}:{name}")))
    if wanted.take is not None:
        found += [form for form in [taken(wanted, wanted.take, name)] if form]
    forms = [measured(form, name, wanted.episodes) for form in found]
    return better(*forms) if len(forms) == 2 else next(iter(forms), None)


def cells(name: str, form: Form) -> tuple[str, ...]:
    """A row of the table."""
    seen, size = row(form), file_of(f"{WORD}:{name}").stat().st_size
    low, high = seen.success_interval
    return (
        f"`{name}`",
        f"{100 * seen.success_rate:.1f} %",
        f"{100 * low:.1f}-{100 * high:.1f}",
        f"{100 * seen.sampled_success_rate:.1f} %",
        f"{seen.success_time:.1f}" if seen.success_rate else "–",
        f"{seen.relative_cost:.3f}",
        f"{seen.internal_force_level:.2f}",
        f"{seen.internal_torque_level:.2f}",
        ":".join(f"{share:.2f}" for share in seen.force_load_share),
        f"{size / 1000:.0f}",
    )


def made(name: str, form: Form) -> tuple[str, ...]:
    """How a policy was made."""
    said, training = form.notes[MADE], form.notes[KEY]["training"]
    revision = f"`{said['revision'][:10]}`"
    return f"`{name}`", f"{training['steps']:,}", f"`{said['command']}`", revision


def main() -> None:
    """Run what the command line asks for."""
    wanted, console = tyro.cli(Pretrained), Console()
    every = [f"{task}/{control}" for task in TASKS for control in CONTROLS]
    for name in wanted.only or every:
        form = chosen(wanted, name)
        if form is None:
            console.print(f"{name}: there is none", markup=False)
            continue
        console.print(f"{name}: {100 * row(form).success_rate:.1f} %", markup=False)
        if wanted.write:
            path = Path(__file__).parents[1] / "agents" / "pretrained"
            PlainPolicy(form).save(path / f"{name.replace('/', '_')}{SUFFIX}")
    there = [name for name in every if name in names()]
    forms = {name: read_form(file_of(f"{WORD}:{name}")) for name in there}
    tables = {
        "pretrained": markdown(COLUMNS, [cells(name, form) for name, form in forms.items()]),
        "pretrained-made": markdown(HOW, [made(name, form) for name, form in forms.items()]),
    }
    for table in tables.values():
        console.print(table, markup=False, soft_wrap=True)
    if wanted.write:
        fill(PAGE, tables)


if __name__ == "__main__":
    main()
