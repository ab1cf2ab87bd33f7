"""The exceptions coopenv raises; each is also the builtin one would catch."""

from collections.abc import Iterable, Mapping
from difflib import SequenceMatcher

NEAR = 0.7  # of difflib's ratio: one slip in four letters

# Words that others have for a thing -> what it is called here; several where it is called otherwise
# in other places. All are names that a keyword, a field or an option may have.
SYNONYMS: Mapping[str, tuple[str, ...]] = {
    "batch": ("batch_size",),
    "bodies": ("body",),
    "delta_t": ("dt",),
    "damping": ("linear_drag",),
    "drag": ("linear_drag",),
    "ent_coef": ("entropy_weight",),
    "entropy_coefficient": ("entropy_weight",),
    "env_id": ("env",),
    "environment": ("env",),
    "episode_length": ("horizon",),
    "eval_episodes": ("episodes",),
    "frame_skip": ("substeps",),
    "frameskip": ("substeps",),
    "gamma": ("discount", "relative_cost"),
    "gae": ("gae_lambda",),
    "id": ("env",),
    "lam": ("gae_lambda",),
    "lr": ("learning_rate",),
    "max_force": ("force_limit",),
    "max_steps": ("horizon",),
    "max_episode_length": ("horizon",),
    "max_timesteps": ("horizon",),
    "max_torque": ("torque_limit",),
    "moment_of_inertia": ("inertia",),
    "n_agents": ("num_agents",),
    "n_envs": ("num_envs", "num_worlds"),
    "n_epochs": ("epochs",),
    "n_steps": ("rollout",),
    "n_worlds": ("num_worlds",),
    "net_arch": ("hidden",),
    "num_envs": ("num_worlds",),
    "num_timesteps": ("steps",),
    "num_worlds": ("num_envs",),
    "obs": ("observe",),
    "observation": ("observe",),
    "observations": ("observe",),
    "output": ("out",),
    "reward_fn": ("reward",),
    "reward_function": ("reward",),
    "rewards": ("reward",),
    "time_limit": ("horizon",),
    "time_step": ("dt",),
    "timestep": ("dt",),
    "timesteps": ("steps",),
    "total_timesteps": ("steps",),
    "walls": ("obstacles",),
    "weights": ("reward",),
}


class CoopenvError(Exception):
    """Base of all exceptions of this package."""


class InvalidInput(CoopenvError, ValueError):
    """An argument breaks its rule; the message names it, the rule and the remedy."""


class FileTrouble(InvalidInput, OSError):
    """A file that the system does not let be read or written."""


class UnknownName(CoopenvError, ValueError):
    """A method, block, preset or keyword that does not exist; the message says what may be meant.

    Parameters
    ----------
    what
        Of which kind of name.
    name
        The one that is not known.
    known
        Those that are.
    elsewhere
        Names that belong somewhere else, and where: a remedy in words.
    """

    def __init__(
        self,
        what: str,
        name: object,
        known: Iterable[str],
        elsewhere: Mapping[str, str] | None = None,
    ):
        names = sorted(known)
        remedy = (elsewhere or {}).get(str(name))
        meant = None if remedy else likely(str(name), names)
        hint = f"{remedy}; " if remedy else f"did you mean {meant!r}? " if meant else ""
        super().__init__(
            f"{what} must be one of the known names, got {name!r}; {hint}known: {', '.join(names)}"
        )


def likely(name: str, known: Iterable[str]) -> str | None:
    """The known name that a wrong one stands for: by its meaning, else by its letters, if near.

    A name that begins with the wrong one, with which the wrong one begins, or of which it is one
    of the words counts as near.

    >>> likely("lr", ["lambda", "learning_rate"])
    'learning_rate'
    >>> likely("seed", ["scene", "task"])
    """
    names = list(known)
    plain = name.lower().replace("-", "_")
    for meant in SYNONYMS.get(plain, ()):
        if meant in names:
            return meant
    ratings = [(_nearness(plain, each.lower()), each) for each in names]
    rating, nearest = max(ratings, key=lambda rated: rated[0], default=(0.0, None))
    return nearest if rating >= NEAR else None


def _nearness(name: str, known: str) -> float:
    """From 0 to 1; a beginning of at least four letters or a whole word is near."""
    ratio = SequenceMatcher(None, name, known).ratio()
    short, long = sorted((name, known), key=len)
    if (len(short) >= 4 and long.startswith(short)) or name in known.split("_"):
        return NEAR + (1 - NEAR) * ratio
    return ratio if name[:1] == known[:1] else 0.9 * ratio  # few mistake the first letter


class SolverError(CoopenvError, RuntimeError):
    """A solver stopped without an answer it can vouch for.

    None does so any more: every answer comes with a ``gap`` that owns up. The class is kept for
    callers who catch it.
    """


class ResetNeeded(CoopenvError, RuntimeError):
    """A world was stepped before its first reset, after its episode ended or a call broke off."""


class CoreInUse(CoopenvError, RuntimeError):
    """A core was stepped or reset by two threads at the same time."""


class BodyLost(CoopenvError, RuntimeError):
    """A body went through a wall: it moves too far in a substep.

    Attributes
    ----------
    world
        Number of its world in the batch, the last one found if there are several; ``None`` where
        who raised it did not say.
    """

    def __init__(self, message: str, world: int | None = None):
        super().__init__(message)
        self.world = world


class MissingPackage(CoopenvError, ImportError):
    """A package is needed that coopenv was installed without; the message says what to install."""

    def __init__(self, feature: str, package: str, requirements: Iterable[str]):
        wanted = " ".join(f"'{one}'" for one in requirements)
        super().__init__(f"{feature} needs {package}, which is not installed; pip install {wanted}")


class MissingExtra(CoopenvError, ImportError):
    """An optional dependency is needed; the message says what to install."""

    def __init__(self, feature: str, extra: str):
        super().__init__(f"{feature} needs an optional package; pip install 'coopenv[{extra}]'")
