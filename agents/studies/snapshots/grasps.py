"""Claims of Figs. 2 to 6: what is plausible, and what other methods claim."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench import cost, decompose, is_plausible, residuals

from ..claims import Claim
from ..methods import largest
from . import examples

ZERO = 1e-9  # [N, N·m] what counts as zero; wrenches are about 1, rounding about 1e-15
CERTIFIED = 1e-6  # [N] of a cost of the general solver, which is certified, not exact
SPLIT = 1e-3  # [N] of its forces: costs are certified to 1e-8, forces to the root, of some 10 N
PRINTED = 0.005  # half of the last digit that the paper prints
OTHERS = {"moore_penrose": "Moore-Penrose", "nonsqueezing": "nonsqueezing"}


def line_claims() -> list[Claim]:
    """Fig. 2: who pulls alone or evenly does not fight; one newton of (3, −1) is cancelled."""
    applied = examples.along(examples.LINE)
    wanted = np.array([0.0, 0.0, 1.0])
    found = []
    for method, name in (("optimal", "ours"), ("one_dimensional", "eq. 8")):
        internal = decompose(applied, examples.BEAM, method=method).internal[:, 0, 0]
        found.append(
            Claim.zero(
                f"{name}: f_I,1 is 0, 0, 1 N for (2, 0), (1, 1), (3, −1) N (largest departure)",
                "Fig. 2", largest(internal - wanted), within=ZERO, unit="N",
            )
        )  # fmt: skip
    for method, name in OTHERS.items():
        internal = decompose(applied, examples.BEAM, method=method).internal
        claimed = internal[:, 0, 0] - np.array([1.0, 0.0, 2.0])
        beyond = residuals(applied[0], internal[0], examples.BEAM).force
        found += [
            Claim.zero(
                f"{name}: f_I,1 is 1, 0 and 2 N (largest departure)",
                "Fig. 2", largest(claimed), within=ZERO, unit="N",
            ),
            Claim(
                text=f"{name}: claims of (2, 0) a force that the second did not apply",
                source="Fig. 2", measured=float(beyond), relation=">", bound=ZERO, unit="N",
                why="the distance from the ball of eq. 9",
            ),
        ]  # fmt: skip
    return found


def couple_claims() -> list[Claim]:
    """Fig. 3: a couple turns the beam, so nothing of it is internal."""
    ours = decompose(examples.COUPLE, examples.BEAM)
    found = [
        Claim.zero(
            f"ours: nothing of a couple of 0.7 N at ±1 m is internal ({name})",
            "Fig. 3", level, within=ZERO, unit=unit,
        )
        for name, level, unit in (
            ("F_I", float(ours.internal_force_level), "N"),
            ("largest torque", largest(ours.internal[:, 2]), "N·m"),
        )
    ]  # fmt: skip
    for method, name, force, torque in (
        ("moore_penrose", "Moore-Penrose", 0.35, -0.35),
        ("nonsqueezing", "nonsqueezing", 0.7, -0.7),
        ("virtual_linkage", "virtual linkage", 0.0, 0.0),
    ):
        internal = decompose(examples.COUPLE, examples.BEAM, method=method).internal
        apart = np.array([abs(internal[0, 1]) - force, *(internal[:, 2] - torque)])
        text = f"{name}: calls {force:g} N and {torque:g} N·m of each internal (largest departure)"
        found.append(Claim.zero(text, "Fig. 3", largest(apart), within=ZERO, unit="N, N·m"))
    return found


def disc_claims(samples: int, seed: int) -> list[Claim]:
    """Fig. 4: eq. 9 is the disc whose diameter is the force, for f_I and for f_M alike."""
    force = examples.SINGLE
    angles = np.linspace(0.0, 2 * np.pi, 361)
    rim = 0.5 * force + 0.5 * np.linalg.norm(force) * np.stack(
        [np.cos(angles), np.sin(angles)], axis=-1
    )
    drawn = np.random.default_rng(seed).normal(size=(samples, 2)) * np.linalg.norm(force)
    internal = np.zeros((samples, 2, 3))  # two at one place, who cancel what each other has
    internal[:, 0, :2], internal[:, 1, :2] = drawn, -drawn
    applied = np.zeros((samples, 2, 3))
    applied[:, 0, :2] = force
    applied[:, 1, :2] = -drawn  # all of it internal, which is plausible
    judged = is_plausible(applied, internal, examples.PAIR_POINT)
    by_product = (drawn**2).sum(axis=-1) <= drawn @ force
    other = ((force - drawn) ** 2).sum(axis=-1) <= (force - drawn) @ force
    return [
        Claim.zero(
            "‖f_I‖² = fᵀf_I all along the circle with the diameter f (largest departure)",
            "eq. 9, Fig. 4", largest((rim**2).sum(axis=-1) - rim @ force), within=ZERO, unit="N²",
        ),
        Claim.zero(
            f"‖f_I‖² ≤ fᵀf_I exactly in the disc (of {samples} random f_I judged otherwise)",
            "eq. 9, Fig. 4", float((judged != by_product).sum()), within=0.0,
            why=f"{int(by_product.sum())} lie in it",
        ),
        Claim.zero(
            f"and exactly where ‖f_M‖² ≤ fᵀf_M (of {samples} judged otherwise)",
            "eqs. 9, 14", float((other != by_product).sum()), within=0.0,
        ),
    ]  # fmt: skip


def trio_claims() -> list[Claim]:
    """Fig. 5: three forces on a point mass, by least cost, by most internal force, by G†."""
    applied, grips = examples.TRIO, examples.POINT
    ours = decompose(applied, grips)
    printed = applied - examples.TRIO_SPLIT
    shared = decompose(applied, grips, method="point_mass")
    most = decompose(applied, grips, method="max_internal")
    least = decompose(applied, grips, method="moore_penrose")
    rims = _sizes(most.manipulation - applied / 2) - 0.5 * _sizes(applied)
    return [
        _near("ours: Σ‖f_M‖", _sum(ours.manipulation), 4.472, within=1e-3),
        Claim.zero(
            "the split of the figure costs as little as ours (difference of J)",
            "Fig. 5", abs(float(cost(examples.TRIO_SPLIT, grips) - ours.cost)), within=CERTIFIED,
            unit="N", why="the optimum's cost is unique, its split is not",
        ),
        Claim.zero(
            "the split of the figure is plausible (distance from the balls of eq. 9)",
            "Fig. 5", float(residuals(applied, printed, grips).force), within=ZERO, unit="N",
        ),
        _near("the split of the figure: Σ‖f_I‖", _sum(printed), 7.85),
        Claim.zero(
            "sharing by eq. 23 costs as little (difference of J)",
            "eq. 23", abs(float(shared.cost - ours.cost)), within=CERTIFIED, unit="N",
            why=f"Σ‖f_I‖ = {_sum(shared.internal):.4g} N",
        ),
        _near("most internal force: Σ‖f_I‖", _sum(most.internal), 9.69),
        _near("most internal force: Σ‖f_M‖", _sum(most.manipulation), 5.58),
        Claim.zero(
            "most internal force lies on all three circles (largest distance)",
            "Fig. 5", largest(rims), within=CERTIFIED, unit="N",
        ),
        Claim(
            text="Moore-Penrose claims of the third more than it applied: ‖f_I,3‖ − ‖f_3‖",
            source="Fig. 5", measured=float(_sizes(least.internal)[2] - _sizes(applied)[2]),
            relation=">", bound=ZERO, unit="N",
        ),
    ]  # fmt: skip


def digit_claims() -> list[Claim]:
    """Fig. 6: three digits squeeze and lift."""
    applied, grips = examples.GRASP, examples.DIGITS
    ours = decompose(applied, grips)
    others = {
        name: decompose(applied, grips, method=method).internal for method, name in OTHERS.items()
    }
    linkage = decompose(applied, grips, method="virtual_linkage").internal
    return [
        Claim.zero(
            "ours: the internal forces are the squeeze, 4 N of each digit (largest departure)",
            "Fig. 6, numbers ours", largest(ours.internal - examples.SQUEEZE), within=SPLIT,
            unit="N",
            why="the bound is the root of the 1e-8 to which costs are certified, of some 10 N",
        ),
        Claim.zero(
            "ours is plausible (distance from the balls of eqs. 9-11)",
            "Fig. 6, numbers ours", max(float(part) for part in ours.residuals()), within=CERTIFIED,
            unit="N, N·m",
        ),
        *(
            Claim(
                text=f"{name}: the digit that only squeezes is said to lift: f_M,1 along f_o",
                source="Fig. 6, numbers ours", measured=float((applied - internal)[0, 1]),
                relation=">", bound=ZERO, unit="N",
                why=f"{beyond(internal):.3g} N outside the ball of eq. 9",
            )
            for name, internal in others.items()
        ),
        Claim(
            text="virtual linkage: not the squeeze alone (largest departure)",
            source="Fig. 6, numbers ours", measured=largest(linkage - examples.SQUEEZE),
            relation=">", bound=ZERO, unit="N",
            why="part of the lift too lies along the lines between the digits",
        ),
    ]  # fmt: skip


def _near(text: str, measured: float, printed: float, within: float = PRINTED) -> Claim:
    return Claim.zero(
        f"{text} = {printed:g} N (departure)",
        "Fig. 5", abs(measured - printed), within=within, unit="N", why=f"{measured:.4f} N",
    )  # fmt: skip


def beyond(internal: FloatArray) -> float:
    """How far a split of the grasp lies outside the balls of eq. 9 [N]."""
    return float(residuals(examples.GRASP, internal, examples.DIGITS).force)


def _sizes(wrench: FloatArray) -> FloatArray:
    return np.linalg.norm(wrench[..., :2], axis=-1)


def _sum(wrench: FloatArray) -> float:
    return float(_sizes(wrench).sum())
