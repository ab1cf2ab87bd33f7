"""Sum of named reward terms, which reports each of its parts."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from math import inf
from typing import Any, Protocol

import numpy as np

from coopenv.arrays import LARGEST, FloatArray, number
from coopenv.compiled.checks import is_finite
from coopenv.errors import InvalidInput, UnknownName
from coopenv.info import Info
from coopenv.transition import Transition

from .together import Together


class Term(Protocol):
    """Pure and stateless: a transition in, one reward for each agent of each world out.

    The transition's arrays are shared with observations, infos and the next step: read only.
    """

    def __call__(self, transition: Transition) -> FloatArray:
        """Reward ``(world, agent)``."""
        ...


class RewardSum(Mapping[str, Term]):
    """Named terms; calling it returns the total and every part, each evaluated once.

    The sum is never clipped.

    Parameters
    ----------
    terms
        Name → term. The names become the keys of ``info["reward/<name>"]``.

    Raises
    ------
    InvalidInput
        If there is no term, a name is not a string, a term cannot be called, its weight is not
        a finite number or beyond 1e12.
    """

    def __init__(self, terms: Mapping[str, Term]):
        if not terms:
            raise InvalidInput("reward must have at least one term, got none; see rewards.PRESETS")
        for name, term in terms.items():
            if hasattr(term, "weight"):
                weight = number(term.weight, f"weight of reward {name!r}")  # pyright: ignore[reportAttributeAccessIssue]
                if abs(weight) > LARGEST:
                    raise InvalidInput(
                        f"weight of reward {name!r} must be at most {LARGEST:g}, got {weight}; "
                        "lower it"
                    )
            if isinstance(name, str) and (not name or "/" in name):
                raise InvalidInput(
                    f"names of terms must be words without a slash, got {name!r}; infos have them "
                    "as reward/<name>"
                )
            if not isinstance(name, str) or not callable(term):
                raise InvalidInput(
                    f"reward must map names to callable terms, got {name!r}: {term!r}; "
                    "build it from coopenv.rewards, or name a preset"
                )
        self._terms = dict(terms)
        self._arrange()

    def _arrange(self) -> None:
        """Part the terms into the first ones, which are written together, and the others."""
        self._together = Together(self._terms)
        self._others = list(self._terms.items())[len(self._together.names) :]

    def __getstate__(self) -> dict[str, Any]:
        arranged = ("_together", "_others")
        return {name: value for name, value in vars(self).items() if name not in arranged}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._arrange()

    def __call__(
        self, transition: Transition, *, what: str = "reward"
    ) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Total ``(world, agent)`` and its parts by name; ``what`` it is, for errors.

        Raises
        ------
        InvalidInput
            If a term returns another shape or something that is not finite, or the sum is not.
        """
        found = self._together(transition) if self._together.names else None
        if found is not None:
            total, parts, finite = found
            if finite and not self._others:
                return total, parts
            others = self._others
        else:
            total, parts = np.zeros(transition.applied.shape[:2]), {}
            others = self._terms.items()
        shape = total.shape
        for name, term in others:
            part = term(transition)
            if getattr(part, "shape", None) != shape:
                raise InvalidInput(
                    f"{what} {name!r} must return an array (world, agent) = {shape}, got "
                    f"shape {np.shape(part)}; transition.per_agent repeats one value a world"
                )
            total += part
            # Infos are read later, when a term of the user's may have written to its array again.
            parts[name] = np.array(part)
        if not is_finite(total):
            check_finite(parts, what=what)
            check_finite(parts, at_most=LARGEST, what=what)  # finite, but their sum is not
        return total, parts

    def __getitem__(self, name: str) -> Term:
        return self._terms[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._terms)

    def __len__(self) -> int:
        return len(self._terms)

    def __hash__(self) -> int:
        return hash(frozenset(self._terms.items()))

    def __repr__(self) -> str:
        return f"RewardSum({self._terms!r})"

    def check(self, num_agents: int) -> None:
        """Ask the terms that have a ``check`` whether they go with a team of that size.

        Raises
        ------
        InvalidInput
            If one does not.
        """
        for term in self._terms.values():
            check = getattr(term, "check", None)
            if check is not None:
                check(num_agents)

    def with_weights(self, **weights: float) -> "RewardSum":
        """The same terms under other weights, by name; a term that is not there raises."""
        terms = dict(self._terms)
        for name, weight in weights.items():
            if name not in terms:
                raise UnknownName("reward term", name, terms)
            terms[name] = replace(terms[name], weight=weight)  # pyright: ignore[reportArgumentType, reportCallIssue]
        return RewardSum(terms)


def check_finite(
    parts: Mapping[str, FloatArray], *, at_most: float = inf, what: str = "reward"
) -> None:
    """Raise `InvalidInput` for the first term with a reward that is not finite, or too large.

    Parameters
    ----------
    parts
        Rewards ``(world, agent)`` by the names of their terms.
    at_most
        Largest magnitude that is allowed.
    what
        They are, for the error.
    """
    for name, part in parts.items():
        wrong = ~np.isfinite(part) | (np.abs(part) > at_most)
        if wrong.any():
            bound = "" if at_most == inf else f" and at most {at_most:g}"
            world, agent = np.argwhere(wrong)[0]
            raise InvalidInput(
                f"{what} {name!r} must be finite{bound}, got {part[world, agent]} for agent "
                f"{agent} of world {world}; mend the term: a division by zero, a root or a "
                "logarithm of what may be negative, or a scale"
            )


def check_learnable(reward: FloatArray, info: Info) -> None:
    """Raise `InvalidInput` if a reward is beyond 1e12: learners square it, in float32."""
    if np.vdot(reward, reward) > LARGEST**2:  # one number for the whole batch
        check_finite(info["reward_terms"], at_most=LARGEST)


def recompute(
    reward: RewardSum, transitions: Iterable[Transition]
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Rewards of logged transitions, under any sum of terms; nothing is simulated again.

    Parameters
    ----------
    reward
        For example ``PRESETS["harmony"].with_weights(relative_cost=1.0)``.
    transitions
        One a step, as ``core.transition`` had them (they can be pickled).

    Returns
    -------
    Total ``(step, world, agent)`` and its parts by name, of the same shape.

    Raises
    ------
    InvalidInput
        If there is no transition, or a term returns something that is not finite.
    """
    steps = [reward(transition) for transition in transitions]
    if not steps:
        raise InvalidInput("transitions must hold at least one step, got none; log some first")
    total = np.stack([step_total for step_total, _ in steps])
    return total, {name: np.stack([parts[name] for _, parts in steps]) for name in reward}
