"""The named blocks of an observation: what each is, and what is read for it."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.geometry.frames import rotated_back
from coopenv.observation.block import Block, EachOther
from coopenv.observation.energy import ENERGY
from coopenv.observation.near import NEAR_GOAL
from coopenv.observation.ranges import ranges
from coopenv.observation.senses import SENSES
from coopenv.observation.team import TEAM
from coopenv.observation.view import VIEW, VIEW_PARTS
from coopenv.transition import Transition


def _time_left(transition: Transition) -> FloatArray:
    left = 1 - transition.next_state.time / (transition.horizon * transition.dt)
    return transition.per_agent(left)[..., None]


def _known(transition: Transition) -> FloatArray:
    return transition.conditions.told.astype(np.float64)


# What the block "body" has of the body itself, whatever else episodes draw.
OF_BODY = ("mass", "inertia", "linear_drag", "angular_drag", "friction", "length")


def _body(transition: Transition) -> FloatArray:
    """What is carried and by whom, for critics that may know more than actors.

    Parameters of the body, then grip and limits of each agent, its own first:
    ``(world, agent, 9 + 4 (n − 1))``. As in `coopenv.conditions.Conditions.parameters`, but the
    grips seen from the centre of mass along the agent's own axes. There its own has no y.
    """
    named, frame = transition.conditions.parameters(), transition.team.frame
    num_worlds, num_agents = frame.shape[:2]
    order = (np.arange(num_agents)[:, None] + np.arange(num_agents)) % num_agents
    x, y = np.moveaxis(named["grips"][:, order], -1, 0)  # (world, agent, other)
    seen = rotated_back(frame[..., 0, None], frame[..., 1, None], x, y)
    limits = named["force_limit"][:, order], named["torque_limit"][:, order]
    team = np.stack([*seen, *limits], axis=-1)
    body = np.stack([named[name] for name in OF_BODY], axis=-1)
    every = body[:, None].repeat(num_agents, axis=1)
    flat = team.reshape(num_worlds, num_agents, 4 * num_agents)  # also of no world
    return np.concatenate([every, flat[..., :1], flat[..., 2:]], axis=-1)


BLOCKS: dict[str, Block] = {
    block.name: block
    for block in (
        *VIEW,
        NEAR_GOAL,
        Block(
            name="known",
            size=2,
            describe="whether this agent is told the goal's place, and its angle; else they read 0",
            read=_known,
            low=0.0,
            high=1.0,
            unit="1",
        ),
        Block(
            name="body",
            size=EachOther(4, own=9),
            describe="mass, inertia, linear drag, angular drag, friction, length; then of each "
            "agent, its own first, x and y of the grip from the centre of mass (its own: x), force "
            "limit, torque limit",
            read=_body,
            unit="kg, kg·m², N·s/m, N·m·s, 1, m, m, N, N·m, then m, m, N, N·m",
            frame="agent",
        ),
        Block(
            name="time",
            size=1,
            describe="what is left of the episode, from 1 down to 0",
            read=_time_left,
            low=0.0,
            high=1.0,
            unit="1",
        ),
        ranges(),
        ranges(whose="partners"),
        *SENSES,
        *ENERGY,
        *TEAM,
    )
}

DEFAULT_BLOCKS = VIEW_PARTS
_OWN = ("goal", "known", "twist", "own_wrench", "obstacles")
SENSING: dict[str, tuple[str, ...]] = {  # the words for it that `TransportConfig` takes
    "own": _OWN,  # what an agent feels and sees by itself
    "shared": (  # what its partners feel and see too, and what takes all wrenches to know
        *_OWN,
        "partner_wrench",
        "partner_obstacles",
        "own_internal",
        "partner_internal",
        "load_share",
        "relative_cost",
    ),
}
FELT = tuple(block.name for block in SENSES)  # what `sensed` adds where hands can feel


def sensed(word: str, *, by_hands: bool) -> tuple[str, ...]:
    """The blocks that a word of `SENSING` stands for; ``by_hands``: where these act, with `FELT`.

    Elsewhere the words stand for what they always did, so that what was trained or recorded there
    fits: a wrench that is held is felt as it is given, and the grip's motion follows from the
    object's.
    """
    own, rest = SENSING[word][: len(_OWN)], SENSING[word][len(_OWN) :]
    return (*own, *FELT, *rest) if by_hands else SENSING[word]
