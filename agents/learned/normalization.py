"""Normalisation of observations: statistics of a ``VecNormalize`` that a policy needs to act."""

import os
import pickle
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.running_mean_std import RunningMeanStd
from stable_baselines3.common.vec_env import VecNormalize

from coopenv.errors import InvalidInput

from ..trained.normalization import Normalization
from .record import has_learned_in_its_environment, learned_so_far

Normalize = bool | str | os.PathLike | VecNormalize | Normalization | None


def statistics_of(venv: VecNormalize) -> Normalization | None:
    """Those of observations, as they are now; ``None`` if only rewards are normalised."""
    if not venv.norm_obs:
        return None
    rms = venv.obs_rms
    if not isinstance(rms, RunningMeanStd):
        raise InvalidInput(
            "VecNormalize must be of observations in one array, got a dict; use TransportVecEnv"
        )
    return Normalization(
        mean=np.asarray(rms.mean, dtype=np.float64),
        variance=np.asarray(rms.var, dtype=np.float64),
        epsilon=float(venv.epsilon),
        clip=float(venv.clip_obs),
    )


def find_normalization(
    normalize: Normalize, size: int, *, trust: bool = False
) -> Normalization | None:
    """The statistics that a user gives for observations of ``size`` features.

    Parameters
    ----------
    normalize
        A ``VecNormalize``, or the file that its ``save`` wrote; ``False`` for none.
    trust
        Whether such a file, which is a pickle, may run what it holds.

    Raises
    ------
    InvalidInput
        If it is something else, or of another number of features.
    """
    if normalize is False:
        return None
    found = normalize
    if isinstance(normalize, str | os.PathLike):
        if not trust:
            raise InvalidInput(
                "normalize must be a VecNormalize unless you trust its file, got "
                f"{os.fspath(normalize)!r}, a pickle, which runs whatever it holds; if you know "
                "where it is from, pass trust=True"
            )
        found = _read(Path(normalize))
    if isinstance(found, VecNormalize):
        found = statistics_of(found)
        if found is None:
            return None
    if not isinstance(found, Normalization):
        raise InvalidInput(
            f"normalize must be a VecNormalize, the file that its save wrote, or False, got "
            f"{normalize!r}; give the one the policy was trained with"
        )
    if found.mean.shape != (size,):
        raise InvalidInput(
            f"normalize must have the {size} features that the policy takes, got "
            f"{found.mean.shape[-1] if found.mean.ndim else 1}; give the VecNormalize the policy "
            "was trained with"
        )
    return found


class Statistics:
    """Statistics that were given for a model, until it learns in another environment.

    Parameters
    ----------
    model
        Whose observations they are of.
    normalize, trust
        As of `coopenv.agents.sb3.SB3Policy`.
    size
        Features of an observation.
    """

    def __init__(
        self, model: BaseAlgorithm, normalize: Normalize, size: int, *, trust: bool = False
    ):
        self._model = model
        self._is_given, self._given_in = normalize is not None, model.get_env()
        self._given = find_normalization(normalize, size, trust=trust) if self._is_given else None
        self._live = normalize if isinstance(normalize, VecNormalize) else None
        self._begun = learned_so_far(model)
        self.now()  # raises here rather than in a step

    @property
    def has_learned_on(self) -> bool:
        """Whether the model has learned since it was given or read."""
        return learned_so_far(self._model) != self._begun

    @property
    def as_given(self) -> Normalize:
        """As it was given; ``None`` where nothing was, or where it holds no more."""
        return (self._live or self._given or False) if self._holds_given else None

    def now(self) -> Normalization | None:
        """Of the observations that the model was trained on; ``None`` without normalisation.

        Raises
        ------
        InvalidInput
            If there were some, and they are not known.
        """
        if self._holds_given:
            return self._given if self._live is None else statistics_of(self._live)
        venv = self._model.get_vec_normalize_env()
        if venv is not None:
            return statistics_of(venv)
        if not has_learned_in_its_environment(self._model) and trained_normalized(self._model):
            raise InvalidInput(
                "normalize must be given for a model that was trained behind a VecNormalize, got "
                "none; give normalize= that VecNormalize or the file that its save wrote, or False "
                "if it left observations as they are"
            )
        return None

    @property
    def _holds_given(self) -> bool:
        """Whether the statistics that were given are still those of the model's training."""
        there = self._model.get_env() is self._given_in
        same = there and has_learned_in_its_environment(self._model)
        return self._is_given and (same or not self.has_learned_on)


def trained_normalized(model: BaseAlgorithm) -> bool | None:
    """Whether a ``VecNormalize`` stood before the model in its training; ``None``: nobody knows.

    SB3 keeps no statistics, but the last observation from before normalisation: on-policy
    algorithms only if there was a normalisation. Off-policy ones keep one in any case; what they
    saw last may be outside the observation space (load shares and ranges are bounded), as only
    normalised numbers can be.
    """
    if getattr(model, "_last_original_obs", None) is None:
        return False
    if not isinstance(model, OffPolicyAlgorithm):
        return True
    if _outside(getattr(model, "_last_obs", None), model.observation_space):
        return True
    return None if model.get_env() is None else False


def _outside(seen: Any, space: gymnasium.Space) -> bool:
    if not isinstance(seen, np.ndarray) or not isinstance(space, gymnasium.spaces.Box):
        return False
    return bool(((seen < space.low) | (seen > space.high)).any())


def _read(path: Path) -> VecNormalize:
    try:
        with path.open("rb") as file:
            found = pickle.load(file)
    except Exception as error:  # a pickle that is broken can raise anything
        raise InvalidInput(
            f"normalize must be a file that VecNormalize.save wrote, got {os.fspath(path)!r} "
            f"({error}); give the one that was saved with the policy"
        ) from error
    if not isinstance(found, VecNormalize):
        raise InvalidInput(
            f"normalize must be a file that VecNormalize.save wrote, got {os.fspath(path)!r} which "
            f"holds a {type(found).__name__}; give the one that was saved with the policy"
        )
    return found
