"""``coopenv export``: a trained policy in plain numbers, for whoever has NumPy."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from coopenv.errors import InvalidInput
from coopenv.files import reading, require_writable

try:
    import tyro
except ImportError:  # asked for where the command line is read
    POSITIONAL: Any = None
else:
    POSITIONAL = tyro.conf.Positional


@dataclass(frozen=True, kw_only=True)
class Export:
    """Write a trained policy as arrays and JSON, without pickles; it then acts by NumPy alone.

    coopenv export runs/beam_transport/policy.zip --out carry.npz
    coopenv evaluate carry.npz
    """

    policy: Annotated[str, POSITIONAL]
    """File of a trained policy (policy.zip), or pretrained:BeamDoorway/joint and the like."""
    out: Path
    """File to write, .npz."""
    trust: bool = False
    """Run what the file holds: pickles of Stable-Baselines3."""

    def run(self) -> None:
        """Read, write, say what came of it."""
        from .. import trained
        from .catalogue import read

        if self.out.suffix != trained.SUFFIX:
            raise InvalidInput(
                f"out must end in {trained.SUFFIX}, got {str(self.out)!r}; it is an archive of "
                "arrays: rename it"
            )
        require_writable(self.out)
        with reading(self.policy):
            policy = read(self.policy, trust=self.trust)
        plain = policy if isinstance(policy, trained.PlainPolicy) else policy.plain()
        plain.save(self.out)
        numbers = sum(array.size for array in plain.form.arrays.values())
        size = self.out.stat().st_size
        print(f"wrote {self.out}: {numbers:,} numbers, {size:,} bytes; nothing in it is code")
