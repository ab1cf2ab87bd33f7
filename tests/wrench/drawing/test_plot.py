"""Pictures of a split: which arrows there are, how long they are, what is refused."""

import sys

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from coopenv import wrench
from coopenv.errors import InvalidInput, MissingExtra

BEAM = np.array([(-0.9, 0.0), (0.9, 0.0)])
FIGHT = np.array([(3.0, 0.0, 0.0), (-1.0, 0.0, 0.0)])
AGREE = np.array([(3.0, 1.0, 0.0), (3.0, 1.0, 0.0)])
TURNING = np.array([(0.0, 2.0, 3.0), (1.0, 2.0, -2.0)])
IN_SPACE = np.array([(3.0, 3.0, 1.0, 0.0, 0.0, 1.0), (-1.0, 2.0, -2.0, 0.0, 0.5, -0.8)])
SPACE = np.array([(-0.5, 0.0, 0.0), (0.5, 0.2, 0.1)])
VERMILION = np.array([0xD5, 0x5E, 0x00])


def names(axes) -> set[str]:
    return {artist.get_gid() for artist in axes.get_children() if artist.get_gid()}


def internal(axes) -> set[str]:
    return {name for name in names(axes) if name.startswith("internal")}


def corners(axes, name: str) -> np.ndarray:
    (patch,) = (each for each in axes.patches if each.get_gid() == name)
    return patch.get_xy()


def tip(axes, name: str) -> np.ndarray:
    return corners(axes, name)[3]


def vermilion_pixels(axes) -> int:
    """How many pixels have the colour of internal arrows."""
    canvas = FigureCanvasAgg(axes.figure)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[..., :3].astype(int)
    return int((np.abs(pixels - VERMILION).max(axis=-1) < 40).sum())


def test_the_internal_arrow_is_seen_when_and_only_when_agents_fight():
    rng = np.random.default_rng(0)
    cases = [FIGHT, AGREE, *rng.normal(size=(3, 2, 3)), [(0, -0.7, 0), (0, 0.7, 0)]]
    fights = []
    for applied in cases:
        split = wrench.decompose(applied, BEAM)
        axes = wrench.plot(applied, BEAM, legend=False, regions=False)
        size = np.linalg.norm(split.internal[:, :2], axis=-1)
        expected = {f"internal force {i + 1}" for i in range(2) if size[i] > 1e-9}
        torque = np.abs(split.internal[:, 2])
        expected |= {f"internal torque {i + 1}" for i in range(2) if torque[i] > 1e-9}
        assert internal(axes) == expected
        fights.append(bool(expected))
    assert {True, False} == set(fights)


def test_the_picture_has_its_colour_when_and_only_when_they_fight():
    assert vermilion_pixels(wrench.plot(FIGHT, BEAM)) > 100
    assert vermilion_pixels(wrench.plot(AGREE, BEAM)) == 0


def test_in_space_too_the_internal_arrow_appears_only_in_a_fight():
    assert internal(wrench.plot(IN_SPACE, SPACE)) >= {"internal force 1", "internal force 2"}
    agreeing = np.array([IN_SPACE[0], IN_SPACE[0]]) * [1, 1, 1, 0, 0, 0]
    assert internal(wrench.plot(agreeing, SPACE)) == set()


def test_in_space_the_arcs_of_one_torque_lie_beside_each_other():
    applied = np.concatenate([IN_SPACE[:, :3], [(0.0, 0.0, 3.0), (0.0, 0.0, -1.0)]], axis=-1)
    axes = wrench.plot(applied, SPACE)
    radii = {
        line.get_label().split()[0]: np.linalg.norm(np.transpose(line.get_data_3d())[0] - SPACE[0])
        for line in axes.lines
        if (line.get_gid() or "").endswith("torque 1")
    }
    assert set(radii) == {"applied", "manipulation", "internal"}
    assert radii["manipulation"] == pytest.approx(1.25 * radii["applied"])
    assert radii["internal"] == pytest.approx(1.5 * radii["applied"])


def test_manipulation_and_internal_arrow_end_where_the_applied_one_does():
    applied = np.array([(6.0, 4.0, 0.0), (-2.0, -3.0, 0.0)])
    axes = wrench.plot(applied, BEAM, method="nonsqueezing")
    split = wrench.decompose(applied, BEAM, method="nonsqueezing")
    scale = np.linalg.norm(tip(axes, "applied force 1") - BEAM[0]) / np.hypot(6.0, 4.0)
    for i in range(2):
        np.testing.assert_allclose(
            tip(axes, f"applied force {i + 1}"), BEAM[i] + scale * applied[i, :2]
        )
        np.testing.assert_allclose(
            tip(axes, f"manipulation force {i + 1}"),
            BEAM[i] + scale * split.manipulation[i, :2],
        )
    np.testing.assert_allclose(tip(axes, "internal force 1"), tip(axes, "applied force 1"))


def test_the_scale_bar_is_as_long_as_it_says():
    axes = wrench.plot(FIGHT, BEAM)
    (bar,) = (line for line in axes.lines if line.get_gid() == "scale of forces")
    words = [text.get_text() for text in axes.texts]
    assert "2 N" in words
    per_newton = (tip(axes, "applied force 1") - BEAM[0])[0] / 3.0
    assert np.ptp(bar.get_xdata()) == pytest.approx(2 * per_newton)


def test_arcs_turn_as_torques_do_and_no_arc_is_drawn_of_rounding():
    axes = wrench.plot(TURNING, BEAM)
    assert {"applied torque 1", "applied torque 2", "internal torque 1"} <= names(axes)
    left, right = (corners(axes, f"applied torque {i}") - BEAM[i - 1] for i in (1, 2))
    assert left[:3, 0].max() < 0.05  # from the top on to the left: counter-clockwise
    assert right[:3, 0].min() > -0.05
    plain = wrench.plot([(1.0, 0.0, 1e-16), (-1.0, 0.0, 0.0)], BEAM)
    assert not {name for name in names(plain) if "torque" in name}


def test_regions_are_shown_unless_they_are_not_wanted():
    assert {"disc of eq. 9 1", "what is feasible 2"} <= names(wrench.plot(FIGHT, BEAM))
    without = names(wrench.plot(FIGHT, BEAM, regions=False))
    assert not {name for name in without if "disc" in name or "feasible" in name}


def test_a_split_of_ones_own_is_drawn_and_judged_in_the_title():
    own = np.array([(0.5, 0.0, 0.0), (-0.5, 0.0, 0.0)])
    axes = wrench.plot(FIGHT, BEAM, internal=own)
    assert axes.get_title() == "own split: γ = 0.25, F_I = 0.5 N, T_I = 0 N·m"
    assert wrench.plot(FIGHT, BEAM, title="mine").get_title() == "mine"


def test_a_decomposition_made_before_is_drawn_with_its_own_weights():
    applied = np.array([(0.5, -2.0, 1.0), (1.0, 2.0, -3.0)])
    split = wrench.decompose(applied, BEAM, torque_weight=0.1)
    axes = wrench.plot(applied, BEAM, decomposition=split)
    assert f"γ = {float(split.relative_cost):.3g}" in axes.get_title()
    assert f"F_I = {float(split.internal_force_level):.3g} N" in axes.get_title()
    again = wrench.plot(applied, BEAM, decomposition=split, torque_weight=0.1)
    assert again.get_title() == axes.get_title()


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_the_title_tells_torques_of_objects_of_any_size(size):
    own = np.array([(0.0, 0.0, size), (0.0, 0.0, -size)])
    axes = wrench.plot(own + FIGHT, size * BEAM, internal=own)
    assert axes.get_title().endswith(f"F_I = 0 N, T_I = {size:.3g} N·m")


@pytest.mark.parametrize("weight", [{"torque_weight": 0.5}, {"include_induced": True}])
def test_other_weights_beside_a_decomposition_are_refused(weight):
    split = wrench.decompose(FIGHT, BEAM, torque_weight=0.1)
    (name,) = weight
    with pytest.raises(InvalidInput, match=f"{name} must be left out beside a decomposition"):
        wrench.plot(FIGHT, BEAM, decomposition=split, **weight)


def test_the_legend_names_what_is_drawn_and_nothing_else():
    def words(axes):
        return {text.get_text() for text in axes.get_legend().get_texts()}

    assert "internal h_I" in words(wrench.plot(FIGHT, BEAM))
    assert "internal h_I" not in words(wrench.plot(AGREE, BEAM))
    assert wrench.plot(FIGHT, BEAM, legend=False).get_legend() is None


def test_it_draws_on_axes_that_are_given_with_equal_scales():
    given = Figure().add_subplot()
    axes = wrench.plot(TURNING, BEAM, ax=given, outline=[(-1, -0.1), (1, -0.1), (1, 0.1)])
    assert axes is given
    assert axes.get_aspect() == 1.0
    assert "object" in names(axes)


def test_axes_that_share_their_limits_with_others_are_drawn_with_equal_scales_too():
    figure = Figure()
    axes = figure.subplots(1, 2, sharex=True, sharey=True)[0]
    wrench.plot(FIGHT, BEAM, ax=axes)
    FigureCanvasAgg(figure).draw()
    box = axes.get_window_extent()
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert box.width / (right - left) == pytest.approx(box.height / (high - low), rel=1e-3)


@pytest.mark.parametrize("size", [0.05, 1.0, 40.0])
def test_in_space_all_of_it_lies_within_axes_of_its_size_and_equal_scales(size):
    axes = wrench.plot(IN_SPACE, size * SPACE, regions=False)
    limits = np.array([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()]).T
    assert (limits[0] < (size * SPACE).min(axis=0)).all()
    assert (limits[1] > (size * SPACE).max(axis=0)).all()
    lengths = np.diff(limits, axis=0)[0]
    assert lengths.max() < 4 * size
    np.testing.assert_allclose(lengths / lengths[0], axes._box_aspect / axes._box_aspect[0])


def test_nothing_applied_is_a_picture_of_the_grips_alone():
    for applied, grips in ((np.zeros((2, 3)), BEAM), (np.zeros((3, 6)), np.eye(3))):
        axes = wrench.plot(applied, grips)
        assert axes.get_title() == "optimal: γ = 0, F_I = 0 N, T_I = 0 N·m"
        assert "grips" in names(axes)
        assert not {name for name in names(axes) if "force" in name or "torque" in name}


@pytest.mark.parametrize("scale", [1e-320, 1e-30, 1e30])
def test_forces_of_any_size_are_drawn_or_left_out(scale):
    axes = wrench.plot(scale * FIGHT, BEAM)
    assert np.isfinite([axes.get_xlim(), axes.get_ylim()]).all()
    assert ("internal force 1" in names(axes)) == (scale > 1e-300)


def test_grips_in_the_middle_and_one_effector_alone_are_drawn():
    walker = wrench.plot([(3.0, 0.0, 0.0), (-1.0, 0.0, 2.0)], [(-0.5, 0.0), (0.0, 0.0)])
    assert {"internal force 1", "applied torque 2", "number 2"} <= names(walker)
    alone = names(wrench.plot([(1.0, 2.0, 0.5)], [(0.3, 0.0)]))
    assert {"manipulation force 1", "disc of eq. 9 1"} <= alone
    assert not {name for name in alone if "internal" in name}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"applied": [FIGHT, AGREE]}, r"applied must be of one sample.*applied\[0\]"),
        ({"grips": [BEAM, BEAM]}, r"grips must be of one sample"),
        ({"applied": 1e200 * FIGHT}, "applied must be at most 1e"),
        ({"internal": FIGHT, "method": "net_force"}, "only one of internal, decomposition and"),
        ({"internal": [FIGHT, FIGHT]}, "internal must be of shape"),
        ({"decomposition": wrench.decompose(AGREE, BEAM)}, "decomposition must be of the applied"),
        ({"outline": [(0, 0), (1, 1)]}, "outline must be of shape"),
        ({"ax": Figure().add_subplot(projection="3d")}, "ax must be planar axes"),
        ({"ax": Figure().add_subplot(projection="polar")}, "ax must be planar axes"),
        ({"ax": Figure()}, "ax must be planar axes.*got Figure"),
        ({"internal": 1e200 * FIGHT}, "internal must be at most 1e"),
        ({"outline": [(0, 0), (1e200, 0), (0, 1)]}, "outline must be at most 1e"),
        ({"decomposition": FIGHT}, "decomposition must be what decompose returned"),
    ],
)
def test_what_makes_no_picture_is_refused_by_name(given, message):
    with pytest.raises(InvalidInput, match=message):
        wrench.plot(**{"applied": FIGHT, "grips": BEAM, **given})


def test_in_space_planar_axes_are_refused():
    with pytest.raises(InvalidInput, match="ax must be three-dimensional axes"):
        wrench.plot(IN_SPACE, SPACE, ax=Figure().add_subplot())


def test_without_matplotlib_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingExtra, match=r"coopenv\[plot\]"):
        wrench.plot(FIGHT, BEAM)
