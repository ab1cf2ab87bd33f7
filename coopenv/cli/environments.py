"""Environments of an evaluation: what each policy's file records, with what the options change."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from coopenv.agents.settings import EnvironmentChoice, TrainConfig, find_config
from coopenv.config import TransportConfig
from coopenv.config.own_code import Trust, is_trusted
from coopenv.envs.registry import require_trusted
from coopenv.errors import CoopenvError, InvalidInput

RECORDED = "recorded"  # instead of an id: the environment that a policy was trained in


@dataclass(frozen=True)
class Environment:
    """An environment and the id it began from."""

    env: str
    config: TransportConfig

    def title(self, trust: Trust = False) -> str:
        """The id, and in words what is not its default.

        The id may come from a file: the module before its colon is imported only if it is one that
        is trusted.
        """
        from coopenv.agents.differences import described

        module, _, name = self.env.rpartition(":")
        try:
            default = find_config(self.env if module and is_trusted(module, trust) else name, {})
        except CoopenvError:
            return f"{self.env}, which is not registered here"
        others = described(self.config, default)
        return f"{self.env} with {', '.join(others)}" if others else self.env


def environments_of(
    named: Mapping[str, str], choice: EnvironmentChoice, trust: Trust = False
) -> tuple[dict[str, Environment], list[str]]:
    """The environment of each policy, and what there is to say about them.

    Parameters
    ----------
    named
        Label → name of a policy: a file, ``random`` or ``scripted``.
    choice
        Options of the command line; with an id they are the whole environment, else they change
        what is recorded.
    trust
        Modules of the user's own that a record may import; ``True``: any.

    Raises
    ------
    InvalidInput, UnknownName
        If a record cannot be read, or the options do not go with it.
    """
    if choice.env != RECORDED:
        return dict.fromkeys(named, Environment(choice.env, choice.config())), []
    found: dict[str, Environment] = {}
    notes: list[str] = []
    for label, name in named.items():
        if Path(name).is_file():
            environment, note = _recorded(Path(name), trust)
            found[label] = replace(environment, config=choice.over(environment.config))
            notes += note
    default = EnvironmentChoice().env
    others = next(iter(found.values()), None) or Environment(
        default, choice.over(find_config(default, {}))
    )
    return {label: found.get(label, others) for label in named}, notes


def _recorded(path: Path, trust: Trust) -> tuple[Environment, list[str]]:
    """What a policy's file records; without a record, what the settings beside it name.

    Raises `InvalidInput` if nothing says it.
    """
    from coopenv.agents.provenance import Provenance

    provenance = Provenance.read(path)
    if provenance is not None:
        others = provenance.other_versions()
        notes = [f"{path} was trained with {', '.join(others)}"] if others else []
        return Environment(provenance.env, provenance.config(trust=trust)), notes
    beside = path.with_name("config.json")
    if not beside.is_file():
        raise InvalidInput(
            f"policy must say which environment it was trained in, got {path}, which does not; "
            "give --env and the options that make it that one, or save it with SB3Policy.save "
            "while its model has its environment"
        )
    choice = TrainConfig.load(beside).environment
    require_trusted(choice.env, trust, str(beside))
    note = (
        f"{path} does not say which environment it was trained in; it is evaluated in "
        f"{choice.env}, which {beside} names; --env and the other options choose another"
    )
    return Environment(choice.env, choice.config()), [note]
