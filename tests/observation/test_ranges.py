"""Range readings: against pymunk's own ray caster, brute force, and what can be said by hand."""

import numpy as np
import pymunk
import pytest

from coopenv import BLOCKS, Body, Box, Scene, Transport
from coopenv.conditions import Room
from coopenv.errors import InvalidInput, UnknownName
from coopenv.observation import ranges
from coopenv.observation.ranges import RangeReading, read_ranges

FAR = 100.0  # [m]; more than any room here measures
EMPTY = Scene(size=(8.0, 6.0))


def cluttered(seed, count):
    """A random room with ``count`` boxes, which may overlap and stick into the walls."""
    generator = np.random.default_rng(seed)
    size = generator.uniform(4, 9, 2)
    boxes = tuple(
        Box(
            center=tuple(generator.uniform(-size / 2, size / 2)),
            size=tuple(generator.uniform(0.05, 1.5, 2)),
            angle=generator.uniform(-4, 4),
        )
        for _ in range(count)
    )
    return Scene(size=tuple(size), obstacles=boxes)


def free_pose(scene, generator):
    """A pose whose centre of mass is off everything."""
    while True:
        x, y, angle = generator.uniform(-1, 1, 3) * (*np.array(scene.size) / 2, np.pi)
        if scene.is_free(x, y):
            return x, y, angle


def readings(scenes, poses, **keywords):
    """What a block of ranges reads in 64 bits, and the core that it was read of."""
    body = keywords.pop("body", Body())
    core = Transport(num_worlds=len(scenes), scene=scenes, body=body)
    core.reset(seed=0, pose=poses)
    assert core.transition is not None
    read = ranges(**keywords).read
    assert read is not None
    return read(core.transition), core


def pymunk_room(scene):
    """The same walls and boxes in a space of pymunk, built here."""
    space = pymunk.Space()
    for solid in scene.solids():
        space.add(pymunk.Poly(space.static_body, solid.tolist()))
    return space


def instrument(core, world, agent, where="grip"):
    """Place and heading [rad] of an agent's frame in the world, from their definitions."""
    x, y, angle = core.transition.next_state.pose[world]
    grip = core.team.grips[world, agent]
    c, s = np.cos(angle), np.sin(angle)
    place = np.array([x, y])
    if where == "grip":
        place = place + np.array([[c, -s], [s, c]]) @ grip
    return place, angle + (np.arctan2(-grip[1], -grip[0]) if grip.any() else 0.0)


def is_inside(space, place):
    nearest = space.point_query_nearest(tuple(place), FAR, pymunk.ShapeFilter())
    assert nearest is not None
    return nearest.distance <= 0


@pytest.mark.parametrize("where", ["grip", "centre"])
def test_rays_and_nearest_points_are_those_of_an_independent_ray_caster(where):
    generator = np.random.default_rng(1)
    scenes = [cluttered(seed, seed % 7) for seed in range(60)]
    poses = np.array([free_pose(scene, generator) for scene in scenes])
    body = Body(grips=((-0.9, 0.1), (0.3, 0.2), (0.9, 0.0)))
    seen, core = readings(scenes, poses, num_rays=17, reach=FAR, where=where, body=body)
    outside = blocked = 0
    for k, scene in enumerate(scenes):
        space = pymunk_room(scene)
        for i in range(3):
            place, heading = instrument(core, k, i, where)
            if is_inside(space, place):
                blocked += 1
                np.testing.assert_array_equal(seen[k, i], 0.0)
                continue
            for j in range(17):
                angle = heading + 2 * np.pi * j / 17
                end = place + FAR * np.array([np.cos(angle), np.sin(angle)])
                hit = space.segment_query_first(tuple(place), tuple(end), 0.0, pymunk.ShapeFilter())
                assert hit is not None
                assert seen[k, i, j] == pytest.approx(FAR * hit.alpha, abs=1e-9)
                outside += 1
            nearest = space.point_query_nearest(tuple(place), FAR, pymunk.ShapeFilter())
            assert nearest is not None
            assert seen[k, i, -1] == pytest.approx(nearest.distance, abs=1e-9)
            c, s = np.cos(heading), np.sin(heading)
            way = np.array([[c, -s], [s, c]]) @ seen[k, i, -3:-1]
            np.testing.assert_allclose(place + way, nearest.point, atol=1e-9)
    assert outside > 1500  # and both cases came up
    assert where == "centre" or blocked > 5


def test_no_point_of_any_solid_is_nearer_than_the_nearest():
    generator = np.random.default_rng(2)
    scenes = [cluttered(100 + seed, 4) for seed in range(20)]
    poses = np.array([free_pose(scene, generator) for scene in scenes])
    seen, core = readings(scenes, poses, reach=FAR, where="centre")
    for k, scene in enumerate(scenes):
        inside = np.linspace(0, 1, 60)
        along, across = np.meshgrid(inside, inside)
        points = [
            solid[0]
            + along[..., None] * (solid[1] - solid[0])
            + across[..., None] * (solid[3] - solid[0])
            for solid in scene.solids()
        ]
        place, _ = instrument(core, k, 0, "centre")
        sampled = min(np.linalg.norm(point - place, axis=-1).min() for point in points)
        assert seen[k, 0, -1] <= sampled + 1e-12
        assert seen[k, 0, -1] == pytest.approx(sampled, abs=0.25)  # [m] the grid's spacing


def test_by_hand_in_an_empty_room():
    # At (1, 0.5) along x, agent 0 looks along the world's x: right, up, left, down.
    seen, _ = readings([EMPTY], (1.0, 0.5, 0.0), num_rays=4, reach=FAR, where="centre")
    np.testing.assert_allclose(seen[0, 0], [3.0, 2.5, 5.0, 3.5, 0.0, 2.5, 2.5], atol=1e-12)
    np.testing.assert_allclose(seen[0, 1], [5.0, 3.5, 3.0, 2.5, 0.0, -2.5, 2.5], atol=1e-12)


def test_a_ray_along_the_face_of_a_box_and_a_gap_between_two():
    boxes = (Box(center=(2.0, 1.0), size=(1.0, 1.0)), Box(center=(2.0, -1.0), size=(1.0, 1.0)))
    scene = Scene(size=(8.0, 6.0), obstacles=boxes)
    poses = [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 1.5 + 1e-9, 0.0)]
    seen, _ = readings([scene] * 3, poses, num_rays=1, reach=FAR, where="centre")
    np.testing.assert_allclose(seen[:, 0, 0], [4.0, 1.5, 4.0], atol=1e-12)


@pytest.mark.parametrize(
    ("keywords", "angles"),
    [
        ({"num_rays": 4}, [0, np.pi / 2, np.pi, -np.pi / 2]),
        ({"num_rays": 3, "field_of_view": np.pi}, [-np.pi / 2, 0, np.pi / 2]),
        ({"num_rays": 2, "field_of_view": 0.4, "heading": 1.0}, [0.8, 1.2]),
        ({"num_rays": 1, "field_of_view": 0.4, "heading": np.pi}, [np.pi]),
        ({"num_rays": 2, "heading": 0.3}, [0.3, 0.3 + np.pi]),
    ],
)
def test_rays_are_spread_over_the_field_of_view(keywords, angles):
    read = ranges(**keywords).read
    wanted = np.stack([np.cos(angles), np.sin(angles)])
    np.testing.assert_allclose(read.rays, wanted, atol=1e-15)  # pyright: ignore
    with pytest.raises(ValueError, match="read-only"):  # readings of all worlds share them
        read.rays[0] = 0.0  # pyright: ignore


def test_nothing_is_seen_beyond_the_reach():
    seen, _ = readings([EMPTY], (1.0, 0.5, 0.0), num_rays=4, reach=2.0, where="centre")
    np.testing.assert_allclose(seen[0, 0], [2.0, 2.0, 2.0, 2.0, 0.0, 2.0, 2.0], atol=1e-12)


def test_a_nearest_point_out_of_reach_is_still_seen_in_its_direction():
    box = Box(center=(1.0, 1.0), size=(0.2, 0.2), angle=np.pi / 4)
    scene = Scene(size=(9.0, 9.0), obstacles=(box,))
    seen, _ = readings([scene], (0.0, 0.0, 0.0), reach=0.5, where="centre")
    assert seen[0, 0, -1] == 0.5
    assert np.linalg.norm(seen[0, 0, -3:-1]) == pytest.approx(0.5)
    near = np.sqrt(2) - 0.1  # the face across the diagonal
    whole, _ = readings([scene], (0.0, 0.0, 0.0), reach=FAR, where="centre")
    np.testing.assert_allclose(whole[0, 0, -3:], [near / 2**0.5, near / 2**0.5, near])
    np.testing.assert_allclose(seen[0, 0, -3:-1], 0.5 / near * whole[0, 0, -3:-1])


@pytest.mark.parametrize("spot", [(2.1, 0.05), (3.5, 0.0), (2.0, -4.0)])
def test_from_inside_a_box_or_a_wall_everything_reads_nothing(spot):
    # No reset puts an agent there, but contact may push its grip in.
    box = Box(center=(2.0, 0.0), size=(0.5, 0.5), angle=0.2)
    room = Room.of([Scene(size=(6.0, 6.0), obstacles=(box,))], 1)
    seen = read_ranges(
        np.array([[*spot, 0.3]]),
        np.zeros((1, 1, 2)),
        np.array([[[1.0, 0.0]]]),
        (room.size, room.boxes, room.axes, room.count),
        RangeReading(num_rays=2).rays,
        3.0,
    )
    np.testing.assert_array_equal(seen, np.zeros((1, 1, 5)))


def test_partners_readings_are_those_of_each_other_agent_in_turn():
    body = Body(grips=((-0.9, 0.0), (0.3, 0.05), (0.9, -0.05)))
    observe = ("partner_obstacles", "obstacles")
    core = Transport(num_worlds=2, body=body, observe=observe)
    obs, _ = core.reset(seed=0)
    own, others = (obs[..., core.observation.blocks[name]] for name in observe[::-1])
    for i in range(3):
        wanted = np.concatenate([own[:, (i + 1) % 3], own[:, (i + 2) % 3]], axis=-1)
        np.testing.assert_array_equal(others[:, i], wanted)
    assert core.observation.low[core.observation.blocks["partner_obstacles"]].tolist() == (
        2 * ([0.0] * 12 + [-3.0, -3.0, 0.0])
    )


def test_readings_follow_the_obstacles_of_the_episode_and_move_with_the_agent():
    core = Transport(num_worlds=2, scene=cluttered(5, 3), observe=("obstacles",), horizon=50)
    core.reset(seed=0)
    generator = np.random.default_rng(0)
    for _ in range(20):
        obs, *_ = core.step(generator.uniform(-1, 1, (2, 2, 3)))
        assert core.transition is not None
        fresh = BLOCKS["obstacles"].read
        assert fresh is not None
        np.testing.assert_array_equal(obs, fresh(core.transition).astype(np.float32))


def test_two_blocks_of_ranges_go_side_by_side_under_names_of_their_own():
    coarse = ranges(num_rays=3, name="coarse")
    core = Transport(observe=("obstacles", coarse))
    assert {name: part.stop - part.start for name, part in core.observation.blocks.items()} == {
        "obstacles": 15,
        "coarse": 6,
    }
    assert ranges() == BLOCKS["obstacles"]
    assert ranges(whose="partners") == BLOCKS["partner_obstacles"]
    assert coarse == ranges(num_rays=3, name="coarse") != ranges(num_rays=4, name="coarse")


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        ({"num_rays": 0}, "num_rays must be a whole number of at least 1"),
        ({"num_rays": 2.5}, "num_rays must be a whole number"),
        ({"reach": 0.0}, "reach must be positive"),
        ({"reach": np.inf}, "reach must be finite"),
        ({"field_of_view": 0.0}, "field_of_view must be positive"),
        ({"field_of_view": 360.0}, "field_of_view must be at most 2π"),
        ({"heading": "left"}, "heading must be a number"),
        ({"where": "grips"}, "where must be .*did you mean 'grip'"),
        ({"whose": "all"}, "whose must be one of the known names"),
    ],
)
def test_a_sensor_that_cannot_be_is_refused_by_the_name_of_its_parameter(keywords, said):
    with pytest.raises((InvalidInput, UnknownName), match=said):
        ranges(**keywords)
