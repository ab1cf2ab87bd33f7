"""Ray's nodes: https://docs.ray.io."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from coopenv.compiled.parallel import cores
from coopenv.errors import InvalidInput, MissingExtra

from .spread import NodeLost, Nodes, Told
from .work import work_on

LOCAL = "local"  # address of a Ray that begins and ends with the command
ADDRESS = "RAY_ADDRESS"  # what Ray itself takes as the address of a cluster


@dataclass(frozen=True, slots=True, eq=False)
class RayStream:
    """What a task tells."""

    ray: Any
    told: Any
    """Generator of references."""

    def __iter__(self) -> Iterator[Told]:
        """Each thing told, once."""
        wrong = self.ray.exceptions
        try:
            for reference in self.told:
                yield self.ray.get(reference)
        except wrong.RayTaskError as error:  # our own code raised, or it was cancelled
            if isinstance(error.cause, wrong.TaskCancelledError):
                raise NodeLost("cancelled") from error
            said = f"{type(error.cause).__name__}: {error.cause}"
            yield {"failed": said.strip().splitlines()[0]}
        except wrong.RayError as error:
            raise NodeLost(f"{type(error).__name__}: {_first_line(error)}") from error

    def cancel(self) -> None:
        """Interrupt the task."""
        self.ray.cancel(self.told)


@dataclass(frozen=True, slots=True)
class RayNodes:
    """Those of the cluster that this process has joined; a cell takes one core."""

    ray: Any

    def begin(self, parcel: bytes) -> RayStream:
        """Have Ray run the cell as soon as it has a core; what is lost we begin anew ourselves."""
        task = self.ray.remote(num_cpus=1, max_retries=0)(work_on)
        return RayStream(self.ray, task.remote(parcel))

    def __str__(self) -> str:
        alive = [node for node in self.ray.nodes() if node["Alive"]]
        free = self.ray.cluster_resources().get("CPU", 0)
        return f"Ray: {len(alive)} nodes, {free:g} cores"


@contextmanager
def joined(address: str | None = None) -> Iterator[Nodes]:
    """The nodes of a Ray cluster, left again after the block; or of the one that is joined already.

    Parameters
    ----------
    address
        Of the cluster: ``HOST:6379``, ``ray://HOST:10001``, or ``auto`` for that of this machine.
        ``None``: what the variable ``RAY_ADDRESS`` says, or a Ray of this machine's cores that ends
        with the block.

    Raises
    ------
    InvalidInput
        If there is no such cluster.
    MissingExtra
        If Ray is not installed.
    """
    with _same_signals():
        ray = require_ray()
        was_joined = ray.is_initialized()
        if not was_joined:
            _join(ray, address or os.environ.get(ADDRESS) or LOCAL)
    try:
        yield RayNodes(ray)
    finally:
        if not was_joined:
            ray.shutdown()


def _join(ray: Any, address: str) -> None:
    given = {"num_cpus": cores(), "include_dashboard": False} if address == LOCAL else {}
    try:
        ray.init(address=address, log_to_driver=False, logging_level="ERROR", **given)
    except (ConnectionError, RuntimeError, ValueError) as error:
        raise InvalidInput(
            f"address must be that of a Ray cluster that runs, got {address!r} "
            f"({_first_line(error)}); ray start --head starts one"
        ) from error


def require_ray() -> Any:
    """Ray; raises `MissingExtra` unless it is installed."""
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")  # a warning otherwise
    try:
        import ray  # pyright: ignore[reportMissingImports]
        import ray.exceptions  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise MissingExtra("spreading over Ray's nodes", "ray") from error
    return ray


@contextmanager
def _same_signals() -> Iterator[None]:
    """Put SIGTERM's handler back, for which Ray has one of its own as it is imported."""
    before = signal.getsignal(signal.SIGTERM)
    try:
        yield
    finally:
        if threading.current_thread() is threading.main_thread() and before is not None:
            signal.signal(signal.SIGTERM, before)


def _first_line(error: Exception) -> str:
    return (str(error).strip().splitlines() or [""])[0]
