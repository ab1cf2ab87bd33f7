"""Study of a walker that its drive holds off an obstacle in the human's way (V-A, Fig. 11)."""

from pathlib import Path

import numpy as np

from coopenv.arrays import IntArray
from coopenv.physics.scene import Box

from ..claims import Claim
from ..figures import DISAGREEMENT_PANELS, MOTION_PANELS, Curve, Panel, Trial, curve, first, second
from ..methods import LOOKS, largest, smallest
from .report import ZERO, Walk, write_walk
from .simulations import Recording, WalkerAvoid

FIGURE = "Fig. 11"
TITLE = "walker, obstacle: the human pushes on, the drive holds it off"
INFLATING = ("moore_penrose", "nonsqueezing", "virtual_linkage")
BEFORE, AFTER = 0.5, 0.2  # [s] about the instant of equal forces in which α_f,1 is looked at
_POSE, _RESULTANT, _ALONG, _ACROSS, _TORQUE, _LOAD, _ENERGY = MOTION_PANELS


def write(
    simulation: WalkerAvoid, recording: Recording, out: Path
) -> tuple[list[Claim], list[str]]:
    """Decompose, check the claims, write everything into ``out``; claims and names of files."""
    walk = Walk(recording)
    found = claims(walk, simulation)
    files = write_walk(
        walk,
        found,
        out,
        title=TITLE,
        columns=_columns(recording, simulation.reach),
        outline=simulation.body.outline,
        marks=recording.time[equalities(recording)].tolist(),
        obstacles=(Box(center=(simulation.obstacle + 0.25, 0.0), size=(0.5, 2.0)),),
    )
    return found, files


def claims(walk: Walk, simulation: WalkerAvoid) -> list[Claim]:
    """What section V-A says of the obstacle."""
    return [*_setup(walk, simulation), *_peaks(walk), *_jump(walk), *_methods(walk)]


def equalities(recording: Recording) -> IntArray:
    """Steps from which the resultant force has the other sign: there both forces were equal."""
    resultant = recording.applied[..., 0].sum(axis=1)
    opposed = recording.applied[:, 0, 0] * recording.applied[:, 1, 0] < 0
    signed = np.where(resultant != 0, np.arange(len(resultant)), 0)
    sign = np.sign(resultant)[np.maximum.accumulate(signed)]  # of the last that had one
    return np.flatnonzero((sign[1:] * sign[:-1] < 0) & opposed[1:]) + 1


def _setup(walk: Walk, simulation: WalkerAvoid) -> list[Claim]:
    recording = walk.recording
    front = max(x for x, _ in simulation.body.outline)
    beyond = recording.planned[-1, 0] + front - simulation.obstacle
    far = recording.clearance > simulation.reach
    away = recording.twist_object[:, 0] < 0
    opening = away & np.append(away[1:], away[-1:])  # at either end of the control step
    return [
        Claim(text="the human's plan leads into the obstacle: by", source="set-up",
              measured=beyond, relation=">", bound=0.0, unit="m"),
        Claim(text="the walker stops short of the obstacle: smallest clearance", source=FIGURE,
              measured=smallest(recording.clearance), relation=">", bound=0.0, unit="m"),
        Claim.zero("the walker stops: speed at the end", FIGURE, largest(recording.twist[-1:, :2]),
                   within=0.02, unit="m/s",
                   why="it creeps on as long as the human pushes: the drive's force is in "
                   "proportion to the speed"),
        Claim.zero("the drive gives no force beyond C_max or when moving away (largest)",
                   "section V-A", _largest_or_zero(recording.applied[far | opening, 1, 0]),
                   within=0.0, unit="N",
                   why=f"{int((far | opening).sum())} such samples of {len(far)}"),
    ]  # fmt: skip


def _peaks(walk: Walk) -> list[Claim]:
    at, ours = equalities(walk.recording), walk.ours
    force, cost = ours.internal_force_level, ours.relative_cost
    first_at = int(at[0]) if len(at) else -len(force)
    nearest = np.abs(at - int(cost.argmax())).min() if len(at) else np.nan
    peaks = [cost[max(k - 1, 0) : k + 1].max() for k in at]
    return [
        Claim.zero("F_I is largest where the two forces are first equal: apart by", FIGURE,
                   abs(int(force.argmax()) - first_at), within=1, unit="control steps",
                   why=f"F_I {force.max():.4g} N at {walk.recording.time[force.argmax()]:.2f} s"),
        Claim.zero("γ is largest where the two forces are equal: apart by", FIGURE, nearest,
                   within=1, unit="control steps",
                   why=f"they are equal {len(at)} times, at "
                   + ", ".join(f"{walk.recording.time[k]:.2f} s" for k in at)),
        Claim(text="γ peaks each time the two forces are equal (smallest of the peaks)",
              source=FIGURE, measured=min(peaks, default=np.nan), relation=">", bound=0.9,
              why="1 at the instant itself, which lies between two control steps"),
    ]  # fmt: skip


def _jump(walk: Walk) -> list[Claim]:
    at, share = equalities(walk.recording), walk.load.force[:, 0]
    dt = walk.recording.time[1] - walk.recording.time[0]
    first_at = int(at[0]) if len(at) else 0
    before = share[max(first_at - round(BEFORE / dt), 0) : first_at]
    after = share[first_at : first_at + round(AFTER / dt)] if len(at) else share[:0]
    return [
        Claim.zero(f"α_f,1 = 1 in the {BEFORE:g} s before the forces are first equal "
                   "(largest departure)", FIGURE, largest(before - 1), within=ZERO),
        Claim.zero(f"α_f,1 = 0 in the {AFTER:g} s after (largest)", FIGURE, largest(after),
                   within=ZERO, why="it jumps within one control step"),
    ]  # fmt: skip


def _methods(walk: Walk) -> list[Claim]:
    ours = walk.ours.internal_force_level
    rows = [
        Claim.zero(f"{LOOKS[name].label} = ours: F_I (largest difference)", FIGURE,
                   largest(walk.by_method[name].internal_force_level - ours), within=ZERO,
                   unit="N")
        for name in ("point_mass", "prioritized_torque")
    ]  # fmt: skip
    for name in INFLATING:
        theirs = walk.by_method[name].internal_force_level
        label = LOOKS[name].label
        rows += [
            Claim(text=f"{label} never finds less F_I than ours: smallest difference",
                  source=FIGURE, measured=float((theirs - ours).min()), relation="≥",
                  bound=-ZERO, unit="N"),
            Claim(text=f"{label} inflates F_I: its peak less that of ours", source=FIGURE,
                  measured=theirs.max() - ours.max(), relation=">", bound=ZERO, unit="N",
                  why=f"{theirs.max():.3g} N instead of {ours.max():.3g} N"),
        ]  # fmt: skip
    return rows


def _columns(recording: Recording, reach: float) -> tuple[tuple[Panel, ...], ...]:
    def clearance(trial: Trial) -> list[Curve]:
        limit = np.full(len(trial.time), reach)
        return [curve(first("C"), recording.clearance), curve(second("C_max"), limit)]

    def speed(trial: Trial) -> list[Curve]:
        return [curve(first("ẋ"), trial.twist[:, 0])]

    def way(trial: Trial) -> list[Curve]:
        planned = curve(second("x planned"), recording.planned[:, 0])
        return [curve(first("x"), trial.pose[:, 0]), planned]

    motion: tuple[Panel, ...] = (
        ("way [m]", way),
        ("speed [m/s]", speed),
        ("clearance [m]", clearance),
        _RESULTANT,
        _ALONG,
    )
    return motion, (_LOAD, _ENERGY, *DISAGREEMENT_PANELS)


def _largest_or_zero(force: np.ndarray) -> float:
    return largest(force) if force.size else 0.0
