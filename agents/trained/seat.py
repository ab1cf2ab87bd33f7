"""Seat of a learned policy: what it sees and whom it drives as a partner, by what its file records.

A partner may act in an environment that shows the learners other blocks, so the policy's own are
read for it. Its record says which they are; sizes say how many agents share a row.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from coopenv.arrays import FloatArray
from coopenv.config import ACTIONS, TransportConfig
from coopenv.config.document import KIND, VERSION, fields_in
from coopenv.config.keywords import read_observe
from coopenv.config.own_code import Trust
from coopenv.errors import CoopenvError, InvalidInput
from coopenv.observation import Entry, Observation
from coopenv.observation.bounds import Bounds
from coopenv.pushes import read_pushes, table_of
from coopenv.tasks import TASKS, RollingTask

from ..policy import Policy, Seat
from .record import check_kind, part_of
from .spaces import Spaces, said

_OWN_BLOCKS = "; blocks of your own need a file, and LearnedPartner(path=..., trust=True)"


def seat_of(
    policy: Policy,
    spaces: Spaces,
    notes: Mapping[str, Any],
    config: TransportConfig,
    agents: tuple[int, ...],
    trust: Trust = False,
) -> Seat:
    """Where a policy with these ``spaces`` and ``notes`` sits when it drives ``agents``.

    Raises
    ------
    InvalidInput
        If it cannot see what it was trained on, or was trained for other actions or another team.
    """
    observe = seen_by(notes, config, trust)
    bounds = bounds_for(notes, config)
    seen = Observation(observe, config.num_agents, bounds=bounds)
    chosen = seats(spaces, notes, seen, config, agents)
    return Seat(policy, observe, chosen, pushes_of(spaces, notes, config), bounds)


def seen_by(notes: Mapping[str, Any], config: TransportConfig, trust: Trust) -> tuple[Entry, ...]:
    """The blocks on which a policy was trained; without a record those of the environment.

    Raises
    ------
    InvalidInput
        If one of them is not to be had in this environment, or is code that is not trusted.
    """
    environment = part_of(notes, "environment")
    if "observe" not in environment:
        return tuple(config.observe)
    kept = {"kind": KIND, "version": VERSION, "observe": environment["observe"]}
    try:
        entries = fields_in(json.dumps(kept), tuple(kept), trust)["observe"]
        return read_observe(None, entries, config.task)
    except CoopenvError as error:
        own = not trust and '"sha256"' in json.dumps(kept)
        raise InvalidInput(
            "partner must see what it was trained on, which cannot be read in this environment: "
            f"{error}{_OWN_BLOCKS * own}"
        ) from error


def bounds_for(notes: Mapping[str, Any], config: TransportConfig) -> Bounds | None:
    """Those of this environment, for a policy that was trained on ``bounded`` observations."""
    if part_of(notes, "environment").get("bounded") is not True:
        return None
    return replace(config, bounded=True).bounds()


def seats(
    spaces: Spaces,
    notes: Mapping[str, Any],
    seen: Observation,
    config: TransportConfig,
    agents: tuple[int, ...],
) -> tuple[int, ...]:
    """The agents whose sight a policy gets when it drives ``agents``.

    A policy of the whole team sees all of them, and what it would do with the others is left out.

    Raises
    ------
    InvalidInput
        If it was trained on other sizes, for a team of another size, as another kind of agent, or
        with actions of another kind than here, where hands carry out one of them.
    """
    counts = config.num_agents, len(agents)
    check_kind(part_of(notes, "environment"), config.action)
    try:
        in_row = spaces.agents_in_row(counts, seen.size, ACTIONS[config.action])
        spaces.check_bounds(seen, in_row)
    except InvalidInput as error:
        raise InvalidInput(f"partner must have learned in a team like this one: {error}") from error
    control = part_of(notes, "training").get("control", "shared")  # not known: no team is refused
    if in_row == 1 and len(agents) > 1 and control != "shared":
        raise InvalidInput(
            f"partner_agents must name one agent for a policy that was trained for one "
            f"(control={control!r}), got {agents}; name one, or train it with control='shared'"
        )
    chosen = tuple(range(config.num_agents)) if in_row == config.num_agents else agents
    if in_row < config.num_agents and control != "shared":
        _check_role(part_of(notes, "environment"), config, chosen)
    return chosen


def pushes_of(
    spaces: Spaces, notes: Mapping[str, Any], config: TransportConfig
) -> FloatArray | None:
    """``(push, 3)``: what a policy's numbers stand for, as it is recorded; ``None`` for a box.

    Raises
    ------
    InvalidInput
        If it is not known, or has a torque that agents do not give here.
    """
    if spaces.pushes is None:
        return None
    recorded = part_of(notes, "environment").get("pushes")
    table = config.table if recorded is None else table_of(read_pushes(recorded))
    if table is None or len(table) != spaces.pushes:
        there = None if table is None else len(table)
        raise InvalidInput(
            f"partner must choose from pushes that are known, {said(spaces.pushes)}, got "
            f"{said(there)}; give the pushes= of its training to an environment with "
            "action='discrete'"
        )
    if config.action == "force" and table[:, 2].any():
        raise InvalidInput(
            "action must be 'wrench' or 'discrete' beside a partner whose pushes have a torque, "
            "got 'force'; choose another action"
        )
    return table


def _check_role(
    environment: Mapping[str, Any], config: TransportConfig, agents: tuple[int, ...]
) -> None:
    """Raise if it learned as another agent than those it drives, where agents are not alike."""
    rolls = isinstance(config.task, RollingTask)
    if _rolled(environment.get("task")) not in (rolls, None):
        here, there = ("", "out") if rolls else ("out", "")
        raise InvalidInput(
            f"partner must have learned to move a body with{here} wheels, got one that learned in "
            f"{environment['task'].get('kind')}, with{there}; its role there says nothing here"
        )
    if not rolls or environment.get("partner") is None:
        return
    named = environment.get("partner_agents")
    driven = config.task.partner_agents(config.num_agents) if named is None else named
    if not isinstance(driven, Sequence):
        return
    learned_as = tuple(agent for agent in range(config.num_agents) if agent not in driven)
    if learned_as != agents:
        raise InvalidInput(
            f"partner_agents must be those as which the policy was trained, {learned_as}, as the "
            f"agents of a body on wheels are not alike, got {agents}; pass "
            f"partner_agents={learned_as}"
        )


def _rolled(task: Any) -> bool | None:
    """Whether the task that is recorded is one of a body on wheels; ``None`` of one not ours."""
    kind = task.get("kind") if isinstance(task, Mapping) else None
    known = {f"coopenv.{each.__name__}": issubclass(each, RollingTask) for each in TASKS}
    return known.get(str(kind))
