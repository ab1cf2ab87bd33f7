"""Training by a recipe, in one piece: logs, curves and a policy, but no checkpoint on the way."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback

from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.files import locked, sweep, writing

from .. import curves
from ..curves import Row
from ..differences import differences
from ..learned import SB3Policy, save_model
from ..learned.finite import has_diverged, require_finite
from ..provenance import Provenance
from ..seeds import training_seeds
from ..settings import TrainConfig
from ..training.checkpoint import POLICY
from ..training.events import told_once
from ..training.folder import LOGS, clear_logs
from ..training.progress import Progress, Watch
from ..training.threads import torch_threads
from ..vec_env import TransportVecEnv
from .models import model_of, writable
from .recipes import Recipe, name_of, plain

EVERY = 32  # control steps of each world between two rows of the curves


def train_by(
    recipe: Recipe,
    training: TrainConfig,
    *,
    environment: TransportConfig | None = None,
    report: Callable[[Row], None] | None = None,
) -> SB3Policy:
    """Train a policy by a recipe and leave it in ``training.out``.

    Written there: ``policy.zip`` (`coopenv.agents.sb3.SB3Policy.load`) with all of the environment,
    the recipe, versions and the command, ``curves.csv``, ``curves.png`` and ``tensorboard/``. There
    is no checkpoint: a call after an interruption, or a kill, begins anew. A policy of the same
    training that is there is returned as it is, and one of another is not written over.

    Parameters
    ----------
    recipe
        Settings of the algorithm.
    training
        ``environment``, ``control``, ``seed``, ``out`` and ``threads`` of the run; what else it
        says is PPO's.
    environment
        Instead of the one that ``training.environment`` names.
    report
        Called with the newest row of the curves.

    Returns
    -------
    The policy.

    Raises
    ------
    InvalidInput
        If the folder holds another policy or another process is at work in it, the environment
        cannot be written into the policy's file, there are teams of several sizes, or the training
        diverges.
    MissingExtra
        If the package of the algorithm is not installed.
    FileTrouble
        If the system does not let something be written, as on a full disk.
    """
    out = training.out
    if training.teams:
        raise InvalidInput(
            f"teams must be left out for another algorithm than PPO, got {training.teams}; train "
            "one size of team"
        )
    with torch_threads(training.threads), locked(out), writing(out):
        sweep(out)
        config = environment or training.environment.config()
        venv = TransportVecEnv(config, recipe.num_worlds, control=training.control)
        said = {"algorithm": name_of(recipe), **plain(recipe)}
        try:
            provenance = Provenance.of_recipe(training, venv.transport.config, said)
            found = _finished(out / POLICY, provenance)
            return found or _train(recipe, training, venv, provenance, report)
        finally:
            venv.close()


def _train(
    recipe: Recipe,
    training: TrainConfig,
    venv: TransportVecEnv,
    provenance: Provenance,
    report: Callable[[Row], None] | None,
) -> SB3Policy:
    name, out, progress = name_of(recipe), training.out, Progress()
    clear_logs(out, name)
    model = model_of(recipe, venv, seed=training.seed, log=str(out / LOGS))
    first = training_seeds(training.seed, recipe.num_worlds)[0]
    venv.seed(first)  # after the model, which seeds them too
    rows = Fraction(venv.num_envs, recipe.num_worlds)
    watch = Watch(
        progress,
        horizon=venv.transport.config.horizon,
        rollout=EVERY,
        per_step=rows,
        begin=lambda model: require_finite(model, "of the policy"),
        report=report if report is not None else lambda row: None,
    )
    with _diverging(model, progress), told_once():
        model.learn(
            int(recipe.steps * rows),
            callback=NowAndThen(watch),
            log_interval=recipe.LOG_INTERVAL,
            tb_log_name=name,
        )
        require_finite(model, "of the policy")
    curves.save_rows(progress.rows, out / "curves.csv")
    curves.draw({"": [progress.rows]}, out / "curves.png")
    notes = provenance.to_notes()
    save_model(writable(model), out / POLICY, notes=notes)  # last: it says that all is done
    return SB3Policy(model, notes=notes)


class NowAndThen(BaseCallback):
    """Has a `Watch` take `EVERY` control steps for a rollout, whatever the algorithm takes."""

    def __init__(self, watch: Watch):
        super().__init__()
        self._watch = watch

    def update_child_locals(self, locals_: dict[str, Any]) -> None:
        """Hand on what the algorithm's loop has at the moment."""
        self._watch.update_locals(locals_)

    def _init_callback(self) -> None:
        self._watch.init_callback(self.model)

    def _on_training_start(self) -> None:
        self._watch.on_training_start(self.locals, self.globals)
        self._watch.on_rollout_start()

    def _on_step(self) -> bool:
        self._watch.on_step()
        if self.n_calls % EVERY == 0:
            self._row()
        return True

    def _on_training_end(self) -> None:
        if self.n_calls % EVERY:
            self._row()

    def _row(self) -> None:
        self._watch.on_rollout_end()
        self._watch.on_rollout_start()


def _finished(path: Path, provenance: Provenance) -> SB3Policy | None:
    """The policy that is there, if there is one; raises `InvalidInput` if it is of another run."""
    if not path.exists():
        return None
    there = Provenance.read(path)
    mine = {"training": provenance.training, "environment": provenance.environment}
    theirs = {name: getattr(there, name, {}) for name in mine}
    found = differences(theirs, mine)
    if found:
        raise InvalidInput(
            f"out must hold no other run, got {path}, which differs in {', '.join(found)}; choose "
            "another out, or move it away"
        )
    return SB3Policy.load(path)


@contextmanager
def _diverging(model: BaseAlgorithm, progress: Progress) -> Iterator[None]:
    """Say what to do where a training diverges in the block."""
    try:
        yield
    except ValueError as error:
        if not has_diverged(model, error):
            raise
        raise InvalidInput(
            f"weights of the policy must stay finite, got nan or inf after {progress.steps:,} "
            "steps: the training diverged; lower learning_rate"
        ) from error
