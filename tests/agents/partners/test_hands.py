"""What partners' compiled step is told by order stands in the order of its names."""

import ast
import inspect
import textwrap
from dataclasses import fields

import numpy as np

from coopenv import Transport, TransportConfig
from coopenv.agents.controllers import guidance
from coopenv.agents.controllers.guidance import NUM_GAINS, Gains, gains_row
from coopenv.agents.partners import Impedance, hands, person
from coopenv.agents.partners.hands import Carried, Held, Mind, Seen


def test_the_step_takes_its_tuples_apart_in_the_order_of_their_fields():
    step = ast.parse(textwrap.dedent(inspect.getsource(hands.act.py_func)))
    found = {
        node.value.id: ast.unparse(node.targets[0]).strip("()").split(", ")
        for node in ast.walk(step)
        if isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Tuple)
        and isinstance(node.value, ast.Name)
    }
    for name, kind in (("mind", Mind), ("seen", Seen), ("carried", Carried), ("team", Held)):
        assert tuple(found[name]) == kind._fields


def test_a_partner_gives_the_step_what_the_fields_say(monkeypatch):
    given = []

    def act(*arguments):
        given.append(arguments)
        return hands.act(*arguments)

    monkeypatch.setattr(person, "act", act)
    core = Transport(num_worlds=2, config=TransportConfig(partner=Impedance()))
    core.reset(seed=0)
    core.step(np.ones((2, 1, 3)))  # so that what was differs from what is
    before = core.transition
    assert before is not None
    core.step(np.zeros((2, 1, 3)))
    mind, seen, carried, team, dt = given[-1]
    assert all(type(each) is tuple for each in given[-1][:4])
    mind, seen, carried, team = Mind(*mind), Seen(*seen), Carried(*carried), Held(*team)

    state, conditions = before.next_state, before.conditions
    assert mind.traits.shape[0] == 2
    assert (mind.steps == 2).all()
    for name in ("pose", "twist", "goal"):
        assert getattr(seen, name) is getattr(state, name)
    assert seen.twist_before is before.state.twist
    assert seen.applied is before.applied
    for name in ("mass", "inertia", "linear_drag", "angular_drag", "outline"):
        assert getattr(carried, name) is getattr(conditions.load, name)
    assert carried.reach.shape == (2,)
    assert carried.room is conditions.room.size
    for name in ("grips", "frame", "limits"):
        assert getattr(team, name) is getattr(before.team, name)
    assert team.allocation.shape == (2, 2, 3, 3)
    assert team.driven.tolist() == [1]
    assert dt == before.dt


def test_gains_have_their_names_places():
    row = gains_row(Gains())
    assert len(row) == len(fields(Gains)) == NUM_GAINS
    places = [getattr(guidance, entry.name.upper()) for entry in fields(Gains)]
    assert places == list(range(NUM_GAINS))
