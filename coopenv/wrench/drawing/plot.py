"""``wrench.plot``: one split of one wrench as a picture."""

from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, finite_array
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.wrench.decomposition import Decomposition, decompose
from coopenv.wrench.drawing import plane, space
from coopenv.wrench.drawing.scene import ROUNDING, Scene
from coopenv.wrench.grasp import checked_applied, checked_grips, moment
from coopenv.wrench.measures import cost
from coopenv.wrench.plausibility import checked_split
from coopenv.wrench.settings import Settings

SIZE = (6.4, 4.8)  # [in]
LARGEST = 1e100  # [m, N, N·m] beyond, squares are no numbers
SAME = 1e-12  # relative difference up to which wrenches are the same


def plot(
    applied: npt.ArrayLike,
    grips: npt.ArrayLike,
    *,
    internal: npt.ArrayLike | None = None,
    decomposition: Decomposition | None = None,
    method: str = "optimal",
    torque_weight: float | None = None,
    include_induced: bool | None = None,
    regions: bool = True,
    outline: npt.ArrayLike | None = None,
    title: str | None = None,
    legend: bool = True,
    ax: Any = None,
) -> Any:
    """Draw a split: what each effector applied, which part of it moved, which was internal.

    Arrows are forces and arcs torques, on a scale that the picture states: broad and grey what was
    applied, upon it in blue the manipulation wrench and, from its tip on, hollow the internal
    wrench; green the object's. What is below a thousandth of the largest is not drawn. Dashed discs
    (balls) hold the forces of eqs. 9 and 19, shaded is what the bands of eqs. 10 and 20 leave of
    them; the grey arc itself is the band of eq. 11. For two effectors in the plane the lens of what
    is feasible by eqs. 9-11 and balance is shown, in space the lens of both balls; of more
    effectors each one's own region is shown, of which balance leaves a part.

    Parameters
    ----------
    applied
        ``(n, 3)`` planar or ``(n, 6)`` spatial, object frame [N, N·m]: one wrench, no batch.
    grips
        ``(n, 2)`` or ``(n, 3)``, object frame [m].
    internal
        h_I of the shape of ``applied``, for a split of one's own [N, N·m].
    decomposition
        One made before of ``applied`` and ``grips``, instead of ``method``.
    method, torque_weight, include_induced
        As of `decompose`; the last two weigh the relative cost in the title too, and are those of
        ``decomposition`` where that is given. Defaults are those of `Settings`.
    regions
        Whether to show where plausible answers lie.
    outline
        ``(k, 2)`` corners of a planar object, object frame [m]; by default lines to the grips.
    title
        Above the picture; by default the method, γ, F_I and T_I.
    legend
        Whether to say below the picture what is what.
    ax
        Axes of Matplotlib to draw on, in space three-dimensional ones; by default those of a new
        figure that pyplot does not know: ``plot(...).figure.savefig("split.png")``.

    Returns
    -------
    The axes. Artists have a ``gid``, such as ``"internal force 1"``.

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong, a batch is given, or arguments do not go together.
    MissingExtra
        If Matplotlib is not installed: extra ``plot``.
    """
    places, given = _one_sample(applied, grips)
    weights = _weights(decomposition, torque_weight, include_induced)
    split, name = _split(given, places, internal, decomposition, method, weights)
    scene = Scene(given, given - split, split, places, _corners(outline, places))
    axes = _axes(ax, scene.dimension)
    module = plane if scene.dimension == 2 else space
    module.draw(axes, scene, show_regions=regions)
    axes.set_title(_title(scene, name, weights) if title is None else title, fontsize=10)
    if legend:
        _legend(axes)
    return axes


def _one_sample(applied: npt.ArrayLike, grips: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Grips and applied wrench, or raise where there are several."""
    places = checked_grips(grips)
    given = checked_applied(applied, places)
    for name, array in (("applied", given), ("grips", places)):
        if array.ndim != 2:
            raise InvalidInput(
                f"{name} must be of one sample, without batch axes, got shape {array.shape}; plot "
                f"one at a time, for example {name}[{', '.join('0' * (array.ndim - 2))}]"
            )
        _require_drawable(name, array)
    return places, given


def _require_drawable(name: str, array: FloatArray) -> None:
    """Raise `InvalidInput` where a number has no square."""
    if np.abs(array).max() > LARGEST:
        raise InvalidInput(
            f"{name} must be at most {LARGEST:g}, got {np.abs(array).max():g}; give it in SI units"
        )


def _split(
    applied: FloatArray,
    grips: FloatArray,
    internal: npt.ArrayLike | None,
    decomposition: Decomposition | None,
    method: str,
    weights: dict[str, Any],
) -> tuple[FloatArray, str]:
    """The internal wrench that is shown, and whose it is."""
    if (internal is not None) + (decomposition is not None) + (method != "optimal") > 1:
        raise InvalidInput(
            "only one of internal, decomposition and method must be given, got several; leave out "
            "all but the one that says how the wrench is split"
        )
    if internal is not None:
        _, own, _ = checked_split(applied, internal, grips)
        if own.shape != applied.shape:
            raise InvalidInput(
                f"internal must be of shape {applied.shape} as applied, got {own.shape}; plot one "
                "split at a time"
            )
        _require_drawable("internal", own)
        return own, "own split"
    if decomposition is None:
        return decompose(applied, grips, method=method, **weights).internal, method
    if not isinstance(decomposition, Decomposition):
        raise InvalidInput(
            f"decomposition must be what decompose returned, got {type(decomposition).__name__}; "
            "give h_I as internal"
        )
    same = decomposition.applied.shape == applied.shape and decomposition.grips.shape == grips.shape
    if not same or not (
        np.allclose(decomposition.applied, applied, rtol=SAME, atol=0.0)
        and np.allclose(decomposition.grips, grips, rtol=SAME, atol=0.0)
    ):
        raise InvalidInput(
            "decomposition must be of the applied wrench and the grips that are plotted, got one "
            "of others; decompose them, or leave it out"
        )
    return decomposition.internal, decomposition.settings.method


def _corners(outline: npt.ArrayLike | None, grips: FloatArray) -> FloatArray | None:
    if outline is None:
        return None
    corners = finite_array(outline, "outline")
    if grips.shape[1] != 2 or corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
        raise InvalidInput(
            f"outline must be of shape (k, 2), at least three corners of a planar object, got "
            f"{corners.shape} beside grips {grips.shape}; leave it out in space"
        )
    _require_drawable("outline", corners)
    return corners


def _weights(
    decomposition: Decomposition | None, torque_weight: float | None, include_induced: bool | None
) -> dict[str, Any]:
    """Weights of the cost: those that are given, else the decomposition's, which they must equal.

    Without one, else those of `Settings`.
    """
    given = isinstance(decomposition, Decomposition)
    own = decomposition.settings if given else Settings()
    weights = {"torque_weight": own.torque_weight, "include_induced": own.include_induced}
    for name, value in (("torque_weight", torque_weight), ("include_induced", include_induced)):
        if given and value not in (None, weights[name]):
            raise InvalidInput(
                f"{name} must be left out beside a decomposition, which has {weights[name]!r}, got "
                f"{value!r}; decompose with it, or leave out the decomposition"
            )
        weights[name] = weights[name] if value is None else value
    return weights


def _axes(ax: Any, dimension: int) -> Any:
    """Those that were given, if they are of the dimension, or new ones."""
    try:
        from matplotlib.axes import Axes
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtra("a picture of a split", "plot") from error
    if ax is None:
        projection = {"projection": "3d"} if dimension == 3 else {}
        return Figure(figsize=SIZE, layout="constrained").add_subplot(**projection)
    if not isinstance(ax, Axes) or ax.name != ("3d" if dimension == 3 else "rectilinear"):
        kind = "three-dimensional" if dimension == 3 else "planar"
        raise InvalidInput(
            f"ax must be {kind} axes for grips of {dimension} numbers, got {type(ax).__name__}; "
            "leave it out, or make them with projection='3d' for space"
        )
    return ax


def _title(scene: Scene, name: str, weights: dict[str, Any]) -> str:
    """The method, γ, F_I and T_I."""
    before, after = (
        float(cost(part, scene.grips, **weights)) for part in (scene.applied, scene.manipulation)
    )
    relative = 1.0 - after / before if before > 0.0 else 0.0
    levels = internal_levels(scene.internal, scene.grips)
    largest = max(scene.largest_force, scene.largest_torque / scene.size)
    sizes = (1.0, largest, largest * scene.size)
    gamma, force, torque = (
        f"{value if abs(value) > ROUNDING * size else 0.0:.3g}"
        for value, size in zip((relative, *levels), sizes, strict=True)
    )
    return f"{name}: γ = {gamma}, F_I = {force} N, T_I = {torque} N·m"


def internal_levels(internal: FloatArray, grips: FloatArray) -> tuple[float, float]:
    """F_I [N] and T_I [N·m] of one internal wrench (eq. 28)."""
    dimension = grips.shape[1]
    torque = moment(grips, internal) + internal[:, dimension:]
    norms = (np.linalg.norm(part, axis=-1) for part in (internal[:, :dimension], torque))
    force_level, torque_level = (0.5 * float(norm.sum()) for norm in norms)
    return force_level, torque_level


def _legend(axes: Any) -> None:
    """Each kind that is drawn once, below the axes."""
    handles, names = axes.get_legend_handles_labels()
    once = dict(zip(reversed(names), reversed(handles), strict=True))
    order = [name for name in dict.fromkeys(names)]
    axes.legend(
        [once[name] for name in order],
        order,
        loc="upper center",
        bbox_to_anchor=(0.5, -0.13 if not hasattr(axes, "get_zlim") else 0.0),
        ncols=3,
        fontsize=8,
        frameon=False,
    )
