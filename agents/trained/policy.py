"""A trained policy in plain numbers, which acts by NumPy alone."""

import os
from typing import Any

import numpy as np
import numpy.typing as npt
from typing_extensions import Self

from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.transition import Transition
from coopenv.transport import Transport

from ..noise import Keyed, normals, uniforms
from ..policy import Seat
from .form import Form, read_form, write_form
from .record import check_trained_on
from .seat import seat_of


class PlainPolicy(Keyed):
    """A trained policy as a `coopenv.agents.policy.Policy` that needs no torch.

    It acts as the policy that it was made of, to the rounding of single precision: in the mean, or
    by the same random numbers.

    Parameters
    ----------
    form
        What its file holds.
    deterministic
        Take the mean action instead of a sample.
    seed
        Of sampled actions, which are keyed by it, by the episode's seed and by the step.

    Raises
    ------
    InvalidInput
        If actions shall be sampled of a policy that has no spread.
    """

    def __init__(self, form: Form, *, deterministic: bool = True, seed: int = 0):
        self.form, self.deterministic = form, deterministic
        if not (deterministic or form.network.has_spread):
            raise InvalidInput(
                f"deterministic must be True for a policy of {form.algorithm}, which has one way "
                "of acting, got False; leave it out"
            )
        super().__init__(seed)
        self._seed = seed

    @classmethod
    def load(cls, path: str | os.PathLike, *, deterministic: bool = True, seed: int = 0) -> Self:
        """Read what `save` or ``coopenv export`` wrote; nothing in the file is run.

        Raises
        ------
        InvalidInput
            If it is no such file, or damaged.
        """
        return cls(read_form(path), deterministic=deterministic, seed=seed)

    def save(self, path: str | os.PathLike) -> None:
        """Write arrays and JSON to one ``.npz`` file, whole or not at all."""
        write_form(self.form, path)

    @property
    def notes(self) -> dict[str, Any]:
        """What its file says beside the network, its provenance for example."""
        return dict(self.form.notes)

    def sampled(self) -> Self | None:
        """The same policy with sampled actions; ``None`` for one that has no spread."""
        if not self.deterministic:
            return self
        return (
            type(self)(self.form, deterministic=False, seed=self._seed)
            if self.form.network.has_spread
            else None
        )

    def frozen(self) -> Self:
        """A copy with random numbers of its own; no policy of this kind learns."""
        return type(self)(self.form, deterministic=self.deterministic, seed=self._seed)

    def as_partner(
        self, config: TransportConfig, agents: tuple[int, ...], *, trust: bool = False
    ) -> Seat:
        """Its seat among the ``agents`` that a partner drives; see `coopenv.agents.policy`.

        Raises
        ------
        InvalidInput
            If it cannot see there what it was trained on, or was trained for other actions or
            another team.
        """
        return seat_of(self, self.form.spaces, self.form.notes, config, agents, trust)

    def check_environment(self, core: Transport) -> None:
        """Raise `InvalidInput` if ``core`` is not what it was trained on, as far as that shows."""
        check_trained_on(self.form.notes, core, self.form.spaces.check_environment(core))

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)``, or numbers of pushes ``(world, learner)``.

        Raises
        ------
        InvalidInput
            If it was trained on other observations, other actions or a team of another size.
        """
        width = transition.action.shape[-1]
        rows = self.form.spaces.rows(obs, width)
        if self.form.normalization is not None:
            rows = self.form.normalization(rows)
        if not self.deterministic:
            self._keys.follow(transition)
        act = self._pushes if self.form.spaces.pushes is not None else self._action
        action = act(rows, transition)
        if not np.isfinite(action).all():
            raise InvalidInput(
                "actions of a policy must be finite, got nan or inf: its weights are too large; "
                "train anew with a lower learning_rate"
            )
        return self.form.spaces.by_agent(action, obs, width)

    def _action(self, rows: npt.NDArray, transition: Transition) -> npt.NDArray:
        if self.deterministic:
            return self.form.network.mean(rows)
        keys = self._keys.of_step(transition)
        count = len(rows) * self.form.network.units // len(keys)
        return self.form.network.sampled(rows, normals(keys, count).reshape(len(rows), -1))

    def _pushes(self, rows: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Of each row the pushes with the highest scores, or drawn by them."""
        agents = self.form.spaces.actions
        scores = self.form.network.ratings(rows, agents).astype(np.float64)
        if self.deterministic:
            return scores.argmax(axis=-1)
        keys = self._keys.of_step(transition)
        each = len(rows) // len(keys)  # of a world; as torch asks for them, agent by agent
        drawn = uniforms(keys, agents * each).reshape(len(keys), agents, each)
        drawn = drawn.transpose(0, 2, 1).reshape(len(rows), agents, 1)
        reached = np.exp(scores - scores.max(axis=-1, keepdims=True)).cumsum(axis=-1)
        chosen = (reached <= drawn * reached[..., -1:]).sum(axis=-1)
        return np.minimum(chosen, scores.shape[-1] - 1)
