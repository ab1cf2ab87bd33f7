"""``coopenv export``: a trained policy in plain numbers, for whoever has NumPy."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar

from coopenv.errors import InvalidInput
from coopenv.files import reading, require_writable
from coopenv.options import POSITIONAL, Common


@dataclass(frozen=True, kw_only=True)
class Export:
    """Write a trained policy as arrays and JSON, without pickles; it then acts by NumPy alone."""

    policy: Annotated[str, POSITIONAL]
    """File of a trained policy (policy.zip), or pretrained:BeamDoorway/joint and the like."""
    out: Path | None = None
    """File to write, .npz; beside the policy's by default."""
    trust: bool = False
    """Run what the file holds: pickles of Stable-Baselines3."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv export runs/beam_transport/policy.zip --out carry.npz",
        "coopenv export pretrained:BeamDoorway/joint --out doorway.npz",
    )

    def run(self) -> dict[str, Any]:
        """Read, write, say what came of it."""
        from .. import trained
        from .catalogue import read
        from .naming import file_of

        source = file_of(self.policy)
        out = self._out(source)
        if out.suffix != trained.SUFFIX or out.absolute() == source.absolute():
            raise InvalidInput(
                f"out must be another file that ends in {trained.SUFFIX}, got {str(out)!r}; it is "
                "an archive of arrays: name one by --out"
            )
        require_writable(out)
        with reading(self.policy):
            policy = read(self.policy, trust=self.trust)
        plain = policy if isinstance(policy, trained.PlainPolicy) else policy.plain()
        plain.save(out)
        numbers = sum(array.size for array in plain.form.arrays.values())
        size = out.stat().st_size
        print(f"wrote {out}: {numbers:,} numbers, {size:,} bytes; nothing in it is code")
        return {"written": out, "numbers": numbers, "bytes": size}

    def _out(self, source: Path) -> Path:
        from .naming import is_name

        if self.out is not None:
            return self.out
        return Path(source.name) if is_name(self.policy) else source.with_suffix(".npz")
