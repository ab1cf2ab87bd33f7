"""Claims, figures and files of the beam study (Figs. 12 and 13)."""

from pathlib import Path

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench import Decomposition, energy_share, load_share

from .. import series
from ..claims import Claim, save_claims
from ..figures import (
    DISAGREEMENT_PANELS,
    MOTION_PANELS,
    Curve,
    Panel,
    Trial,
    curve,
    draw_trials,
    first,
    second,
)
from ..methods import decompose_by_methods, largest, smallest
from .simulation import MOTIONS, PAPER, SECTIONS, BeamRun, sections

ZERO = 1e-9  # [N, N·m] what counts as zero; wrenches are about 1, rounding about 1e-16
FIGURE = "Figs. 12-13"
BEYOND = "beyond the paper"
_ARRAYS = (
    "time", "virtual_mass", "wanted_share", "applied", "pose", "planned", "twist", "grips",
)  # fmt: skip


def write(run: BeamRun, out: Path) -> tuple[list[Claim], list[str]]:
    """Decompose, check the claims, write everything into ``out``; claims and names of files."""
    by_method = decompose_by_methods(run.applied, run.grips)
    found = claims(run, by_method)
    files = save_claims(found, out / "claims")
    files += draw(run, by_method, out)
    save_series(run, by_method, out)
    return found, [*files, "series.csv", "series.npz"]


def claims(run: BeamRun, by_method: dict[str, Decomposition]) -> list[Claim]:
    """Every claim of section V-C, over all motions and moments of inertia.

    Two hold for the paper's motions only, as their last rows show.
    """
    where = _Where(run)
    return [
        *_tracking(run),
        *_ours(by_method),
        *_point_mass(by_method["point_mass"], where),
        *_iff(
            "Moore-Penrose",
            _level(by_method["moore_penrose"]),
            (where.no_torque | where.unit_mass) & (where.nothing_along | where.even),
            np.ones_like(where.paper),
            "(t_o = 0 or m* = 1) and (f_o,x = 0 or α^d = ½)",
        ),
        *_nonsqueezing(by_method["nonsqueezing"], where),
        *_virtual_linkage(run, by_method["virtual_linkage"], where),
    ]


def draw(run: BeamRun, by_method: dict[str, Decomposition], out: Path) -> list[str]:
    """Two figures for each moment of inertia: what was done, and what the methods make of it."""
    names = []
    for i, inertia in enumerate(run.inertias):
        trials = [
            Trial(
                title=motion,
                time=run.time,
                pose=run.pose[i, j],
                planned=run.planned[j],
                twist=run.twist[i, j],
                applied=run.applied[i, j],
                grips=run.grips,
                by_method={
                    name: _taken(run, i, j, split.settings.method)
                    for name, split in by_method.items()
                },
            )
            for j, motion in enumerate(MOTIONS)
        ]
        marks = run.time[-1] * np.arange(1, SECTIONS) / SECTIONS
        ending = "" if len(run.inertias) == 1 else f"_J{inertia:.3g}".replace(".", "p")
        for name, panels, what in (
            ("motion", (MOTION_PANELS[0], _schedule_panel(run), *MOTION_PANELS[1:]), "wrenches"),
            ("disagreement", (_schedule_panel(run), *DISAGREEMENT_PANELS), "internal wrench"),
        ):
            file = f"{name}{ending}.png"
            title = f"beam, J = {inertia:.3g} kg·m²: {what}, free of disagreement by construction"
            draw_trials(trials, panels, out / file, title=title, marks=marks.tolist())
            names.append(file)
    return names


def save_series(run: BeamRun, by_method: dict[str, Decomposition], out: Path) -> None:
    """Everything over time, one row a sample, as CSV; the recorded arrays as NPZ."""
    shape = run.applied.shape[:3]  # (inertia, motion, time)
    schedule = {
        "inertia": np.array(run.inertias)[:, None, None],
        "motion": np.array(MOTIONS)[:, None],
        "time": run.time,
        "virtual_mass": run.virtual_mass,
        "wanted_share": run.wanted_share,
    }
    share = load_share(run.applied, run.grips)
    energy = energy_share(run.applied, run.grips, run.twist)
    columns = {
        **{name: np.broadcast_to(value, shape).ravel() for name, value in schedule.items()},
        **series.columns_of(series.POSE, run.pose),
        **series.columns_of(series.TWIST, run.twist),
        **series.columns_of(series.WRENCHES, run.applied),
        "force_share_1": share.force[..., 0].ravel(),
        "torque_share_1": share.torque[..., 0].ravel(),
        "energy_share_1": energy.total[..., 0].ravel(),
        **series.measure_columns(by_method),
    }
    series.save_columns(columns, out / "series.csv")
    arrays = {name: getattr(run, name) for name in _ARRAYS}
    arrays |= {"inertias": np.array(run.inertias), "motions": np.array(MOTIONS)}
    series.save_arrays(arrays, by_method, out / "series.npz")


class _Where:
    """Masks of samples ``(inertia, motion, time)``: what was planned and done in each."""

    def __init__(self, run: BeamRun):
        shape = run.applied.shape[:3]
        self.unit_mass = np.broadcast_to(~run.heavy, shape)
        self.even = np.broadcast_to(~run.shifted, shape)
        self.no_torque = np.abs(run.object_wrench[..., 2]) <= ZERO
        self.nothing_along = np.abs(run.object_wrench[..., 0]) <= ZERO
        motion = np.array(MOTIONS)[None, :, None]
        self.rotation = np.broadcast_to(motion == "rotate", shape)
        self.translation = np.broadcast_to(motion == "translate", shape)
        self.askew = np.broadcast_to(motion == "translate askew", shape)
        self.paper = np.broadcast_to(np.isin(motion, PAPER), shape)


def _tracking(run: BeamRun) -> list[Claim]:
    error = run.tracking_error
    parts = sections(run)
    covered = min(int(parts[k].sum()) for k in range(SECTIONS))
    return [
        Claim.zero(
            "the beam follows its plan: position", "set-up", error[..., 0].max(), within=1e-3,
            unit="m",
        ),
        Claim.zero(
            "the beam follows its plan: angle", "set-up", error[..., 1].max(), within=1e-3,
            unit="rad",
        ),
        Claim(
            text="samples of each motion in each combination of m* = 1 or not, α^d = ½ or not",
            source="set-up", measured=covered, relation="≥", bound=10,
        ),
    ]  # fmt: skip


def _ours(by_method: dict[str, Decomposition]) -> list[Claim]:
    rows = []
    for name, label in (("optimal", "ours"), ("prioritized_torque", "ours (pTtTC)")):
        split = by_method[name]
        for symbol, level, unit in (
            ("F_I", split.internal_force_level, "N"),
            ("T_I", split.internal_torque_level, "N·m"),
            ("γ", split.relative_cost, ""),
        ):
            text = f"{label}: {symbol} = 0 throughout (largest)"
            rows.append(Claim.zero(text, FIGURE, largest(level), within=ZERO, unit=unit))
    return rows


def _point_mass(split: Decomposition, where: _Where) -> list[Claim]:
    turning = where.rotation & ~where.no_torque
    force = split.internal_force_level
    return [
        Claim(
            text="point mass fails in rotation: F_I > 0 (largest)",
            source=FIGURE, measured=largest(force, turning), relation=">", bound=ZERO, unit="N",
        ),
        Claim(
            text="point mass fails in rotation: F_I > 0 at every sample with t_o ≠ 0 (smallest)",
            source=FIGURE, measured=smallest(force, turning), relation=">", bound=ZERO, unit="N",
        ),
        Claim.zero(
            "point mass: F_I = T_I = 0 in pure translation (largest)",
            "eqs. 22-23", largest(_level(split), where.translation), within=ZERO, unit="N, N·m",
        ),
        Claim.zero(
            "point mass: F_I = T_I = 0 in translation askew to the beam (largest)",
            BEYOND, largest(_level(split), where.askew), within=ZERO, unit="N, N·m",
            why="the torques that the agents' forces induce cancel at the centre of mass; they "
            "are needed to keep the beam from turning, but a point mass calls them internal",
        ),
    ]  # fmt: skip


def _iff(
    method: str, level: FloatArray, condition: BoolArray, among: BoolArray, text: str
) -> list[Claim]:
    """Claims that a level is zero where the condition holds, and above zero everywhere else."""
    elsewhere = among & ~condition
    return [
        Claim.zero(
            f"{method}: F_I = T_I = 0 where {text} (largest)",
            FIGURE, largest(level, among & condition), within=ZERO, unit="N, N·m",
        ),
        Claim(
            text=f"{method}: not zero anywhere else (smallest of {int(elsewhere.sum())} samples)",
            source=FIGURE, measured=smallest(level, elsewhere), relation=">", bound=ZERO,
            unit="N, N·m", why=f"largest: {largest(level, elsewhere):.3g}",
        ),
    ]  # fmt: skip


def _nonsqueezing(split: Decomposition, where: _Where) -> list[Claim]:
    condition = where.translation & where.even
    askew = largest(split.internal_torque_level, where.askew & where.even)
    text = "pure translation and α^d = ½"
    return [
        *_iff("nonsqueezing", _level(split), condition, where.paper, text),
        Claim.zero(
            "nonsqueezing: T_I = 0 in translation askew to the beam with α^d = ½ (largest)",
            BEYOND, askew, within=ZERO, unit="N·m",
            why="it wants torques that undo the forces' levers, t_M,i = −r_i × f_o/n, although "
            "nothing turns: zero only along the beam",
        ),
    ]  # fmt: skip


def _virtual_linkage(run: BeamRun, split: Decomposition, where: _Where) -> list[Claim]:
    nothing = where.nothing_along | where.even
    force, torque = split.internal_force_level, split.internal_torque_level
    pure = np.abs(run.applied[..., 2]).sum(axis=-1) / 2
    return [
        Claim.zero(
            "virtual linkage: F_I = 0 where f_o,x = 0 or α^d = ½ (largest)",
            FIGURE, largest(force, nothing), within=ZERO, unit="N",
        ),
        Claim(
            text="virtual linkage: F_I > 0 elsewhere (smallest)",
            source=FIGURE, measured=smallest(force, ~nothing), relation=">", bound=ZERO, unit="N",
            why=f"largest: {largest(force, ~nothing):.3g}",
        ),
        Claim.zero(
            "virtual linkage calls every pure torque internal: |T_I − ½Σ|t_i|| (largest)",
            FIGURE, largest(torque - pure), within=ZERO, unit="N·m",
            why=f"T_I up to {largest(torque):.3g} N·m",
        ),
    ]  # fmt: skip


def _level(split: Decomposition) -> FloatArray:
    """The larger of F_I and T_I: zero where both are."""
    return np.maximum(split.internal_force_level, split.internal_torque_level)


def _taken(run: BeamRun, i: int, j: int, method: str) -> Decomposition:
    return decompose_by_methods(run.applied[i, j], run.grips, (method,))[method]


def _schedule_panel(run: BeamRun) -> Panel:
    def curves(trial: Trial) -> list[Curve]:
        return [
            curve(first("m* [kg]"), run.virtual_mass),
            curve(second("α^d"), run.wanted_share),
        ]

    return "schedules", curves
