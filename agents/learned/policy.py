"""A trained Stable-Baselines3 model that acts in many worlds as it acted in its training."""

import os
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from stable_baselines3.common.base_class import BaseAlgorithm
from typing_extensions import Self

from coopenv.arrays import BoolArray, IntArray
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.transition import Transition
from coopenv.transport import Transport

from ..noise import EpisodeKeys
from ..policy import Seat
from ..trained.policy import PlainPolicy
from ..trained.record import RECORD, check_trained_on
from ..trained.seat import seat_of
from ..trained.spaces import spaces_of
from .exchange import plain_form
from .files import copy_of, load_model, save_model, saved_normalization
from .finite import DIVERGED, has_diverged
from .memory import EpisodeMemory
from .normalization import Normalization, Normalize, Statistics
from .record import notes_now
from .sampling import can_be_sampled, sampled


class SB3Policy:
    """A trained Stable-Baselines3 model as a `coopenv.agents.policy.Policy`.

    Whether it moves the whole team or one agent shows in the size of its observation. Observations
    are normalised as in the training; a recurrent policy remembers each episode by itself.

    Parameters
    ----------
    model
        Any algorithm of Stable-Baselines3 or sb3-contrib that acts in a box or by numbers of
        pushes.
    deterministic
        Take the mean action instead of a sample.
    normalize
        Observation statistics: a ``VecNormalize``, as they are when the policy acts, or the file
        that its ``save`` wrote, which is a pickle and needs ``trust``. ``None``: those of the
        model's own environment, as they are when it acts. ``False``: none. They hold until the
        model learns in another environment.
    seed
        Of sampled actions, which are keyed by it, by the episode's seed and by the step.
    notes
        What else its file is to say; as JSON can hold it. Under ``provenance`` the environment of
        its training, which holds until the model learns in another.
    trust
        Whether a file of ``normalize`` may run what it holds.

    Raises
    ------
    InvalidInput
        If the model was trained on normalised observations whose statistics are not known, or its
        spaces are not those of an environment of this package.
    """

    __module__ = "coopenv.agents.sb3"  # where users import it from, and where pickles look for it

    def __init__(
        self,
        model: BaseAlgorithm,
        *,
        deterministic: bool = True,
        normalize: Normalize = None,
        seed: int = 0,
        notes: Mapping[str, Any] | None = None,
        trust: bool = False,
    ):
        self.model, self.deterministic = model, deterministic
        self.notes = dict(notes or {})
        self._spaces = spaces_of(model.observation_space, model.action_space, type(model).__name__)
        self._statistics = Statistics(model, normalize, self._spaces.features, trust=trust)
        self._seed, self._keys = seed, EpisodeKeys(seed)
        self._memory = EpisodeMemory()

    @classmethod
    def load(
        cls,
        path: str | os.PathLike,
        algorithm: type[BaseAlgorithm] | None = None,
        *,
        deterministic: bool = True,
        normalize: Normalize = None,
        seed: int = 0,
        trust: bool = False,
    ) -> Self:
        """Read a model from the file that `save` wrote, or with ``trust`` SB3 itself.

        Without ``trust`` a file runs nothing: its ``model`` is constructed anew from spaces and
        keywords that the file says in plain values, and gets weights and optimiser states. It acts
        as it did. It trains on as it would have, or says which of its settings the file does not
        hold that way.

        Parameters
        ----------
        algorithm
            That trained it. The file says which, unless it is not one of Stable-Baselines3's or
            sb3-contrib's.
        deterministic, normalize, seed
            As of `SB3Policy`; ``None``: the statistics that `save` wrote. Files that SB3 wrote
            hold none; on-policy algorithms show whether there were some, off-policy ones rarely,
            so that theirs are refused until it is given.
        trust
            Whether the file, and that of ``normalize``, may run what it holds: the pickles in
            which SB3 keeps all of a model. Needed for files that SB3 or an older coopenv wrote, and
            for policy classes, feature extractors and spaces of your own.

        Raises
        ------
        InvalidInput
            If the file is no policy, is broken, needs ``trust``, or the model cannot act as it was
            trained.
        MissingExtra
            If sb3-contrib trained it and is not installed.
        """
        saved = load_model(path, algorithm, trust=trust)
        if normalize is None:
            normalize = saved_normalization(saved, path)
        try:
            return cls(
                saved.model,
                deterministic=deterministic,
                normalize=normalize,
                seed=seed,
                notes=saved.notes,
                trust=trust,
            )
        except InvalidInput as error:
            raise InvalidInput(f"{error} (policy {os.fspath(path)!r})") from error

    def save(self, path: str | os.PathLike) -> None:
        """Write model, normalisation and notes to one file, whole or not at all.

        The environment is that in which the model learned last, if it is one of
        `coopenv.agents.sb3`; the notes' own record stays where it is of the same one. An
        environment that is not known or cannot be written costs no trained policy: it is warned of
        and left out. ``PPO.load`` and its like read the file as well, without the normalisation.
        """
        notes, missing = notes_now(
            self.model, self.notes, learned_on=self._statistics.has_learned_on
        )
        if missing:
            warnings.warn(
                f"the policy's file does not say which environment it was trained in: {missing}; "
                "without it coopenv evaluate needs --env",
                stacklevel=2,
            )
        save_model(self.model, path, notes=notes, normalization=self.normalization)

    def plain(self) -> PlainPolicy:
        """The policy as it is now in plain numbers, which acts without torch.

        Its ``save`` writes a file that holds no pickles; `load` reads that as well, with an
        optimiser that is new.

        Raises
        ------
        InvalidInput
            If it acts by something else than dense layers: by a memory, for example.
        """
        form = plain_form(self.model, self._notes_now(), self.normalization)
        return PlainPolicy(form, deterministic=self.deterministic, seed=self._seed)

    @property
    def normalization(self) -> Normalization | None:
        """Statistics of the observations it was trained on; ``None`` without normalisation.

        Those that were given or read, until the model learns in another environment.

        Raises
        ------
        InvalidInput
            If there were some, and they are not known.
        """
        return self._statistics.now()

    def sampled(self) -> Self | None:
        """The same policy with sampled actions; ``None`` for algorithms that have no spread."""
        if not self.deterministic:
            return self
        if not can_be_sampled(self.model):
            return None
        return type(self)(
            self.model,
            deterministic=False,
            normalize=self._statistics.as_given,
            seed=self._seed,
            notes=self._notes_now(),
        )

    def frozen(self) -> Self:
        """A copy that learns no more, with a memory of its own; it acts as this one does now."""
        return type(self)(
            copy_of(self.model),
            deterministic=self.deterministic,
            normalize=self.normalization or False,
            seed=self._seed,
            notes=notes_now(
                self.model, self.notes, learned_on=self._statistics.has_learned_on
            ).entries,
        )

    def as_partner(
        self, config: TransportConfig, agents: tuple[int, ...], *, trust: bool = False
    ) -> Seat:
        """Its seat among the ``agents`` that a partner drives: it sees what it was trained on.

        Parameters
        ----------
        config
            Of the environment.
        agents
            That it is to drive.
        trust
            Whether code of somebody's own that its record names may be imported, for a block.

        Raises
        ------
        InvalidInput
            If it cannot see that there, or was trained for other actions or another team.
        """
        return seat_of(self, self._spaces, self._notes_now(), config, agents, trust)

    def _notes_now(self) -> Mapping[str, Any]:
        """The notes, their record that of the environment in which the model learned last."""
        if RECORD not in self.notes:
            return self.notes
        return notes_now(self.model, self.notes, learned_on=self._statistics.has_learned_on).entries

    def check_environment(self, core: Transport) -> None:
        """Raise `InvalidInput` if ``core`` is not what it was trained on, as far as that shows."""
        agents = self._spaces.check_environment(core)
        check_trained_on(self._notes_now(), core, agents)

    def reset(self, mask: BoolArray) -> None:
        """Forget the episodes of the worlds that ``mask`` ``(world,)`` marks."""
        self._memory.forget(mask)

    def seed_episodes(self, seeds: IntArray, worlds: IntArray | None = None) -> None:
        """Seeds ``(world,)`` of the episodes that begin now, in every world or in ``worlds``."""
        self._keys.seed(seeds, worlds)

    def get_state(self, worlds: IntArray, num_worlds: int) -> dict[str, Any]:
        """Memory and random numbers of ``worlds``; see `coopenv.agents.policy.Stateful`."""
        keys = self._keys.get_state(worlds, num_worlds)
        return {"keys": keys, **self._memory.get_state(worlds, num_worlds)}

    def set_state(self, state: dict[str, Any], worlds: IntArray, num_worlds: int) -> None:
        """Go on in ``worlds`` from what `get_state` returned."""
        self._keys.set_state(state["keys"], worlds, num_worlds)
        self._memory.set_state(state, worlds, num_worlds)

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)``, or numbers of pushes ``(world, learner)``.

        Raises
        ------
        InvalidInput
            If it was trained on other observations, other actions or a team of another size, or its
            training diverged.
        """
        width = transition.action.shape[-1]
        rows = self._spaces.rows(obs, width)
        normalization = self.normalization
        if normalization is not None:
            rows = normalization(rows)
        self.reset(transition.next_state.time == 0)
        memory, starts = self._memory.recall(len(rows))

        def predict() -> tuple[npt.NDArray, Any]:
            return self.model.predict(rows, memory, starts, self.deterministic)

        try:
            if self.deterministic:
                action, kept = predict()
            else:
                action, kept = sampled(self.model, predict, self._keys, transition, len(rows))
        except ValueError as error:
            if not has_diverged(self.model, error):
                raise
            raise InvalidInput(DIVERGED) from error
        if not np.isfinite(action).all():
            raise InvalidInput(DIVERGED)
        self._memory.keep(kept)
        return self._spaces.by_agent(action, obs, width)
