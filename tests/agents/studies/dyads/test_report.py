"""The report of the dyads study on a made-up analysis: every cell, every claim's number."""

from typing import Any

import numpy as np
import pytest

pytest.importorskip("matplotlib")
pytest.importorskip("pandas")

import pandas as pd

from coopenv.agents.studies.dyads import report
from coopenv.agents.studies.dyads.analysis import DyadAnalysis
from coopenv.agents.studies.dyads.anova import Effect

OURS = "prioritized_torque"


def effect(*factors, f, p, df=(2, 4)):
    return Effect(
        factors=factors, f=f, df_effect=df[0], df_error=df[1], p=p, epsilon=0.75,
        p_corrected=2 * p, partial_eta_squared=0.625,
    )  # fmt: skip


def analysis(**changes: Any) -> DyadAnalysis:
    """Two pairs; ours finds 0.1 and 0.3 N·m with a guide to one, 0.15 and 0.25 with one to both."""
    torque = [
        (pair, guide, method, 3, level + more)
        for guide, levels in (("one", (0.1, 0.3)), ("both", (0.15, 0.25)), ("none", (0.4, 0.6)))
        for pair, level in enumerate(levels)
        for method, more in ((OURS, 0.0), ("moore_penrose", 0.5), ("point_mass", 0.125))
    ]
    quadrants = [
        (pair, guide, share, 0.25, 0.125, 0.625 - share)
        for guide, shares in (("one", (0.5, 0.3)), ("both", (0.2, 0.4)), ("none", (0.25, 0.05)))
        for pair, share in enumerate(shares)
    ]
    shares = ["dominant", "passive", "force_specialist", "torque_specialist"]
    known: dict[str, Any] = {
        "source": "made up",
        "internal_torque": pd.DataFrame(
            torque, columns=["pair", "condition", "method", "num_trials", "internal_torque"]
        ),
        "torque_effects": (
            effect("method", f=100.0, p=1e-9), effect("condition", f=5.5, p=0.03),
            effect("method", "condition", f=2.5, p=0.06, df=(4, 4)),
        ),
        "quadrants": pd.DataFrame(quadrants, columns=["pair", "condition", *shares]),
        "dominance_effects": (effect("condition", f=10.0, p=0.01),),
        "densities": {},
        "conditions": ("one", "both", "none"),
        "num_pairs": 2, "num_trials": 18, "notes": (),
    }  # fmt: skip
    return DyadAnalysis(**{**known, **changes})


def test_every_cell_of_the_comparison_is_the_number_of_its_row():
    rows = [tuple(row.values()) for row in report.comparison(analysis())]
    assert list(report.comparison(analysis())[0]) == [
        "quantity", "people", "made up", "difference",
    ]  # fmt: skip
    # ± is the standard deviation of two: their difference by √2
    assert rows == [
        ("T_I, ours, guide to one [N·m]", "0.1548 ± 0.0693", "0.2 ± 0.1414 (2 pairs)", "0.0452"),
        ("T_I, ours, guide to both [N·m]", "0.1486 ± 0.0623", "0.2 ± 0.07071 (2 pairs)", "0.0514"),
        ("time in dominant, guide to one [%]", "31.39 ± 9.99", "40 ± 14.14 (2 pairs)", "8.61"),
        ("time in dominant, guide to both [%]", "25.2 ± 9.49", "30 ± 14.14 (2 pairs)", "4.8"),
        ("time in dominant, no guide [%]", "26.45 ± 8.23", "15 ± 14.14 (2 pairs)", "-11.45"),
        ("F of method on T_I", "F(4, 44) = 128.39", "F(2, 4) = 100.00", "-28.39"),
        ("F of method × guide on T_I", "F(8, 88) = 3.1", "F(4, 4) = 2.50", "-0.6"),
        ("F of guide on dominance", "F(2, 22) = 9.219", "F(2, 4) = 10.00", "0.781"),
        ("p of guide on T_I", "0.02", "0.03", "0.01"),
    ]


def test_what_is_missing_is_a_dash():
    table = analysis().internal_torque
    nobody = analysis(
        internal_torque=table[(table["condition"] != "one") & (table["pair"] == 0)],
        torque_effects=(), dominance_effects=(),
    )  # fmt: skip
    rows = report.comparison(nobody)
    assert tuple(rows[0].values())[2:] == ("-", "-")
    assert rows[1]["made up"] == "0.15 ± - (1 pairs)"
    assert [tuple(row.values())[2:] for row in rows[5:]] == [("-", "-")] * 4


def test_every_claim_has_its_own_number_and_rule():
    found = report.claims(analysis())
    assert [(claim.measured, claim.relation, claim.bound) for claim in found[:4]] == [
        (1e-9, "<", 0.05), (0.03, "<", 0.05), (0.06, "<", 0.05), (0.01, "<", 0.05),
    ]  # fmt: skip
    assert [claim.holds for claim in found] == [True, True, False, True, True, True, True]
    assert found[2].why == "F(4, 4) = 2.50, ε = 0.75, p corrected 0.12"
    assert found[4].measured == pytest.approx(0.125)  # the next lowest, everywhere by as much
    assert (found[5].measured, found[6].measured) == pytest.approx((10.0, 25.0))
    assert "guide to both" in found[5].text
    assert "no guide" in found[6].text


def test_the_margin_is_the_least_of_all_guides_and_methods():
    table = analysis().internal_torque.copy()
    lower = (table["method"] == "point_mass") & (table["condition"] == "both")
    table.loc[lower, "internal_torque"] -= 0.225
    found = report.claims(analysis(internal_torque=table))
    assert found[4].measured == pytest.approx(-0.1)
    assert not found[4].holds
    alone = table[table["method"] == OURS]
    assert np.isnan(report.claims(analysis(internal_torque=alone))[4].measured)


def test_a_table_of_effects_names_what_they_are_on():
    rows = report.effect_rows(analysis())
    assert [(row["on"], row["effect"]) for row in rows] == [
        ("T_I", "method"), ("T_I", "guide"), ("T_I", "method × guide"), ("dominance", "guide"),
    ]  # fmt: skip
    assert rows[2] == {
        "on": "T_I", "effect": "method × guide", "F": "F(4, 4) = 2.50", "p": "0.06",
        "ε (Greenhouse-Geisser)": "0.750", "p corrected": "0.12", "partial η²": "0.625",
    }  # fmt: skip


def test_what_people_did_stands_beside_the_model_where_the_paper_says_it(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(report, "save_figure", lambda figure, path: drawn.append(figure))
    report.draw_internal_torque(analysis(), tmp_path / "torque.png")
    handles, labels = drawn[0].axes[0].get_legend_handles_labels()
    (people,) = [h for h, label in zip(handles, labels, strict=True) if label == "people (paper)"]
    heights = people[0].get_ydata()
    assert sorted(heights) == sorted(mean for mean, _ in report.HUMAN_TORQUE.values())
    (bars,) = people[2]
    told = sorted((mean - off, mean + off) for mean, off in report.HUMAN_TORQUE.values())
    drawn_from_to = sorted(tuple(bar[:, 1]) for bar in bars.get_segments())
    np.testing.assert_allclose(drawn_from_to, told)
