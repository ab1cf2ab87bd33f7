"""Study of a walker that its drive turns while a human pushes it (V-A, Figs. 9 and 10)."""

from pathlib import Path

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.geometry.frames import wrapped
from coopenv.wrench import load_share

from ..claims import Claim
from ..figures import DISAGREEMENT_PANELS, MOTION_PANELS
from ..methods import LOOKS, largest, smallest
from .report import ZERO, Walk, write_walk
from .simulations import Recording, WalkerTurn

FIGURE = "Fig. 10"
TITLE = "walker, turning: the human pushes, the drive turns it"
FREE = ("optimal", "prioritized_torque", "point_mass")  # of internal wrench, as claimed
TOUCH = 1e-3  # [N·m] from which the drive counts as turning
ACROSS = 5.0  # [N] that the human is made to push across in the last claim

_POSE, _RESULTANT, _ALONG, _ACROSS, _TORQUE, _LOAD, _ENERGY = MOTION_PANELS
COLUMNS = (
    (_POSE, _RESULTANT, _ALONG, _ACROSS, _TORQUE),
    (_LOAD, _ENERGY, *DISAGREEMENT_PANELS),
)


def write(simulation: WalkerTurn, recording: Recording, out: Path) -> tuple[list[Claim], list[str]]:
    """Decompose, check the claims, write everything into ``out``; claims and names of files."""
    walk = Walk(recording)
    found = claims(walk)
    files = write_walk(
        walk, found, out, title=TITLE, columns=COLUMNS, outline=simulation.body.outline
    )
    return found, files


def claims(walk: Walk) -> list[Claim]:
    """What section V-A says of the turn."""
    return [*_setup(walk.recording), *_free(walk), *_others(walk), *_shares(walk), _across(walk)]


def _setup(recording: Recording) -> list[Claim]:
    error = recording.pose - recording.planned
    turn = wrapped(error[:, 2])
    off = np.linalg.norm(error[:, :2], axis=1)
    human, drive = recording.applied[:, 0], recording.applied[:, 1]
    return [
        Claim.zero("the walker follows its plan: position", "set-up", off.max(), within=0.01,
                   unit="m"),
        Claim.zero("the walker follows its plan: angle", "set-up", largest(turn), within=0.01,
                   unit="rad"),
        Claim.zero("the human gives no torque and no force across", "set-up",
                   largest(human[:, 1:]), within=0.0, unit="N, N·m"),
        Claim.zero("the drive gives no force", "set-up", largest(drive[:, :2]), within=0.0,
                   unit="N"),
        Claim(text="both have work to do: largest force of the human", source="set-up",
              measured=largest(human[:, 0]), relation=">", bound=1.0, unit="N"),
        Claim(text="both have work to do: largest torque of the drive", source="set-up",
              measured=largest(drive[:, 2]), relation=">", bound=10.0, unit="N·m"),
    ]  # fmt: skip


def _free(walk: Walk) -> list[Claim]:
    return [
        Claim.zero(f"{LOOKS[name].label}: {symbol} = 0 throughout (largest)", FIGURE,
                   largest(level), within=ZERO, unit=unit)
        for name in FREE
        for symbol, level, unit in (
            ("F_I", walk.by_method[name].internal_force_level, "N"),
            ("T_I", walk.by_method[name].internal_torque_level, "N·m"),
        )
    ]  # fmt: skip


def _others(walk: Walk) -> list[Claim]:
    """Claims that the other methods find an internal wrench whenever the drive turns the walker."""
    turning = np.abs(walk.recording.applied[:, 1, 2]) > TOUCH
    return [
        Claim(
            text=f"{LOOKS[name].label}: not free while the drive turns it (smallest of "
            f"{int(turning.sum())} samples, F_I or T_I)",
            source=FIGURE, measured=smallest(_level(walk, name), turning), relation=">",
            bound=ZERO, unit="N, N·m",
            why=f"largest: F_I {largest(split.internal_force_level):.3g} N, "
            f"T_I {largest(split.internal_torque_level):.3g} N·m",
        )
        for name, split in walk.by_method.items() if name not in FREE
    ]  # fmt: skip


def _level(walk: Walk, name: str) -> FloatArray:
    split = walk.by_method[name]
    return np.maximum(split.internal_force_level, split.internal_torque_level)


def _shares(walk: Walk) -> list[Claim]:
    rows = []
    for symbol, share, wanted in (
        ("α_f,1", walk.load.force, 1),
        ("β_lin,1", walk.energy.linear, 1),
        ("α_t,1", walk.load.torque, 0),
        ("β_rot,1", walk.energy.angular, 0),
    ):
        defined = ~np.isnan(share[:, 0])
        rows.append(
            Claim.zero(
                f"{symbol} = {wanted} wherever it is defined (largest departure)", FIGURE,
                largest(share[:, 0] - wanted, defined), within=ZERO,
                why=f"defined in {int(defined.sum())} of {len(defined)} samples",
            )
        )  # fmt: skip
    return rows


def _across(walk: Walk) -> Claim:
    """The same motion with a human who also pushes across; the wheels take the force, not it."""
    recording = walk.recording
    applied, lever = recording.applied.copy(), recording.grips[0, 0]
    force = np.copysign(ACROSS, lever * applied[:, 1, 2])  # in the turn's sense
    applied[:, 0, 1] += force
    applied[:, 1, 2] -= lever * force  # so that the torque on the walker stays what it was
    share = load_share(applied, recording.grips).torque[:, 0]
    turning = np.abs(recording.applied[:, 1, 2]) > abs(lever) * ACROSS
    return Claim(
        text=f"f_1,y = 0 is what keeps α_t,1 at 0: α_t,1 had the human pushed {ACROSS:g} N across "
        "in the turn's sense (smallest)",
        source="section V-A", measured=smallest(share, turning), relation=">", bound=0.0,
        why="the wheels give the lateral force whoever pushes, so the motion is this one",
    )  # fmt: skip
