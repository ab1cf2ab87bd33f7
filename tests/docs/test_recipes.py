"""Recipes for makers' files: what their layouts read is the trial that was recorded."""

import re

import numpy as np
import pytest

from coopenv.logs import Layout, read
from tests.docs.snippets import ROOT, snippets
from tests.logs import cases, makers

PAGE = ROOT / "docs" / "recipes.md"
TEXT = PAGE.read_text(encoding="utf-8")
LAYOUTS = {each.file.removesuffix(".toml"): each.code for each in snippets(PAGE) if each.file}
FILES = dict(re.findall(r"coopenv decompose (\w+)/(\S+) --layout", TEXT))
NEEDS = {"vicon_c3d": "c3d", "ros": "rosbags", "matlab73": "h5py"}
CLOSE = {"jr3": 0.02, "vicon": 1e-4, "onrobot": 1e-4}  # [N, N·m] a count, or digits of a text
LATE = 0.0025  # [m, 1] the pose of the bag is recorded at half the rate, and joined on lines


@pytest.mark.parametrize("maker", makers.MAKERS)
def test_the_layout_of_a_recipe_reads_the_makers_file(maker, tmp_path):
    if maker in NEEDS:
        pytest.importorskip(NEEDS[maker])
    (tmp_path / maker).mkdir()
    makers.MAKERS[maker](tmp_path / maker)
    (tmp_path / "said.toml").write_text(LAYOUTS.get(maker) or LAYOUTS["matlab"], encoding="utf-8")
    seen = read(tmp_path / maker / FILES[maker], Layout.load(tmp_path / "said.toml"))
    rows = len(seen)
    assert rows >= makers.ROWS - (maker == "vicon_c3d")  # markers end a sample before
    assert seen.good.all()
    assert seen.time is not None
    np.testing.assert_allclose(seen.time - seen.time[0], np.arange(rows) / makers.RATE, atol=1e-6)
    wanted = cases.wrench(dict(makers.trial()))[:rows]
    np.testing.assert_allclose(seen.applied, wanted, rtol=0, atol=CLOSE.get(maker, 1e-5))
    if seen.position is None or seen.orientation is None:
        assert maker in ("ati_daq", "ati_net", "jr3", "onrobot", "vicon_c3d")
        return
    position, quaternion = makers.y_up() if maker == "optitrack" else makers.pose()
    np.testing.assert_allclose(seen.position, position, rtol=0, atol=LATE)
    turned = np.roll(quaternion, 1, axis=-1)
    same = np.abs((seen.orientation * turned).sum(axis=-1))
    np.testing.assert_allclose(same, 1.0, rtol=0, atol=LATE**2)


def test_a_sensor_on_its_side_is_turned_into_the_plane(tmp_path):
    makers.MAKERS["ati_daq"](tmp_path)
    (tmp_path / "said.toml").write_text(LAYOUTS["on_its_side"], encoding="utf-8")
    seen = read(tmp_path / "left.csv", Layout.load(tmp_path / "said.toml"))
    fx, _, fz, _, ty, _ = cases.wrench(dict(makers.trial()))[:, 0].T
    up = np.stack([fx - 0.5, -(fz - 1.0), ty - 0.02], axis=-1)  # x y z is the object's x z -y
    np.testing.assert_allclose(seen.applied[:, 0], up, rtol=0, atol=1e-5)
    assert re.match(r"sensor 1: [\d.]+ N and [\d.]+ N·m out of the plane left out", seen.done[-1])


def test_every_maker_has_a_command():
    assert set(FILES) == set(makers.MAKERS)
    assert set(LAYOUTS) == {*makers.MAKERS, "on_its_side"} - {"matlab73"}
    for name in ("ATI", "JR3", "OnRobot", "OptiTrack", "Vicon", "ROS", "MATLAB"):
        assert re.search(rf"^## .*{name}", TEXT, flags=re.MULTILINE)
