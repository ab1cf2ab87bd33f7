"""Where users import from: what README, docs, examples and every ``__all__`` have named."""

from importlib import import_module

import gymnasium
import pytest

import coopenv  # noqa: F401 - registers the ids

VIEWS = ("env", "parallel_env", "single_env", "vector_env")

NAMES: dict[str, tuple[str, ...]] = {
    "coopenv": (
        "Actuators", "BLOCKS", "Block", "Body", "Box", "DoorwayTask", "Episode", "Hands",
        "LiftTask", "PUSHES",
        "Partner", "Player", "Ranges", "Reference", "Scene", "Sensor", "Snapshot", "State", "Task",
        "TrackingTask", "Transition", "Transport", "TransportConfig", "TransportTask",
        "WalkerAvoidTask", "WalkerTurnTask", "__version__", "beam_doorway_v0", "beam_lift_v0",
        "beam_tracking_v0", "beam_transport_v0", "register", "rewards",
        "walker_avoid_v0", "walker_turn_v0", "wrench",
    ),
    "coopenv.agents": ("load",),
    "coopenv.agents.controllers": (
        "Gains", "ImpedanceController", "RandomPolicy", "approach", "wrapped",
    ),
    "coopenv.agents.experiments": (
        "Experiment", "Outcome", "Results", "Search", "conduct", "load", "sweep", "write_report",
    ),
    "coopenv.agents.partners": (
        "DEFAULT", "PARTNERS", "Follower", "Impedance", "Kind", "Lagging", "Leader",
        "LearnedPartner", "LoadSharing", "Noisy", "Person", "PolicyPartner", "Population",
        "Stubborn", "Switching", "find_partner", "partner_of",
    ),
    "coopenv.agents.pretrained": ("file_of", "load", "names", "read", "row_of"),
    "coopenv.agents.sb3": (
        "FallingRate", "SB3Policy", "Scaled", "TransportVecEnv", "feature_scale", "make_vec_env",
        "recommended",
    ),
    "coopenv.agents.settings": ("EnvironmentChoice", "TrainConfig"),
    "coopenv.agents.studies.people": ("People",),
    "coopenv.agents.torchrl": ("TransportTorchEnv", "feature_scale", "make_env"),
    "coopenv.agents.trained": ("NOTES", "PlainPolicy", "read_notes"),
    "coopenv.agents.train": ("EnvironmentChoice", "TrainConfig", "train"),
    "coopenv.arrays": ("FloatArray",),
    "coopenv.beam_doorway_v0": VIEWS,
    "coopenv.beam_lift_v0": VIEWS,
    "coopenv.beam_tracking_v0": VIEWS,
    "coopenv.beam_transport_v0": VIEWS,
    "coopenv.envs": ("TransportEnv", "TransportParallelEnv", "TransportVectorEnv"),
    "coopenv.errors": (
        "BodyLost", "CoopenvError", "CoreInUse", "InvalidInput", "MissingExtra", "MissingPackage",
        "ResetNeeded", "SolverError", "UnknownName",
    ),
    "coopenv.logs": (
        "Analysis", "Checked", "Layout", "Recording", "Summary", "analyse", "check_file",
        "decompose_file", "read",
    ),
    "coopenv.observation": ("BLOCKS", "ranges"),
    "coopenv.render": ("Renderer", "mosaic", "save_film", "save_gif", "save_png"),
    "coopenv.rewards": (
        "COSTS", "PRESETS", "ActionRate", "Contact", "Effort", "InternalForce", "InternalTorque",
        "LoadShare", "Potential", "PotentialShaping", "Progress", "RelativeCost", "RewardSum",
        "Success", "Term", "TimeCost", "TrackingError", "find_cost", "find_reward", "recompute",
    ),
    "coopenv.tasks": (
        "TASKS", "DoorwayTask", "Episode", "FurnishedTask", "GuidedTask", "JudgedTask",
        "MarkedTask", "MovingTask", "Pose", "PoseTask", "Reference", "RollingTask", "SensedTask",
        "Task", "TrackingTask", "TransportTask", "WalkerAvoidTask", "WalkerTurnTask", "WayTask",
    ),
    "coopenv.tasks.base": (
        "Episode", "FurnishedTask", "GuidedTask", "JudgedTask", "MarkedTask", "MovingTask", "Pose",
        "SensedTask", "Task", "WayTask",
    ),
    "coopenv.transition": ("State", "Transition"),
    "coopenv.walker_avoid_v0": VIEWS,
    "coopenv.walker_turn_v0": VIEWS,
    "coopenv.wrench": (
        "GENERAL_METHODS", "METHODS", "SOLVERS", "Decomposer", "Decomposition", "EnergyShare",
        "LoadShare", "Residuals", "Settings", "WorkResiduals", "allocate", "constraint_violation",
        "cost", "decompose", "energy_share", "grasp_matrix", "induced_torque", "is_plausible",
        "load_share", "object_wrench", "plot", "residuals", "synthesize", "weight_matters",
        "work_residuals",
    ),
}  # fmt: skip

WORDS: dict[str, tuple[str, ...]] = {  # registry -> what users pass as text
    "coopenv.BLOCKS": (
        "acceleration", "body", "energy_share", "felt_wrench", "goal", "internal_power", "known",
        "load_share", "near_goal", "obstacles", "own_internal", "own_motion", "own_wrench",
        "partner_internal", "partner_obstacles", "partner_wrench", "relative_cost",
        "stored_energy", "stretch", "time", "twist",
    ),
    "coopenv.agents.partners.PARTNERS": (
        "follower", "impedance", "lagging", "leader", "load_sharing", "noisy", "population",
        "stubborn", "switching",
    ),
    "coopenv.PUSHES": ("axes", "compass", "fine", "grid"),
    "coopenv.rewards.COSTS": ("contact", "internal_power", "squeeze", "stored_energy", "waste"),
    "coopenv.rewards.PRESETS": ("balanced", "harmony", "sparse", "task", "tracking"),
    "coopenv.wrench.METHODS": (
        "max_internal", "moore_penrose", "net_force", "nonsqueezing", "one_dimensional", "optimal",
        "parametrized", "point_mass", "prioritized_torque", "virtual_linkage",
    ),
    "coopenv.wrench.SOLVERS": ("conic", "pair", "structured"),
}  # fmt: skip

IDS = ("BeamDoorway", "BeamLift", "BeamTracking", "BeamTransport", "WalkerAvoid", "WalkerTurn")


@pytest.mark.parametrize(
    ("module", "name"), [(module, name) for module, names in NAMES.items() for name in names]
)
def test_a_public_name_imports_from_where_users_had_it(module, name):
    assert hasattr(import_module(module), name)


@pytest.mark.parametrize(
    ("registry", "word"), [(registry, word) for registry, words in WORDS.items() for word in words]
)
def test_a_word_that_users_pass_is_still_known(registry, word):
    module, _, name = registry.rpartition(".")
    assert word in getattr(import_module(module), name)


@pytest.mark.parametrize("name", IDS)
def test_an_id_is_still_registered(name):
    assert f"coopenv/{name}-v0" in gymnasium.registry
