"""What policies are called in a table."""

import pytest

from coopenv.cli.policies import labels


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["random", "runs/ppo/policy.zip"], ["random", "ppo"]),
        (["a/ppo/policy.zip", "b/ppo/policy.zip"], ["a/ppo/policy.zip", "b/ppo/policy.zip"]),
        (["a/random/policy.zip", "random"], ["a/random/policy.zip", "random"]),
        (["policy.zip", "best.zip"], ["policy.zip", "best.zip"]),
    ],
    ids=["folder", "folders of one name", "a folder called random", "no folder"],
)
def test_a_policy_is_called_as_its_folder_where_no_other_is(names, expected):
    assert labels(names) == expected
