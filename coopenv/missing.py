"""What is said where the packages that simulate and present environments are not installed.

Decomposition, recordings, bodies, tasks and rewards need none of them, so that they can be used
where only numerical packages are, as beside ROS 2 or in a web service.
"""

import re
from collections.abc import Callable, Collection
from importlib.metadata import requires
from typing import Any

from coopenv.errors import MissingPackage

PACKAGES = ("gymnasium", "pettingzoo", "pymunk")


def told(error: ModuleNotFoundError, feature: str) -> ImportError:
    """What to raise for ``feature``, which an import that failed stands in the way of.

    Returns
    -------
    A `MissingPackage` that names all of `PACKAGES` as ``pip install`` takes them; ``error`` itself
    where it is another module that is missing.
    """
    package = (error.name or "").partition(".")[0]
    if package not in PACKAGES:
        return error
    wanted = [one for one in requires("coopenv") or PACKAGES if _name(one) in PACKAGES]
    return MissingPackage(feature, package, wanted)


def refusal(
    error: ModuleNotFoundError, module: str, names: Collection[str]
) -> Callable[[str], Any]:
    """A module's ``__getattr__`` that raises `MissingPackage` for ``names``.

    Raises
    ------
    ModuleNotFoundError
        At once, if ``error`` is of another module than those of `PACKAGES`.
    """
    if not isinstance(told(error, module), MissingPackage):
        raise error

    def refuse(name: str) -> Any:
        if name in names:
            raise told(error, f"{module}.{name}") from error
        raise AttributeError(f"module {module!r} has no attribute {name!r}")

    return refuse


def _name(requirement: str) -> str:
    return re.split(r"[^\w.-]", requirement, maxsplit=1)[0].lower()
