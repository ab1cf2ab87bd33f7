"""Which statistics of observations go with a model: those given, or of where it learned last."""

import os
from pathlib import Path

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecNormalize

from coopenv.errors import InvalidInput

from .files import Saved
from .normalization import Normalization, Normalize, find_normalization, trained_normalized
from .record import has_learned_in_its_environment, learned_so_far


class Statistics:
    """Those that were given for a model, until it learns in another environment.

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
            return self._given if self._live is None else Normalization.of(self._live)
        venv = self._model.get_vec_normalize_env()
        if venv is not None:
            return Normalization.of(venv)
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


def saved_normalization(saved: Saved, path: str | os.PathLike) -> Normalization | bool:
    """The statistics that go with a file, or False where it needs none.

    Raises
    ------
    InvalidInput
        If it needs some that it does not hold, or does not say whether it does.
    """
    if saved.is_normalized is not None:
        return saved.normalization or False
    needed = trained_normalized(saved.model) if saved.traces else None
    if needed is False:
        return False
    beside = sorted(Path(path).parent.glob("*vec*normalize*.pkl"))
    hint = f", {str(beside[0])!r} for example," if beside else ""
    raise InvalidInput(
        f"normalize must be given for a policy that {'was' if needed else 'may have been'} "
        f"trained behind a VecNormalize, got none for {os.fspath(path)!r}; in Python, "
        "SB3Policy.load(path, normalize=..., trust=True) takes the file that VecNormalize.save "
        f"wrote{hint} or False if it left observations as they are, and .save writes a policy "
        "that the command line takes too"
    )
