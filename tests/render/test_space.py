"""Pictures of a recorded trial in space: seen from above and aside, z up."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("pygame")

from coopenv.errors import InvalidInput
from coopenv.render.look import APPLIED, BODY, INTERNAL
from coopenv.render.space import SpaceStage, view

BAR = np.array([(-0.5, 0.0, 0.0), (0.5, 0.0, 0.0)])
PLACES = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (np.nan, 0.0, 0.0)])
UPRIGHT = Rotation.from_euler("yz", [(0, 0), (-np.pi / 2, 0), (0, 0)]).as_matrix()  # row 1


def stage(applied=None, internal=None, grips=BAR, places=PLACES, turns=UPRIGHT) -> SpaceStage:
    nothing = np.zeros((len(places), len(grips), 6))
    return SpaceStage(
        places,
        turns,
        grips,
        nothing if applied is None else applied,
        nothing if internal is None else internal,
        width=320,
    )


def pushed(*wrench: float) -> np.ndarray:
    """By the second effector in all three rows."""
    return np.broadcast_to(np.array([(0.0,) * 6, wrench]), (3, 2, 6))


def where(picture, color) -> np.ndarray:
    """Places ``(2, k)`` of a colour, x and y up [px]; the legend left out."""
    rows, columns = np.nonzero((picture[:-50] == color).all(axis=-1))
    return np.stack([columns, -rows])


def test_what_is_higher_is_drawn_higher_and_what_is_upright_stands():
    drawn = stage()
    lying, standing = (where(drawn.picture(row), BODY) for row in (0, 1))
    assert standing.mean(axis=1)[1] > lying.mean(axis=1)[1] + 20
    assert abs(standing.mean(axis=1)[0] - lying.mean(axis=1)[0]) < 3
    assert np.ptp(lying[0]) > 2 * np.ptp(lying[1])
    assert np.ptp(standing[1]) > 3 * np.ptp(standing[0])


def test_x_goes_to_the_right_y_away_and_z_up():
    right, up = view()
    assert right[0] > 0.8
    assert right[1] > 0
    assert right[2] == 0
    assert up[2] > 0.8
    assert np.allclose(view() @ view().T, np.eye(2))


def test_a_force_turns_with_the_object_and_the_internal_one_is_in_the_applied():
    upwards = pushed(0, 0, 10, 0, 0, 0)  # of the object, along the floor once it stands
    drawn = stage(upwards, upwards)
    first, second = (where(drawn.picture(row), INTERNAL) for row in (0, 1))
    assert np.ptp(first[1]) > 3 * np.ptp(first[0])
    assert np.ptp(second[0]) > 2 * np.ptp(second[1])
    alone = stage(upwards).picture(0)
    assert not where(alone, INTERNAL).size
    assert np.ptp(where(alone, APPLIED)[1]) > 20


def test_a_torque_is_an_arrow_round_its_axis():
    about_the_line_of_sight = np.cross(*view())
    turned = stage(pushed(0, 0, 0, *about_the_line_of_sight))
    seen = where(turned.picture(0), APPLIED)
    assert np.ptp(seen[0]) > 15
    assert np.ptp(seen[0]) == pytest.approx(np.ptp(seen[1]), abs=5)
    assert abs(np.corrcoef(seen)[0, 1]) < 0.7  # no line across
    edgewise = where(stage(pushed(0, 0, 0, *view()[1])).picture(0), APPLIED)
    assert edgewise.size
    assert np.ptp(edgewise[1]) < 0.5 * np.ptp(seen[1])


def test_of_a_row_without_a_pose_or_a_wrench_nothing_of_it_is_drawn():
    push = np.array(pushed(10, 0, 0, 0, 0, 0))
    push[0] = np.nan
    drawn = stage(push, push)
    assert where(drawn.picture(0), BODY).size
    assert not where(drawn.picture(0), APPLIED).size
    assert not where(drawn.picture(2), BODY).size
    with pytest.raises(InvalidInput, match="pose must be finite in some rows"):
        stage(places=PLACES[2:], turns=UPRIGHT[2:])


@pytest.mark.parametrize("num_effectors", [1, 2, 3, 5])
def test_any_number_of_grips_makes_an_object(num_effectors):
    grips = np.random.default_rng(0).normal(size=(num_effectors, 3))
    assert where(stage(grips=grips).picture(0), BODY).shape[1] > 100


def test_grips_at_the_centre_of_mass_are_drawn_too():
    picture = stage(pushed(1, 0, 0, 0, 0, 1), grips=np.zeros((2, 3))).picture(0)
    assert where(picture, APPLIED).size
