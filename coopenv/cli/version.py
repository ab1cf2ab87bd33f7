"""``coopenv --version``: this package, and the libraries that decide what it computes."""

import platform
from importlib.metadata import PackageNotFoundError, version

LIBRARIES = (
    "numpy",
    "numba",
    "scipy",
    "clarabel",
    "pymunk",
    "gymnasium",
    "pettingzoo",
    "torch",
    "stable-baselines3",
    "sb3-contrib",
)


def versions() -> dict[str, str]:
    """Name → version, of coopenv, Python and the libraries; those that are not there say so."""
    return {
        "coopenv": _version("coopenv"),
        "python": platform.python_version(),
        **{name: _version(name) for name in LIBRARIES},
    }


def report() -> str:
    """One line each."""
    return "\n".join(f"{name} {number}" for name, number in versions().items())


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
