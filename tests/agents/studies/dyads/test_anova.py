"""Repeated-measures ANOVA against published analyses and sums of squares by hand."""

from typing import Any

import numpy as np
import pytest

pytest.importorskip("statsmodels")
pytest.importorskip("pandas")

import pandas as pd

from coopenv.agents.studies.dyads.anova import complete_subjects, repeated_measures
from coopenv.errors import InvalidInput

# Winer, Brown & Michels 1991, Statistical Principles in Experimental Design, table 4.3: reaction
# of 5 persons to 4 drugs. Analysed in the Stata manual, [R] anova, "Repeated-measures ANOVA":
# F(3, 12) = 24.76, Greenhouse-Geisser epsilon 0.6049, p 0.0006 with it.
WINER = [[30, 28, 16, 34], [14, 18, 10, 22], [24, 20, 18, 30], [38, 34, 20, 44], [26, 28, 14, 30]]

# Maxwell & Delaney 2004, Designing Experiments and Analyzing Data, table 12.1: reaction time [ms]
# of 10 subjects, noise absent then present, at angles 0, 4 and 8 degrees. Their chapter 12, and
# Baron & Li 2003, Notes on the use of R for psychology experiments: noise F(1, 9) = 33.77, angle
# F(2, 18) = 40.72, interaction F(2, 18) = 45.31; epsilons of angle and interaction 0.96 and 0.90.
MAXWELL_DELANEY = [
    [420, 420, 480, 480, 600, 780],
    [420, 480, 480, 360, 480, 600],
    [480, 480, 540, 660, 780, 780],
    [420, 540, 540, 480, 780, 900],
    [540, 660, 540, 480, 660, 720],
    [360, 420, 360, 360, 480, 540],
    [480, 480, 600, 540, 720, 840],
    [480, 600, 660, 540, 720, 900],
    [540, 600, 540, 480, 720, 780],
    [480, 420, 540, 540, 660, 780],
]


def long(values, factors, subject="pair") -> Any:
    """A long table of an array (subject, *levels)."""
    index = np.indices(np.shape(values)).reshape(np.ndim(values), -1)
    table = pd.DataFrame(dict(zip([subject, *factors], index, strict=True)))
    return table.assign(value=np.ravel(values).astype(float))


def test_one_factor_reproduces_winer_table_4_3():
    (drug,) = repeated_measures(
        long(WINER, ["drug"], "person"), subject="person", factors=["drug"], value="value"
    )
    assert (drug.df_effect, drug.df_error) == (3, 12)
    assert drug.f == pytest.approx(24.76, abs=0.005)
    assert drug.epsilon == pytest.approx(0.6049, abs=5e-5)
    assert drug.p_corrected == pytest.approx(0.0006, abs=5e-5)


@pytest.mark.parametrize("subject", ["s", "pair"])  # "s" is a part of "noise"
def test_two_factors_reproduce_maxwell_and_delaney_table_12_1(subject):
    values = np.reshape(MAXWELL_DELANEY, (10, 2, 3))
    effects = repeated_measures(
        long(values, ["noise", "angle"], subject),
        subject=subject,
        factors=["noise", "angle"],
        value="value",
    )
    noise, angle, both = effects
    assert [effect.name for effect in effects] == ["noise", "angle", "noise × angle"]
    assert noise.f == pytest.approx(33.77, abs=0.005)
    assert angle.f == pytest.approx(40.72, abs=0.005)
    assert both.f == pytest.approx(45.31, abs=0.005)
    assert [(e.df_effect, e.df_error) for e in effects] == [(1, 9), (2, 18), (2, 18)]
    assert noise.epsilon == pytest.approx(1.0)
    assert angle.epsilon == pytest.approx(0.96, abs=0.005)
    assert both.epsilon == pytest.approx(0.90, abs=0.005)


def test_f_and_effect_size_are_those_of_sums_of_squares():
    values = np.random.default_rng(1).normal(size=(7, 3, 4)) + np.arange(3)[:, None]
    first, second, both = repeated_measures(
        long(values, ["a", "b"]), subject="pair", factors=["a", "b"], value="value"
    )
    grand = values.mean()
    for effect, averaged, count in ((first, values.mean(axis=2), 4), (second, values.mean(1), 3)):
        explained = count * 7 * ((averaged.mean(axis=0) - grand) ** 2).sum()
        rest = averaged - averaged.mean(axis=0) - averaged.mean(axis=1, keepdims=True) + grand
        error = count * (rest**2).sum()
        assert effect.f == pytest.approx(explained / effect.df_effect / (error / effect.df_error))
        assert effect.partial_eta_squared == pytest.approx(explained / (explained + error))
    assert (both.df_effect, both.df_error) == (6, 36)


def test_equal_variances_and_correlations_are_spherical():
    generator = np.random.default_rng(0)
    raw = generator.normal(size=(12, 4))
    raw -= raw.mean(axis=0)
    white = raw @ np.linalg.inv(np.linalg.cholesky(np.cov(raw.T))).T  # sample covariance: identity
    (effect,) = repeated_measures(
        long(white + [0, 1, 2, 3] + generator.normal(size=(12, 1)) * 0, ["a"]),
        subject="pair",
        factors=["a"],
        value="value",
    )
    assert effect.epsilon == pytest.approx(1.0)
    assert effect.p_corrected == pytest.approx(effect.p)


def test_one_contrast_that_carries_all_variance_has_the_smallest_epsilon():
    amounts = np.random.default_rng(0).normal(size=(9, 1))
    noise = 1e-7 * np.random.default_rng(1).normal(size=(9, 4))
    values = amounts * [1.0, -1.0, 1.0, -1.0] + noise
    (effect,) = repeated_measures(long(values, ["a"]), subject="pair", factors=["a"], value="value")
    assert effect.epsilon == pytest.approx(1 / 3, abs=1e-6)


def test_repeated_trials_are_averaged_and_the_order_of_rows_does_not_matter():
    table = long(WINER, ["drug"])
    twice = pd.concat([table.assign(value=table["value"] - 3), table.assign(value=table.value + 3)])
    expected = repeated_measures(table, subject="pair", factors=["drug"], value="value")
    shuffled = twice.sample(frac=1, random_state=3)
    (effect,) = repeated_measures(shuffled, subject="pair", factors=["drug"], value="value")
    assert effect.f == pytest.approx(expected[0].f)


def test_a_subject_without_a_cell_is_named_and_can_be_left_out():
    table = long(WINER, ["drug"]).iloc[:-1]
    with pytest.raises(InvalidInput, match=r"\[4\]"):
        repeated_measures(table, subject="pair", factors=["drug"], value="value")
    assert complete_subjects(table, subject="pair", factors=["drug"]) == [0, 1, 2, 3]


def test_an_effect_that_is_the_same_in_everybody_is_not_tested():
    values = np.arange(4.0)[:, None] + np.random.default_rng(0).normal(size=(5, 1, 3))
    alike, other, both = repeated_measures(
        long(values, ["a", "b"]), subject="pair", factors=["a", "b"], value="value"
    )
    assert np.isnan([alike.f, alike.p, alike.epsilon, both.f, both.p_corrected]).all()
    assert 0 < other.p < 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table.drop(columns="drug"), "column 'drug'"),
        (lambda table: table.assign(value=np.nan), "finite"),
        (lambda table: table.assign(drug=0), "2 levels"),
        (lambda table: table.assign(pair=0), "2 subjects"),
    ],
)
def test_a_bad_table_is_refused(change, message):
    with pytest.raises(InvalidInput, match=message):
        repeated_measures(
            change(long(WINER, ["drug"])), subject="pair", factors=["drug"], value="value"
        )
