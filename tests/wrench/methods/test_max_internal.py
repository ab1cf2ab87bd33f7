"""Maximal internal force method: plausible, and optimal within its gap."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput
from coopenv.wrench.methods.max_internal import CLOSED

# reconstructed from the paper's numbers, which does not print these forces
FIGURE_5 = np.array([[3.0, 3.0, 0.0], [4.0, -1.0, 0.0], [-3.0, 0.0, 0.0]])


def decompose(applied, grips):
    return wrench.decompose(applied, grips, method="max_internal")


def random_forces(seed, count, num_effectors, dimension):
    forces = np.zeros((count, num_effectors, 3 * dimension - 3))
    shape = (count, num_effectors, dimension)
    forces[..., :dimension] = np.random.default_rng(seed).normal(size=shape)
    return forces


def test_figure_5():
    d = decompose(FIGURE_5, np.zeros((3, 2)))
    internal, manipulation = d.internal[:, :2], d.manipulation[:, :2]
    assert np.linalg.norm(internal, axis=-1).sum() == pytest.approx(9.695, abs=5e-4)
    assert np.linalg.norm(manipulation, axis=-1).sum() == pytest.approx(5.584, abs=5e-4)
    from_centre = np.linalg.norm(internal - 0.5 * FIGURE_5[:, :2], axis=-1)
    np.testing.assert_allclose(from_centre, 0.5 * np.linalg.norm(FIGURE_5, axis=-1))
    assert d.gap <= 1e-9
    assert d.solver == "multi_start"


@pytest.mark.parametrize(("num_effectors", "dimension"), [(2, 2), (3, 2), (4, 2), (3, 3)])
def test_nothing_plausible_is_larger_than_the_answer_and_its_gap(num_effectors, dimension):
    rng = np.random.default_rng(num_effectors)
    grips = rng.normal(size=(num_effectors, dimension))
    applied = random_forces(3, 8, num_effectors, dimension)
    d = decompose(applied, grips)
    residuals = d.residuals()
    assert residuals.balance.max() <= 1e-12
    assert residuals.force.max() <= 1e-12
    best = np.linalg.norm(d.internal, axis=(-1, -2))
    # every balanced direction, as far as plausible: none may go beyond the answer and its gap
    forces = applied[..., :dimension]
    matrix = wrench.grasp_matrix(grips).reshape(-1, num_effectors, 3 * dimension - 3)
    _, values, rows = np.linalg.svd(matrix[..., :dimension].reshape(len(matrix), -1))
    basis = rows[len(values) :]
    step = rng.normal(size=(4000, 1, len(basis))) @ basis
    step = step.reshape(-1, 1, num_effectors, dimension)
    reach = ((step * forces).sum(-1) / (step**2).sum(-1)).min(-1).clip(0.0)
    other = reach * np.linalg.norm(step, axis=(-1, -2))
    assert (other <= best + d.gap + 1e-9).all()
    assert (other.max(axis=0) <= best + 1e-9).mean() >= 0.85  # several starts, yet no guarantee


def test_in_space_the_bound_is_mostly_tight_and_effectors_at_one_place_are_solved():
    d = decompose(random_forces(5, 30, 3, 3), np.zeros((3, 3)))
    size = np.linalg.norm(d.internal, axis=(-1, -2))
    assert (d.gap <= 1e3 * CLOSED * size).all()


def test_a_pair_squeezes_with_the_smaller_of_opposing_forces():
    applied = [[[3.0, 1.0, 0.0], [-1.0, 0.5, 0.0]], [[3.0, 1.0, 0.0], [1.0, 0.5, 0.0]]]
    d = decompose(applied, [[-0.9, 0.0], [0.9, 0.0]])
    np.testing.assert_allclose(d.internal[0, :, 0], [1.0, -1.0], atol=1e-8)
    np.testing.assert_allclose(d.internal[1], 0.0, atol=1e-8)
    np.testing.assert_allclose(d.gap, 0.0, atol=1e-7)


def test_effectors_that_agree_or_do_nothing_have_no_internal_force():
    grips = np.random.default_rng(0).normal(size=(3, 2))
    together = np.array([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.0, 0.0]])
    d = decompose([together, np.zeros((3, 3)), together * [[1], [0], [0]]], grips)
    np.testing.assert_allclose(d.internal, 0.0, atol=1e-12)
    np.testing.assert_allclose(d.gap, 0.0, atol=1e-6)


def test_a_batch_is_its_samples_one_by_one_at_any_scale():
    grips = np.random.default_rng(1).normal(size=(3, 2))
    applied = random_forces(2, 6, 3, 2)
    whole = decompose(applied.reshape(2, 3, 3, 3), np.tile(grips, (2, 1, 1, 1)))
    for index in np.ndindex(2, 3):
        one = decompose(applied.reshape(2, 3, 3, 3)[index] * 1e6, grips)
        np.testing.assert_allclose(one.internal / 1e6, whole.internal[index], atol=1e-6)
    assert decompose(np.zeros((0, 3, 3)), grips).gap.shape == (0,)


def test_where_the_bound_is_not_reached_either_the_answer_does_not_depend_on_the_batch():
    grips = np.random.default_rng(1).normal(size=(5, 2))
    applied = random_forces(4, 6, 5, 2)
    whole = decompose(applied, grips)
    assert whole.gap.max() > 1e-3
    for one, internal in zip(applied, whole.internal, strict=True):
        np.testing.assert_allclose(decompose(one, grips).internal, internal, atol=1e-8)


def test_torque_is_refused():
    with pytest.raises(InvalidInput, match="without torque for method='max_internal'"):
        decompose(np.ones((3, 3)), np.eye(3, 2))
