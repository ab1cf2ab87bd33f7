"""A page for each environment, written from the code: docs/environments/.

python -m benchmarks.site.environments            # says which pages are not what the code says
python -m benchmarks.site.environments --write    # and writes them
"""

import inspect
import re
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import gymnasium

from benchmarks.pages import DOCS, markdown
from benchmarks.site.docstrings import parameters, prose, unit_of
from coopenv import Transport, TransportConfig
from coopenv.envs.common import team_action_space, team_observation_space
from coopenv.envs.registry import PREFIX, find_config
from coopenv.files import written
from coopenv.observation import BLOCKS
from coopenv.observation.block import Block

FOLDER = DOCS / "environments"
_PICTURE = "The scripted controller's first held-out episode, at four moments"
# What each version changed; the first one has nothing before it.
VERSIONS = {"v0": "The first version."}


def ids() -> list[str]:
    """The registered ids of this package, in the order in which they are listed."""
    return [name for name in gymnasium.registry if name.startswith(PREFIX)]


def page_of(name: str) -> Path:
    """The page of an id: its module's name without the version."""
    return FOLDER / f"{_module(name).removesuffix('_v0')}.md"


def _module(name: str) -> str:
    return gymnasium.spec(name).entry_point.partition(":")[0].rpartition(".")[2]  # pyright: ignore


def text_of(name: str) -> str:
    """The whole page of an id."""
    core = Transport(num_worlds=1, config=find_config(name, {}))
    title = name.removeprefix(PREFIX).partition("-")[0]
    parts = [
        f"<!-- python -m benchmarks.site.environments --write -->\n# {title}",
        f"![{_PICTURE}](../tasks/{title}.png)",
        _in_short(name, core),
        f"## Description\n\n{_description(type(core.config.task))}",
        f"## Action space\n\n{_actions(core)}",
        f"## Observation space\n\n{_observations(core)}",
        f"## Rewards\n\n{_rewards(core.config)}",
        f"## Starting state\n\n{_start(core.config)}",
        f"## Episode end\n\n{_end(core.config)}",
        f"## Arguments\n\n{_arguments(name, core.config)}",
        "## Version history\n\n"
        + "\n".join(f"- **{version}**: {what}" for version, what in VERSIONS.items()),
    ]
    return "\n\n".join(parts) + "\n"


def _in_short(name: str, core: Transport) -> str:
    module, config = _module(name), core.config
    rows = [
        ("Gymnasium", f'`gymnasium.make("{name}")`'),
        ("Gymnasium, a batch", f'`gymnasium.make_vec("{name}", num_envs=256)`'),
        ("PettingZoo", f"`coopenv.{module}.parallel_env()`, `coopenv.{module}.env()`"),
        ("agents", ", ".join(f"`agent_{k}`" for k in range(core.num_agents))),
        ("action space", f"`{_box(team_action_space(core))}`; {_own(core.action_size)}"),
        ("observation space", f"`{_box(team_observation_space(core))}`; {_own(_width(core))}"),
        ("horizon", f"{config.horizon} steps of {config.dt:g} s: {config.horizon * config.dt:g} s"),
    ]
    return markdown(("", ""), rows)


def _box(space: gymnasium.Space) -> str:
    low, high = {f"{x:g}" for x in space.low.flat}, {f"{x:g}" for x in space.high.flat}  # pyright: ignore
    ends = (min(low), max(high)) if len(low) == len(high) == 1 else ("low", "high")
    return f"Box({ends[0]}, {ends[1]}, {space.shape}, {space.dtype})"


def _own(size: int) -> str:
    return f"PettingZoo: ({size},) an agent"


def _width(core: Transport) -> int:
    return max(part.stop for part in core.observation.blocks.values())


def _description(kind: type) -> str:
    text = inspect.getdoc(kind) or ""
    return prose(re.split(r"\n\n(?:Parameters|Raises)\n-+", text)[0])


def _actions(core: Transport) -> str:
    config, module = core.config, "actions.md"
    rows = []
    names = (("fx", "along x, towards the centre of mass"), ("fy", "along y"), ("tz", "torque"))
    for k, (symbol, what) in enumerate(names):
        limits = config.torque_limit if symbol == "tz" else config.force_limit
        unit = "N·m" if symbol == "tz" else "N"
        rows.append((str(k), symbol, what, "[−1, 1]", f"{limits:g} {unit}"))
    table = markdown(("number", "symbol", "what", "range", "an action of 1"), rows)
    return (
        f"Each agent applies a wrench in its own frame, which is held over the step. Forces alone, "
        f"numbers of pushes, hands that give way: [the kinds of action](../{module}).\n\n{table}"
    )


def _observations(core: Transport) -> str:
    blocks = {**BLOCKS, **{block.name: block for block in core.config.task.blocks}}
    rows = []
    for name, part in core.observation.blocks.items():
        block: Block = blocks[name]
        place = f"{part.start}:{part.stop}" if part.stop - part.start > 1 else f"{part.start}"
        rows.append((f"`{name}`", place, block.unit, block.frame or "—", block.describe))
    table = markdown(("block", "features", "unit", "frame", "what it is"), rows)
    return (
        "What one agent sees; the Gymnasium view has that of each agent, one after the other. "
        "`env.unwrapped.observation_blocks` gives the slices. Other blocks, senses, noise and "
        f"delay: [what agents see](../observations.md).\n\n{table}"
    )


def _rewards(config: TransportConfig) -> str:
    rows = []
    for name, term in config.reward.items():  # pyright: ignore[reportAttributeAccessIssue]
        first = prose((inspect.getdoc(type(term)) or "").partition("\n")[0])
        weight = getattr(term, "weight", None)
        shown = "" if weight is None else f"{weight:g} {unit_of(type(term), 'weight')}".strip()
        rows.append((f"`reward/{name}`", f"`{type(term).__name__}`", first, shown))
    table = markdown(("in the info", "term", "what it is", "weight"), rows)
    return (
        "The sum of these terms, for each agent; the Gymnasium view has the mean over the team. "
        f"Others, and your own: [rewards](../rewards.md).\n\n{table}"
    )


def _start(config: TransportConfig) -> str:
    draws = prose((inspect.getdoc(type(config.task).sample) or "").partition("\n\n")[0])
    return (
        f"{draws} The object is at rest. `reset(seed=)` decides it all; "
        '`reset(options={"pose": (x, y, θ), "goal": (x, y, θ)})` gives places of your own '
        "([resets](../state.md))."
    )


def _end(config: TransportConfig) -> str:
    kind = type(config.task)
    lines = [f"- **Terminated, success**: {_first(kind.success)}"]
    if "due" in _written(kind):
        lines.append(f"  It counts only when {_case(kind.due)}")
    if "failure" in _written(kind):
        lines.append(f"- **Terminated, failure**: when {_case(kind.failure)}")
    lines.append(
        f"- **Truncated**: after `horizon` = {config.horizon} control steps. Bootstrap from the "
        "last observation then, not after success or failure."
    )
    return "\n".join(lines)


def _first(hook: Any) -> str:
    return prose((inspect.getdoc(hook) or "").partition("\n\n")[0])


def _case(hook: Any) -> str:
    return _first(hook).removeprefix("Whether ")


def _written(kind: type) -> set[str]:
    """Names that a task's own classes write, below `coopenv.Task`."""
    own = [each for each in kind.__mro__ if each.__module__ != "coopenv.tasks.base"]
    return {name for each in own for name in vars(each)}


def _arguments(name: str, config: TransportConfig) -> str:
    plain = find_config(f"{PREFIX}BeamTransport-v0", {})
    changed = [
        (f"`{entry.name}`", f"`{_shown(getattr(config, entry.name))}`")
        for entry in fields(config)
        if getattr(config, entry.name) != getattr(plain, entry.name)
        and entry.name not in ("task", "observe", "reward")
    ]
    kind = type(config.task)
    told = parameters(kind)
    rows = [
        (f"`{entry.name}`", f"`{getattr(config.task, entry.name)!r}`", unit_of(kind, entry.name),
         told.get(entry.name, ""))
        for entry in fields(config.task)  # pyright: ignore[reportArgumentType]
    ]  # fmt: skip
    own = markdown(("field", "default", "unit", "what it is"), rows)
    text = (
        "Every keyword of [the README](../../README.md#keywords) works: "
        f'`gymnasium.make("{name}", horizon=100)`. Of the task, `coopenv.{kind.__name__}`, '
        f"given as `task=coopenv.{kind.__name__}(position_tolerance=0.05)`:\n\n{own}"
    )
    if changed:
        table = markdown(("keyword", "default"), changed)
        text += f"\n\nWhat differs from BeamTransport besides:\n\n{table}"
    return text


def _shown(value: Any) -> str:
    """A value as one writes it, without the fields that are as they always are."""
    if not hasattr(value, "__dataclass_fields__"):
        return repr(value)
    plain = type(value)()
    given = [
        f"{entry.name}={getattr(value, entry.name)!r}"
        for entry in fields(value)
        if getattr(value, entry.name) != getattr(plain, entry.name)
    ]
    return f"{type(value).__name__}({', '.join(given)})"


def stale() -> dict[Path, str]:
    """Pages that are not what the code says, and what they should be."""
    wanted = {page_of(name): text_of(name) for name in ids()}
    return {
        page: text
        for page, text in wanted.items()
        if not page.exists() or page.read_text(encoding="utf-8") != text
    }


def main() -> None:
    """Say which pages are old; with ``--write`` write them."""
    for page, text in stale().items():
        print(page.relative_to(DOCS.parent))
        if "--write" in sys.argv[1:]:
            page.parent.mkdir(exist_ok=True)
            with written(page) as part:
                part.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
