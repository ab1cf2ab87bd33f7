"""Claims, comparison with the published human study, figures and files of the dyads study."""

from pathlib import Path
from typing import Any

import numpy as np

from coopenv.files import written

from ..claims import Claim, number, save_claims, save_rows
from ..figures import new_figure, save_figure
from ..methods import LOOKS
from .analysis import QUADRANTS, DyadAnalysis

# Donner, Endo & Buss 2018, section VI: 12 pairs; mean and standard deviation over pairs.
HUMAN_TORQUE = {"one": (0.1548, 0.0693), "both": (0.1486, 0.0623)}  # [N·m], ours (pTtTC)
HUMAN_DOMINANT = {"one": (31.39, 9.99), "both": (25.20, 9.49), "none": (26.45, 8.23)}  # [%]
HUMAN_F = {  # effect on what, factors: degrees of freedom, F
    ("T_I", ("method",)): ((4, 44), 128.39),
    ("T_I", ("method", "condition")): ((8, 88), 3.1),
    ("dominance", ("condition",)): ((2, 22), 9.219),
}
HUMAN_GUIDE_P = 0.02  # of the guide's effect on T_I
OURS = "prioritized_torque"
LEVEL = 0.05  # of significance
GUIDE_COLORS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#999999")
LABELS = {"condition": "guide", "method": "method"}
GUIDE_LABELS = {"one": "guide to one", "both": "guide to both", "none": "no guide"}


def write(analysis: DyadAnalysis, out: Path) -> tuple[list[Claim], list[str]]:
    """Check the claims and write everything into ``out``; claims and names of files."""
    found = claims(analysis)
    files = save_claims(found, out / "claims")
    files += save_rows(comparison(analysis), out / "comparison")
    rows = effect_rows(analysis)
    if rows:
        files += save_rows(rows, out / "anova")
    for name, table in (
        ("internal_torque.csv", analysis.internal_torque),
        ("quadrants.csv", analysis.quadrants),
    ):
        with written(out / name) as part:
            table.to_csv(part, index=False)
        files.append(name)
    draw_internal_torque(analysis, out / "internal_torque.png")
    files.append("internal_torque.png")
    if analysis.densities:
        draw_densities(analysis, out / "load_density.png")
        _save_densities(analysis, out / "load_density.npz")
        files += ["load_density.png", "load_density.npz"]
    return found, files


def claims(analysis: DyadAnalysis) -> list[Claim]:
    """What section VI found in people, checked on these trials."""
    missing = "; ".join(analysis.notes)
    source = "section VI"
    rows = []
    for text, effects, factors in (
        ("the method matters to T_I", analysis.torque_effects, ("method",)),
        ("the guide matters to T_I", analysis.torque_effects, ("condition",)),
        ("method and guide interact on T_I", analysis.torque_effects, ("method", "condition")),
        ("the guide matters to dominance", analysis.dominance_effects, ("condition",)),
    ):
        effect = next((e for e in effects if e.factors == factors), None)
        why = missing if effect is None else effect.row()["F"] + (
            f", ε = {effect.epsilon:.2f}, p corrected {effect.p_corrected:.2g}"
        )  # fmt: skip
        rows.append(
            Claim(
                text=f"{text}: p",
                source=source,
                measured=np.nan if effect is None else effect.p,
                relation="<",
                bound=LEVEL,
                why=why,
            )
        )
    rows.append(
        Claim(
            text="ours finds the lowest T_I with every guide: least margin to another method",
            source="Fig. 15", measured=_least_margin(analysis), relation=">", bound=0.0,
            unit="N·m",
        )
    )  # fmt: skip
    means = 100 * analysis.quadrants.groupby("condition")["dominant"].mean()
    rows += [
        Claim(
            text=f"agent 1 dominates longer: guide to one less {GUIDE_LABELS[other]}",
            source="Fig. 16",
            measured=means.get("one", np.nan) - means.get(other, np.nan),
            relation=">",
            bound=0.0,
            unit="% of time",
        )
        for other in ("both", "none")
    ]
    return rows


def comparison(analysis: DyadAnalysis) -> list[dict[str, str]]:
    """These trials beside the human numbers; ± is the standard deviation over pairs."""
    rows = []
    torque = analysis.internal_torque.query("method == @OURS")
    for guide, human in HUMAN_TORQUE.items():
        values = torque.loc[torque["condition"] == guide, "internal_torque"].to_numpy()
        rows.append(
            _beside(analysis.source, f"T_I, ours, {GUIDE_LABELS[guide]} [N·m]", human, values)
        )
    for guide, human in HUMAN_DOMINANT.items():
        chosen = analysis.quadrants["condition"] == guide
        values = 100 * analysis.quadrants.loc[chosen, "dominant"].to_numpy()
        rows.append(
            _beside(analysis.source, f"time in dominant, {GUIDE_LABELS[guide]} [%]", human, values)
        )
    effects = {("T_I", e.factors): e for e in analysis.torque_effects}
    effects |= {("dominance", e.factors): e for e in analysis.dominance_effects}
    for key, ((df_effect, df_error), human_f) in HUMAN_F.items():
        effect = effects.get(key)
        rows.append(
            {
                "quantity": f"F of {' × '.join(LABELS[name] for name in key[1])} on {key[0]}",
                "people": f"F({df_effect}, {df_error}) = {human_f}",
                analysis.source: "-" if effect is None else effect.row()["F"],
                "difference": "-" if effect is None else number(effect.f - human_f),
            }
        )
    guide_effect = effects.get(("T_I", ("condition",)))
    rows.append(
        {
            "quantity": "p of guide on T_I",
            "people": number(HUMAN_GUIDE_P),
            analysis.source: "-" if guide_effect is None else number(guide_effect.p),
            "difference": "-" if guide_effect is None else number(guide_effect.p - HUMAN_GUIDE_P),
        }
    )
    return rows


def effect_rows(analysis: DyadAnalysis) -> list[dict[str, str]]:
    """Both analyses of variance as rows of a table."""
    parts = (("T_I", analysis.torque_effects), ("dominance", analysis.dominance_effects))
    return [
        {"on": on, **effect.row(), "effect": " × ".join(LABELS[name] for name in effect.factors)}
        for on, effects in parts
        for effect in effects
    ]


def draw_internal_torque(analysis: DyadAnalysis, path: Path) -> None:
    """Mean T_I by method and guide, with the standard deviation over pairs (Fig. 15)."""
    table = analysis.internal_torque
    methods = list(dict.fromkeys(table["method"]))
    figure, grid = new_figure(1, 1, size=(9.5, 4.6))
    axes, people = grid[0, 0], []
    width = 0.8 / len(analysis.conditions)
    for i, condition in enumerate(analysis.conditions):
        chosen = table[table["condition"] == condition].groupby("method")["internal_torque"]
        mean, deviation = chosen.mean().reindex(methods), chosen.std().reindex(methods)
        place = np.arange(len(methods)) + (i - (len(analysis.conditions) - 1) / 2) * width
        axes.bar(
            place,
            mean,
            0.92 * width,
            yerr=deviation.fillna(0.0),
            capsize=3,
            color=GUIDE_COLORS[i % len(GUIDE_COLORS)],
            ecolor="#333333",
            label=GUIDE_LABELS.get(condition, condition),
        )
        if condition in HUMAN_TORQUE and OURS in methods:
            people.append((place[methods.index(OURS)] + 0.3 * width, *HUMAN_TORQUE[condition]))
    if people:
        place, mean, deviation = np.transpose(people)
        look = {"fmt": "D", "color": "black", "markersize": 5, "capsize": 2}
        axes.errorbar(place, mean, yerr=deviation, label="people (paper)", **look)
    names = [LOOKS[name].label.replace(" ", "\n", 1) for name in methods]
    axes.set_xticks(range(len(methods)), names)
    axes.set_ylabel("T_I, mean over pairs [N·m]")
    axes.set_ylim(bottom=0)
    figure.suptitle(
        f"{analysis.source}: internal torque at the start, ± standard deviation of pairs"
    )
    axes.grid(axis="y", alpha=0.3)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    save_figure(figure, path)


def draw_densities(analysis: DyadAnalysis, path: Path) -> None:
    """Density of the load shares of agent 1 by guide, with its quadrants (Fig. 16)."""
    conditions = [name for name in analysis.conditions if name in analysis.densities]
    figure, grid = new_figure(1, len(conditions), size=(4.3 * len(conditions) + 1.0, 5.2))
    highest = max(analysis.densities[name].density.max() for name in conditions)
    shares = 100 * analysis.quadrants.groupby("condition")[list(QUADRANTS)].mean()
    picture: Any = None
    for axes, name in zip(grid[0], conditions, strict=True):
        picture = axes.imshow(
            analysis.densities[name].density.T,
            origin="lower",
            extent=(0, 1, 0, 1),
            vmin=0,
            vmax=highest,
            cmap="viridis",
        )
        axes.axhline(0.5, color="white", linewidth=1)
        axes.axvline(0.5, color="white", linewidth=1)
        axes.set_xlabel("α_f,1 (force)")
        row = shares.loc[name]
        axes.set_title(
            f"{GUIDE_LABELS.get(name, name)}\n"
            f"torque only {row['torque_specialist']:.1f} %   dominant {row['dominant']:.1f} %\n"
            f"passive {row['passive']:.1f} %   force only {row['force_specialist']:.1f} %",
            fontsize="medium",
        )
    figure.suptitle(f"{analysis.source}: load shares of agent 1 while the object turns")
    grid[0, 0].set_ylabel("α_t,1 (torque)")
    figure.colorbar(picture, ax=list(grid[0]), label="density", shrink=0.7)
    save_figure(figure, path)


def _save_densities(analysis: DyadAnalysis, path: Path) -> None:
    """Densities (condition, α_f,1, α_t,1) beside their guides, whatever those are called."""
    densities = list(analysis.densities.values())
    with written(path) as part, part.open("wb") as file:
        np.savez_compressed(
            file,
            condition=np.array(list(analysis.densities)),
            share=densities[0].share,
            density=np.stack([each.density for each in densities]),
        )


def _beside(
    source: str, quantity: str, human: tuple[float, float], values: np.ndarray
) -> dict[str, str]:
    if not len(values):
        mean, here = np.nan, "-"
    else:
        mean = float(values.mean())
        deviation = float(values.std(ddof=1)) if len(values) > 1 else np.nan
        here = f"{number(mean)} ± {number(deviation)} ({len(values)} pairs)"
    return {
        "quantity": quantity,
        "people": f"{human[0]} ± {human[1]}",
        source: here,
        "difference": number(mean - human[0]),
    }


def _least_margin(analysis: DyadAnalysis) -> float:
    """How much lower ours is than the next method, with the guide where that is least [N·m]."""
    means = analysis.internal_torque.groupby(["condition", "method"])["internal_torque"].mean()
    table = means.unstack("method")
    if OURS not in table or table.shape[1] < 2:
        return float("nan")
    return float((table.drop(columns=OURS).min(axis=1) - table[OURS]).min())
