"""What was assumed of a recorded file, by declaration or default: frames, signs, units, grips."""

from dataclasses import fields

from coopenv.arrays import FloatArray
from coopenv.logs.columns import ORIENTATION, POSITION, TWIST, quantity
from coopenv.logs.layout import UNITS, Layout
from coopenv.logs.plan import Plan

DEFAULTS = {entry.name: entry.default for entry in fields(Layout)}
LISTED = 6  # grips that are written out


def assumptions(layout: Layout, plan: Plan, grips: FloatArray | None) -> tuple[str, ...]:
    """One line each on frames, signs, units and grips.

    Parameters
    ----------
    layout
        As it was declared.
    plan
        Which columns were found.
    grips
        Those that hold for all rows ``(n, 2 or 3)`` [m], y up; ``None`` where columns say them.
    """
    return (
        f"frames: {_frames(layout, plan)}",
        f"signs: {_signs(plan)}; {_marked(layout, 'y', 'y ' + layout.y)}",
        f"units: {_units(layout, plan)}",
        f"grips: {_grips(layout, plan, grips)}",
    )


def _marked(layout: Layout, name: str, text: str) -> str:
    """A field's text, with a note where it is the default."""
    return f"{text} (the default)" if getattr(layout, name) == DEFAULTS[name] else text


def _frames(layout: Layout, plan: Plan) -> str:
    """Of all there is."""
    forces = "forces" if layout.forces_only else "forces and torques"
    said = [_marked(layout, "frame", f"{forces} in the {layout.frame} frame")]
    if plan.has(TWIST[plan.dimension]):
        note = " (that of the forces, the default)" if layout.twist_frame == layout.frame else ""
        said.append(f"twist in the {layout.twist_frame} frame{note}")
    if plan.has(POSITION[plan.dimension]) or plan.has(ORIENTATION[plan.dimension]):
        said.append("pose of the object in the world")
    return ", ".join(said)


def _signs(plan: Plan) -> str:
    """Of whom the forces are, and which columns were turned."""
    turned = [f"{name} = −{plan.source[name]}" for name, size in plan.factor.items() if size < 0]
    return "as applied to the object" + f", with {', '.join(turned)}" * bool(turned)


def _units(layout: Layout, plan: Plan) -> str:
    """Of every quantity there is."""
    kinds = {quantity(name) for name in plan.source}
    if layout.grips is not None:
        kinds.add("length")
    said: dict[bool, list[str]] = {False: [], True: []}
    in_file = {quantity(name): unit for name, unit in plan.units.items()}
    for kind in UNITS:
        of_grips = kind == "length" and layout.grips is not None  # which the file does not say
        if kind in kinds and (kind not in in_file or of_grips):
            unit = getattr(layout, kind)
            said[unit == DEFAULTS[kind]].append(f"{kind.replace('_', ' ')} {unit}")
    by_default = [f"by default {', '.join(said[True])}"] if said[True] else []
    of_file = [f"{str(kind).replace('_', ' ')} {unit}" for kind, unit in in_file.items()]
    by_file = [f"in the file {', '.join(of_file)}"] if of_file else []
    return "; ".join([*filter(None, [", ".join(said[False])]), *by_file, *by_default])


def _grips(layout: Layout, plan: Plan, grips: FloatArray | None) -> str:
    """Where the effectors hold, and who says so."""
    if grips is None:
        told = f"in the columns {plan.effector_names('r')[0][0]} …, "
        return told + _marked(layout, "grip_frame", f"{layout.grip_frame} frame")
    shown = [f"({', '.join(f'{x:.6g}' for x in grip)})" for grip in grips[:LISTED].tolist()]
    more = " …" * (len(grips) > LISTED)
    whose = "of the file" if layout.grips is None else "as declared"
    return f"{', '.join(shown)}{more} m in the object frame, {whose}"
