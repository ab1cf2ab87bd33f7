"""Blueprint of a learned model: in plain values all that is needed to build it anew.

Stable-Baselines3 keeps spaces, keywords and classes in pickles, and reading one runs what it says.
With a blueprint beside them a file is read without: the algorithm is constructed as usual, in an
environment that has nothing but spaces, and gets its weights.
"""

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from inspect import Parameter, signature
from itertools import pairwise
from typing import Any

from gymnasium.spaces.utils import flatdim
from stable_baselines3.common.base_class import BaseAlgorithm

from coopenv.errors import InvalidInput

from ..trained.spaces import NotPlain, plain_space, space_of
from .plain import revived, shown
from .scaling import FallingRate
from .still import Still

FORMAT = 1  # raised when a blueprint of before would mean something else
_NAMES = {"format", "policy", "spaces", "rows", "policy_kwargs", "settings", "unwritten", "steps"}
_SPACES = ("observation_space", "action_space")
_MOST_ROWS, _MOST_STEPS = 10**6, 10**15
_LAYERS = ("net_arch", "lstm_hidden_size", "n_lstm_layers", "n_critics", "n_quantiles")
_LEFT_OUT = (  # of the constructor: said elsewhere, or of one process alone
    *("self", "policy", "env", "policy_kwargs", "device", "verbose", "tensorboard_log"),
    *("monitor_wrapper", "_init_setup_model"),
    *("use_rms_prop", "rms_prop_eps"),  # of A2C, which keeps them in policy_kwargs
)
_RESIDUAL = "ResidualLstmPolicy"  # `sequences.Residual`, the one policy that is ours
_PACKAGES = ("stable_baselines3.", "sb3_contrib.")  # whose classes of buffers are chosen anew


@dataclass(frozen=True)
class Unwritten:
    """In place of a learning rate's schedule: settings that the file does not say in plain values.

    The model acts as it did; it does not train on with other settings unnoticed.
    """

    names: tuple[str, ...]

    def __call__(self, remaining: float) -> float:
        """Raise `InvalidInput` that says what is missing."""
        raise InvalidInput(
            f"{', '.join(self.names)} must be known to train on, got a model whose file does not "
            "say it in plain values; load it with trust=True if you trust the file"
        )


def blueprint_of(model: BaseAlgorithm) -> dict[str, Any]:
    """What `build` needs; else, under ``needs_trust``, what keeps it from being said plainly."""
    try:
        return {
            "format": FORMAT,
            "policy": _alias(model),
            "spaces": {name: plain_space(getattr(model, name)) for name in _SPACES},
            "rows": model.n_envs,
            "policy_kwargs": shown(dict(model.policy_kwargs)),
            **_settings(model),
            "steps": model.num_timesteps,
        }
    except NotPlain as error:
        return {"format": FORMAT, "needs_trust": str(error)}


def check_format(blueprint: Mapping[str, Any], source: str) -> Mapping[str, Any]:
    """The blueprint in ``source``, if it is of a format that `build` knows; else `InvalidInput`."""
    if blueprint.get("format") != FORMAT:
        raise InvalidInput(
            f"blueprint of a policy must be of format {FORMAT}, got "
            f"{blueprint.get('format')!r:.40} in {source!r}; read it with the coopenv that wrote "
            "it, or a newer one"
        )
    return blueprint


def build(blueprint: Mapping[str, Any], algorithm: type[BaseAlgorithm], count: int) -> Any:
    """A model of ``algorithm`` as the blueprint says, its weights still random.

    Parameters
    ----------
    count
        Numbers that the policy's weights have: no layer is built that cannot be theirs.

    Raises
    ------
    Exception
        Of any kind, from here or from the algorithm, if the blueprint is damaged or of another one.
    """
    if set(blueprint) != _NAMES:
        raise ValueError("its blueprint lacks or adds something")
    spaces = {name: space_of(blueprint["spaces"][name]) for name in _SPACES}
    keywords = revived(blueprint["policy_kwargs"])
    observed: Any = spaces["observation_space"]
    (features,) = observed.shape
    _check_sizes(keywords, features, count)
    if flatdim(spaces["action_space"]) * _last_width(keywords) > count:
        raise ValueError("it chooses from more than its weights can tell apart")
    settings = {name: revived(value) for name, value in blueprint["settings"].items()}
    _check_settings(settings, algorithm)
    rows, steps = _whole(blueprint["rows"], _MOST_ROWS), _whole(blueprint["steps"], _MOST_STEPS)
    make: Any = algorithm
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # told when it was trained
        model = make(
            _policy(blueprint, algorithm),
            Still(rows, **spaces),
            device="cpu",
            policy_kwargs=keywords,
            **settings,
        )
    model.env = None
    model.num_timesteps = steps
    unwritten = blueprint["unwritten"]
    if not isinstance(unwritten, list) or not all(isinstance(name, str) for name in unwritten):
        raise ValueError(f"unwritten settings are {unwritten!r:.40}")
    if unwritten:
        model.lr_schedule = Unwritten(tuple(unwritten))
    return model


def _policy(blueprint: Mapping[str, Any], algorithm: type[BaseAlgorithm]) -> str | type:
    name = blueprint["policy"]
    if (algorithm.__name__, name) == ("RecurrentPPO", _RESIDUAL):
        from .sequences import Residual  # needs sb3-contrib, which this algorithm is of

        return Residual
    if name not in algorithm.policy_aliases:
        raise ValueError(f"{algorithm.__name__} has no policy {name!r:.40}")
    return name


def _alias(model: BaseAlgorithm) -> str:
    own = getattr(model.policy_class, "ALIAS", None)
    if own == _RESIDUAL:
        return own
    for name, kind in type(model).policy_aliases.items():
        if kind is model.policy_class:
            return name
    raise NotPlain(f"the policy class {model.policy_class!r}")


def _settings(model: BaseAlgorithm) -> dict[str, Any]:
    """The constructor's keywords as the model keeps them, and those that are not plain."""
    written: dict[str, Any] = {}
    before = model.lr_schedule if hasattr(model, "lr_schedule") else None
    unwritten = list(before.names) if isinstance(before, Unwritten) else []
    for name in _parameters(type(model)):
        if name in unwritten:
            continue
        try:
            value = _unwrapped(_kept(vars(model), name))
            if not (isinstance(value, type) and value.__module__.startswith(_PACKAGES)):
                written[name] = shown(value)
        except (KeyError, NotPlain):
            unwritten.append(name)
    return {"settings": written, "unwritten": unwritten}


def _parameters(algorithm: type[BaseAlgorithm]) -> dict[str, Parameter]:
    found = signature(algorithm.__init__).parameters
    kinds = (Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY)
    return {
        name: each for name, each in found.items() if name not in _LEFT_OUT and each.kind in kinds
    }


def _kept(attributes: Mapping[str, Any], name: str) -> Any:
    """The value of a constructor's keyword; raises `KeyError` where the model keeps none."""
    kept = [each for each in (name, f"_{name}", f"{name}_schedule") if each in attributes]
    return attributes[kept[0] if kept else name]


def _unwrapped(value: Any) -> Any:
    """A schedule without what SB3 wraps it in, a constant one as its number."""
    value = getattr(value, "value_schedule", value)
    return value.val if type(value).__name__ == "ConstantSchedule" else value


def _check_settings(settings: Mapping[str, Any], algorithm: type[BaseAlgorithm]) -> None:
    """Raise unless each is a keyword of the algorithm, of the kind of its default."""
    known = _parameters(algorithm)
    for name, value in settings.items():
        if name not in known:
            raise ValueError(f"{algorithm.__name__} has no setting {name!r:.40}")
        default = known[name].default
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if isinstance(default, bool):
            fits = isinstance(value, bool)
        elif isinstance(default, int | float):
            fits = value is None or is_number or isinstance(value, tuple | FallingRate)
        else:
            fits = value is None or is_number or isinstance(value, dict | type(default))
        if not fits:
            raise ValueError(f"{name} is {value!r:.40}")


def _check_sizes(keywords: Any, features: int, count: int) -> None:
    """Raise if layers are wider than their weights are many, before memory is asked for them."""
    if not isinstance(keywords, dict):
        raise ValueError("policy_kwargs are no names with values")
    sizes = [size for name in _LAYERS for size in _sizes(keywords.get(name), features)]
    if any(size > count for size in sizes):
        raise ValueError(f"its layers have more than the {count} weights of the file")


def _last_width(keywords: dict[str, Any]) -> int:
    """Units before those that tell the action, where the keywords say how many."""
    layers = keywords.get("net_arch")
    layers = layers.get("pi") if isinstance(layers, dict) else layers
    last = layers[-1] if isinstance(layers, list | tuple) and layers else 1
    return abs(last) if type(last) is int else 1


def _sizes(value: Any, before: int) -> Iterator[int]:
    """Numbers between layers of nested keywords, of which the first follow ``before`` features."""
    if type(value) is int:
        yield from (abs(value) * before, value * value)
    elif isinstance(value, dict):
        for each in value.values():
            yield from _sizes(each, before)
    elif isinstance(value, list | tuple):
        widths = [before, *(abs(each) for each in value if type(each) is int)]
        yield from (one * other for one, other in pairwise(widths))
        for each in value:
            if type(each) is not int:
                yield from _sizes(each, 1)


def _whole(value: Any, most: int) -> int:
    if type(value) is not int or not 0 <= value <= most:
        raise ValueError(f"{value!r:.40} is no whole number up to {most}")
    return value
