"""Environments of an evaluation: what each policy's file records, with what the options change."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from coopenv.agents.environment import EnvironmentChoice, find_config
from coopenv.agents.pretrained.naming import file_of, is_name
from coopenv.agents.settings import TrainConfig
from coopenv.config import TransportConfig
from coopenv.config.own_code import Trust, is_trusted
from coopenv.envs.registry import require_trusted
from coopenv.errors import CoopenvError, InvalidInput

if TYPE_CHECKING:
    from coopenv.agents.provenance import Provenance

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
        only = Environment(choice.env, _trusting(choice.config(), trust))
        return dict.fromkeys(named, only), []
    found: dict[str, Environment] = {}
    notes: list[str] = []
    for label, name in named.items():
        file = file_of(name)
        if file.is_file():
            environment, note = _recorded(file, trust)
            note = [] if is_name(name) else note  # its row says whether it still acts as it did
            config = _trusting(choice.over(environment.config), trust)
            found[label] = replace(environment, config=config)
            notes += note
    default = EnvironmentChoice().env
    others = next(iter(found.values()), None) or Environment(
        default, _trusting(choice.over(find_config(default, {})), trust)
    )
    return {label: found.get(label, others) for label in named}, notes


def _trusting(config: TransportConfig, trust: Trust) -> TransportConfig:
    """The configuration, its partner's file trusted where all of what files hold is."""
    from coopenv.agents.partners import trusting

    return trusting(config) if trust is True else config


def _recorded(path: Path, trust: Trust) -> tuple[Environment, list[str]]:
    """What a policy's file records; without a record, what the run beside it does.

    The settings of a run that was given its environment from Python do not name it, so that the
    run's own record comes first.

    Raises `InvalidInput` if nothing says it.
    """
    from coopenv.agents.provenance import Provenance

    provenance = Provenance.read(path)
    if provenance is not None:
        return _as_recorded(provenance, str(path), trust)
    beside = path.with_name("config.json")
    if not beside.is_file():
        raise InvalidInput(
            f"policy must say which environment it was trained in, got {path}, which does not; "
            "give --env and the options that make it that one, or save it with SB3Policy.save "
            "while its model has the environment it learned in"
        )
    provenance = Provenance.read_beside(beside)
    if provenance is not None:
        place, notes = _as_recorded(provenance, str(beside), trust)
        how = f"as {beside} records it"
    else:
        choice = TrainConfig.load(beside).environment
        require_trusted(choice.env, trust, str(beside))
        place, notes = Environment(choice.env, choice.config()), []
        how = f"which {beside} names"
    note = (
        f"{path} does not say which environment it was trained in; it is evaluated in "
        f"{place.env}, {how}; --env and the other options choose another"
    )
    return place, [note, *notes]


def _as_recorded(
    provenance: "Provenance", source: str, trust: Trust
) -> tuple[Environment, list[str]]:
    """The environment of a record, and a note where versions are others now."""
    try:
        config = provenance.config(trust=trust)
    except CoopenvError as error:
        raise InvalidInput(f"{error} (in {source})") from error
    others = provenance.other_versions()
    notes = [f"{source} was trained with {', '.join(others)}"] if others else []
    return Environment(provenance.env, config), notes
