"""Training with PPO: logs, curves, and checkpoints that an interrupted run goes on from."""

import warnings
from collections.abc import Callable
from fractions import Fraction
from math import ceil
from typing import TypeAlias

from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import locked, sweep, writing

from . import curves
from .curves import Row
from .environment import EnvironmentChoice
from .environment.teams import team_configs
from .learned.finite import has_diverged, require_finite
from .provenance import Provenance
from .sb3 import SB3Policy, TeamsVecEnv, TransportVecEnv
from .seeds import BLOCK, training_seeds
from .settings import TrainConfig
from .training.checkpoint import CHECKPOINT, POLICY, Checkpoint, Keeper, save
from .training.events import told_once
from .training.folder import LOG, SETTINGS, clear, require_room
from .training.hyperparameters import feature_scale, ppo_settings
from .training.progress import Progress, Watch
from .training.target import Reached, Target
from .training.threads import torch_threads

try:
    from stable_baselines3 import PPO
    from stable_baselines3.common.base_class import BaseAlgorithm
except ImportError as error:
    raise MissingExtra("coopenv.agents.train", "train") from error

Venv: TypeAlias = TransportVecEnv | TeamsVecEnv
UPDATES = "_n_updates"  # attribute of a model, for its log: gradient epochs that were done
__all__ = ["EnvironmentChoice", "TrainConfig", "ppo_settings", "train"]


def train(
    config: TrainConfig,
    *,
    environment: TransportConfig | None = None,
    report: Callable[[Row], None] | None = None,
    tell: Callable[[str], None] = print,
) -> SB3Policy:
    """Train a policy and leave it in ``config.out``.

    Written there: ``policy.zip`` (`SB3Policy.load`, or ``PPO.load``) and ``config.json``, both with
    all of the environment, versions and the command (`coopenv.agents.provenance`), ``curves.csv``,
    ``curves.png``, ``tensorboard/``, and while it runs ``checkpoint.zip``, with which the next call
    of the same configuration goes on. So does an interruption (Ctrl-C), after the last update that
    was done. Episodes that ran when it was killed begin anew, so a run that was killed does not
    give the same bits as one that was not. The folder is locked meanwhile, and left-overs of
    writers that were killed are removed from it.

    With ``config.until`` it ends as soon as so many held-out episodes succeed, and ``tell`` says
    where that was, or that it never was.

    A run that is finished is not trained again: its policy is returned. With more ``steps`` it goes
    on from its end, at the learning rate that a run of so many steps has there. ``config.fresh``
    removes the run that the folder holds and starts over. Files of those names that no run wrote
    are neither removed nor written over.

    Parameters
    ----------
    config
        Of the run.
    environment
        Instead of the one that ``config.environment`` names; with ``config.teams`` its body is held
        by each of them in turn (`coopenv.agents.environment.with_team`).
    report
        Called with the newest row of the curves after every rollout.
    tell
        Called with a sentence if the run goes on or had ended.

    Raises
    ------
    InvalidInput
        If ``config.out`` holds another run, this one with more steps done, or files of a run's
        names but no run; if another process is at work in it; or if the environment cannot be
        written into it.
        Also if it diverges, with the last update that did not in the checkpoint.
    FileTrouble
        If the system does not let something be written, as on a full disk; the last checkpoint
        stays.
    KeyboardInterrupt
        If it is interrupted; the message says where the next call will go on.
    """
    with torch_threads(config.threads), locked(config.out), writing(config.out):
        sweep(config.out)
        return _train(config, environment or config.environment.config(), report, tell)


def _train(
    config: TrainConfig,
    environment: TransportConfig,
    report: Callable[[Row], None] | None,
    tell: Callable[[str], None],
) -> SB3Policy:
    venv = _venv(config, environment)
    provenance = Provenance.of(config, venv.transport.config)
    require_room(config.out, fresh=config.fresh)
    found = None if config.fresh else _furthest(config, provenance)
    if found is None:
        model, progress = _begin(config, venv), Progress()
        if config.fresh:
            clear(config.out)
    else:
        tell(_what_was_found(found, config))
        _warn_of_versions(found)
        model, progress = _resume(found, config, venv), found.progress
    if found is None or not _is_finished(found, config):
        config.save(config.out / SETTINGS, notes=provenance.to_notes())
        _learn(model, config, provenance, progress, report, tell)
    else:
        provenance = found.provenance
    curves.save_rows(progress.rows, config.out / "curves.csv")
    curves.draw({"": [progress.rows]}, config.out / "curves.png")
    (config.out / CHECKPOINT).unlink(missing_ok=True)
    venv.close()
    return SB3Policy(model, notes=provenance.to_notes())


def _learn(
    model: PPO,
    config: TrainConfig,
    provenance: Provenance,
    progress: Progress,
    report: Callable[[Row], None] | None,
    tell: Callable[[str], None],
) -> None:
    """Train up to ``config.steps`` or ``config.until`` and save, if interrupted a checkpoint."""
    venv = model.get_env()
    assert isinstance(venv, TransportVecEnv | TeamsVecEnv)
    per_step = _per_step(config, venv)
    keeper = Keeper(config.out, provenance, progress, every=config.checkpoint_every)
    configs = team_configs(venv.transport.config, config.teams)
    target = None if config.until is None else Target(config.until, *configs)

    def begin(model: BaseAlgorithm) -> None:
        keeper.begin_rollout(model)
        if target is not None:
            target.check(model, progress)

    watch = Watch(
        progress,
        horizon=venv.transport.config.horizon,
        rollout=config.rollout,
        per_step=per_step,
        begin=begin,
        report=report if report is not None else lambda row: None,
    )
    try:
        reached = _run(model, watch, int(config.steps * per_step), target)
        require_finite(model, "of the policy")
        save(config.out / POLICY, model, provenance, progress)
        if config.until is not None:
            tell(reached or _not_reached(config))
    except ValueError as error:
        if not has_diverged(model, error):
            raise
        raise _diverged(keeper.write_kept(model), config) from error
    except KeyboardInterrupt as stop:
        raise KeyboardInterrupt(_interrupted(keeper.write_kept(model), config)) from stop


def _run(model: PPO, watch: Watch, rows: int, target: Target | None) -> str:
    """Learn up to ``rows``, or to the target; what `Reached` says where it is reached."""
    try:
        with told_once():
            model.learn(
                max(0, rows - model.num_timesteps),
                callback=watch,
                reset_num_timesteps=model.num_timesteps == 0,
                tb_log_name=LOG,
            )
        if target is not None:
            target.check(model, watch.progress)
    except Reached as reached:
        return str(reached)
    return ""


def _furthest(config: TrainConfig, provenance: Provenance) -> Checkpoint | None:
    """The furthest that the folder holds of this run, if anything.

    Raises `InvalidInput` if what it holds is of another run, or beyond the end of this one.
    """
    paths = [path for name in (POLICY, CHECKPOINT) if (path := config.out / name).exists()]
    found = [Checkpoint.read(path) for path in paths]
    for checkpoint in found:
        checkpoint.check(provenance)
    furthest = max(found, key=lambda checkpoint: checkpoint.progress.steps, default=None)
    if furthest is not None and furthest.progress.steps > _end(config):
        raise InvalidInput(
            f"steps must be at least the {furthest.progress.steps:,} that {furthest.path} has "
            f"done, got {config.steps:,}; give more, choose another out, or start over with "
            "fresh=True (--fresh)"
        )
    return furthest


def _end(config: TrainConfig) -> int:
    """Control steps of the whole run: whole rollouts of all worlds."""
    rollout = config.rollout * config.num_worlds
    return ceil(config.steps / rollout) * rollout


def _is_finished(found: Checkpoint, config: TrainConfig) -> bool:
    return found.path.name == POLICY and found.progress.steps >= config.steps


def _what_was_found(found: Checkpoint, config: TrainConfig) -> str:
    done = f"{found.progress.steps:,}"
    if _is_finished(found, config):
        return (
            f"{found.path} has done its {done} steps and is taken as it is; more steps go on from "
            "there, fresh=True (--fresh) starts over"
        )
    return f"going on from {found.path} at {done} of {config.steps:,} steps"


def _warn_of_versions(found: Checkpoint) -> None:
    others = found.provenance.other_versions()
    if others:
        warnings.warn(
            f"{found.path} was written with {', '.join(others)}; what follows may differ from what "
            "these would have given",
            stacklevel=4,
        )


def _not_reached(config: TrainConfig) -> str:
    return (
        f"{config.steps:,} steps are done and until={config.until:g} is not reached; more steps go "
        "on from there"
    )


def _interrupted(done: int, config: TrainConfig) -> str:
    if not done:
        return "interrupted before the first update; the same command begins anew"
    again = "the same command again" + " without --fresh" * config.fresh
    return (
        f"interrupted; {config.out / CHECKPOINT} holds {done:,} of {config.steps:,} steps, give "
        f"{again} to go on there"
    )


def _diverged(done: int, config: TrainConfig) -> InvalidInput:
    kept = f"; {config.out / CHECKPOINT} holds the {done:,} steps before" if done else ""
    return InvalidInput(
        f"weights of the policy must stay finite, got nan or inf after {done:,} of "
        f"{config.steps:,} steps: the training diverged; lower learning_rate (it is "
        f"{config.learning_rate:g}), clip_range, entropy_weight or initial_std, and choose another "
        f"out or start over with fresh=True (--fresh){kept}"
    )


def _venv(config: TrainConfig, environment: TransportConfig) -> Venv:
    """The worlds of the run: of one team, or of several sizes."""
    if config.teams:
        return TeamsVecEnv(environment, config.num_worlds, config.teams)
    return TransportVecEnv(environment, config.num_worlds, control=config.control)


def _per_step(config: TrainConfig, venv: Venv) -> Fraction:
    """Rows of the ``VecEnv`` a control step of a world, in the mean over worlds."""
    return Fraction(venv.num_envs, config.num_worlds)


def _begin(config: TrainConfig, venv: Venv) -> PPO:
    settings = ppo_settings(config, rows=venv.num_envs, scale=feature_scale(venv))
    model = PPO("MlpPolicy", venv, tensorboard_log=str(config.out / "tensorboard"), **settings)
    _seed_worlds(config, venv, steps=0)  # after PPO, which seeds them as well
    return model


def _resume(found: Checkpoint, config: TrainConfig, venv: Venv) -> PPO:
    """The model as it was at the checkpoint, with random numbers of its own."""
    model = _begin(config, venv)
    found.restore(model, rows=_per_step(config, venv))
    updates = ceil(found.progress.steps / (config.rollout * config.num_worlds))
    setattr(model, UPDATES, updates * config.epochs)
    model.set_random_seed(config.seed + model.num_timesteps)
    _seed_worlds(config, venv, steps=model.num_timesteps)
    return model


def _seed_worlds(config: TrainConfig, venv: Venv, *, steps: int) -> None:
    """World seeds of this run's block; a resumed run takes others than it began with."""
    first = training_seeds(config.seed, config.num_worlds)[0]
    venv.seed(first + steps % (BLOCK - config.num_worlds))
