"""TorchRL: worlds as one batched ``EnvBase``, agents as a group; BenchMARL takes it as a task."""

from .env import TransportTorchEnv, make_env

__all__ = ["TransportTorchEnv", "make_env"]
