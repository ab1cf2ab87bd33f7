"""Claims, pictures and files of the snapshots."""

from dataclasses import dataclass
from pathlib import Path

from coopenv.arrays import whole

from ..claims import Claim, save_claims, save_rows
from . import examples, grasps, pairs
from .pictures import draw, draw_power, panels


@dataclass(frozen=True, slots=True, kw_only=True)
class SnapshotsConfig:
    """Random wrenches beside those of the figures."""

    samples: int = 4000
    """Of each claim that is checked on random wrenches."""
    seed: int = 0
    """Of their generator."""

    def __post_init__(self) -> None:
        whole(self.samples, "samples", at_least=100, at_most=1_000_000)
        whole(self.seed, "seed", at_least=0)


def claims(config: SnapshotsConfig | None = None) -> list[Claim]:
    """Every claim, in the order of the figures."""
    config = config if config is not None else SnapshotsConfig()
    drawn = (config.samples, config.seed)
    return [
        *grasps.line_claims(),
        *grasps.couple_claims(),
        *grasps.disc_claims(*drawn),
        *grasps.trio_claims(),
        *grasps.digit_claims(),
        *pairs.lens_claims(*drawn),
        *pairs.weight_claims(*drawn),
        *pairs.work_claims(*drawn),
    ]


def write(config: SnapshotsConfig, out: Path) -> tuple[list[Claim], list[str]]:
    """Check the claims, write everything into ``out``; claims and names of files."""
    found = claims(config)
    files = save_claims(found, out / "claims")
    files += save_rows(sources(), out / "sources")
    for name, shown in panels().items():
        draw(name, shown, out / f"{name}.png")
        files.append(f"{name}.png")
    draw_power(out / "fig17.png")
    return found, [*files, "fig17.png"]


def sources() -> list[dict[str, str]]:
    """Where the numbers of each figure come from, as rows of a table."""
    return [
        {"figure": each.figure, "subject": each.subject, "numbers": each.numbers}
        for each in examples.SOURCES
    ]
