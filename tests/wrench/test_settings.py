"""Settings of a decomposition: defaults, names and refusals."""

import dataclasses
from typing import get_args

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import CoopenvError, InvalidInput, UnknownName
from coopenv.wrench.settings import PLAUSIBLE, Method, Solver


def test_defaults_are_the_recommended_cost():
    settings = wrench.Settings()
    assert (settings.method, settings.solver) == ("optimal", "auto")
    assert (settings.torque_weight, settings.include_induced) == (0.5, False)


def test_every_method_and_solver_that_can_be_named_is_there_and_no_other():
    assert list(wrench.METHODS) == list(get_args(Method))
    assert ["auto", *wrench.SOLVERS] == list(get_args(Solver))


@pytest.mark.parametrize("method", sorted(PLAUSIBLE))
def test_a_method_that_is_called_plausible_claims_no_more_than_was_applied(method):
    random = np.random.default_rng(0).normal(size=(200, 2, 3))
    kinds = [random, random * [1, 1, 0], random * [1, 0, 0]]  # all, forces, forces along the beam
    answered = 0
    for applied in kinds:
        try:
            split = wrench.decompose(applied, [[-0.9, 0.0], [0.9, 0.0]], method=method)
        except InvalidInput:
            continue
        answered += 1
        assert np.max(split.residuals()) <= 1e-12
    assert answered


def test_settings_are_frozen_hashable_and_replaceable():
    settings = wrench.Settings(
        method="parametrized",
        virtual_masses=np.array([1.0, 2.0]),  # pyright: ignore[reportArgumentType]
    )
    with pytest.raises(dataclasses.FrozenInstanceError):
        settings.torque_weight = 0.3  # pyright: ignore[reportAttributeAccessIssue]
    assert settings.virtual_masses == (1.0, 2.0)
    assert dataclasses.replace(settings, torque_weight=0.3).torque_weight == 0.3
    assert hash(settings) == hash(dataclasses.replace(settings))


def test_unknown_names_suggest_the_nearest():
    with pytest.raises(UnknownName, match="did you mean 'moore_penrose'"):
        wrench.Settings(method="more_penrose")
    with pytest.raises(UnknownName, match="solver must be one of the known names, got 'pear'"):
        wrench.Settings(solver="pear")
    with pytest.raises(UnknownName, match="method must be one of"):
        wrench.Settings(method=None)  # pyright: ignore[reportArgumentType]


def test_unknown_keywords_are_refused():
    with pytest.raises(TypeError, match="torqe_weight"):
        wrench.Settings(torqe_weight=0.5)  # pyright: ignore[reportCallIssue]


@pytest.mark.parametrize("weight", [0.0, 1.0, 1.5])
def test_torque_weight_must_lie_inside_the_unit_interval(weight):
    with pytest.raises(InvalidInput, match=r"torque_weight must be in \]0, 1\[, got"):
        wrench.Settings(torque_weight=weight)


@pytest.mark.parametrize("weight", [-0.1, np.nan, "half", True, None])
def test_torque_weight_must_be_a_positive_number(weight):
    with pytest.raises(InvalidInput, match="torque_weight must be"):
        wrench.Settings(torque_weight=weight)


@pytest.mark.parametrize("name", ["include_induced", "surroundings"])
def test_a_number_is_no_flag(name):
    with pytest.raises(InvalidInput, match=f"{name} must be True or False, got 1"):
        wrench.Settings(**{name: 1})  # pyright: ignore[reportArgumentType]


def test_include_induced_must_be_a_bool():
    assert wrench.Settings(include_induced=np.True_).include_induced is True  # pyright: ignore
    with pytest.raises(InvalidInput, match="include_induced must be True or False, got 'no'"):
        wrench.Settings(include_induced="no")  # pyright: ignore[reportArgumentType]


def test_what_belongs_to_another_method_is_refused():
    with pytest.raises(InvalidInput, match="solver must be 'auto' for method='point_mass'"):
        wrench.Settings(method="point_mass", solver="pair")
    with pytest.raises(InvalidInput, match="virtual_masses must be left out for method='optimal'"):
        wrench.Settings(virtual_masses=(1.0, 1.0))
    with pytest.raises(InvalidInput, match="virtual_inertias must be finite"):
        wrench.Settings(method="parametrized", virtual_inertias=(1.0, np.inf))


def test_our_exceptions_are_builtin_ones_too():
    assert issubclass(InvalidInput, ValueError)
    assert issubclass(UnknownName, ValueError)
    assert issubclass(UnknownName, CoopenvError)
