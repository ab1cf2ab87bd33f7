"""TorchRL: worlds as one batched ``EnvBase``, agents as a group; BenchMARL takes it as a task."""

from .env import TransportTorchEnv, feature_scale, make_env

__all__ = ["TransportTorchEnv", "feature_scale", "make_env"]
