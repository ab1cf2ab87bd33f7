"""The rules of the house: what may import what, and what a folder holds."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.sources import (
    AROUND,
    ROOT,
    arrows,
    circles,
    inside,
    modules,
    place,
    syntax,
)

NODES = Path("agents/experiments/nodes")
MOST_FILES = 17  # in a folder, its face included; modules of environments are not counted
COMPILERS = {"cfunc", "generated_jit", "guvectorize", "jit", "njit", "vectorize"}
# Public though their names are not
PYTHONS_OWN = {"_asdict", "_exit", "_fields", "_getframe", "_replace"}
LINKED = ("coopenv.agents", "coopenv.rewards")


def lines(found: list[str]) -> str:
    return "\n".join(["", *found])


def test_imports_go_in_no_circle():
    found = circles(with_types=False)
    assert not found, lines([" ↔ ".join(circle) for circle in found])


def test_only_a_description_and_its_partner_know_types_of_each_other():
    real = circles(with_types=False)
    found = [circle for circle in circles(with_types=True) if circle not in real]
    assert found == [
        [
            "coopenv.config",
            "coopenv.config.described",
            "coopenv.config.document",
            "coopenv.config.environment",
            "coopenv.config.keywords",
            "coopenv.partner",
        ]
    ]


def test_the_decomposition_needs_no_import_for_types_alone():
    found = [
        place(module, node)
        for module in inside()
        if module.startswith("coopenv.wrench")
        for node in ast.walk(syntax(module))
        if "TYPE_CHECKING" in (getattr(node, field, "") for field in ("id", "attr", "name"))
    ]
    assert not found, lines(found)


def test_the_decomposition_knows_neither_simulator_nor_learning():
    known = (
        "coopenv.arrays",
        "coopenv.compiled",
        "coopenv.errors",
        "coopenv.geometry",
        "coopenv.wrench",
    )
    found = [
        f"{place(module, arrow)} {arrow.target}"
        for module in inside()
        if module.startswith("coopenv.wrench")
        for arrow in arrows(module)
        if arrow.target in inside() and not arrow.target.startswith(known)
    ]
    assert not found, lines(found)


def test_no_arrow_is_hidden_from_tools():
    found = [
        place(module, node)
        for module in inside()
        for node in ast.walk(syntax(module))
        if isinstance(node, ast.Call)
        and ast.unparse(node.func).split(".")[-1] in ("import_module", "__import__")
        and not isinstance(node.args[0], ast.Name)  # of a user's module that is named at run time
    ]
    assert not found, lines(found)


def test_linked_folders_import_their_own_relatively_and_all_others_absolutely():
    found = []
    for module in modules():
        own = next((folder for folder in LINKED if module.startswith(folder)), None)
        for node in ast.walk(syntax(module)):
            if isinstance(node, ast.ImportFrom):
                by_name = own is not None and (node.module or "").startswith(own)
                if by_name if own else node.level:
                    found.append(place(module, node))
    assert not found, lines(found)


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.endswith("__")


def private_names(module: str) -> Iterator[str]:
    """Where a module takes private names of another folder."""
    folder = modules()[module].parent
    strangers = [
        arrow
        for arrow in arrows(module)
        if arrow.target in modules() and modules()[arrow.target].parent != folder
    ]
    for arrow in strangers:
        for name in filter(is_private, (*arrow.target.split("."), arrow.name)):
            yield f"{place(module, arrow)} {name} of {arrow.target}"
    owners = {arrow.known_as: arrow.target for arrow in strangers if not arrow.name}
    for node in ast.walk(syntax(module)):
        if isinstance(node, ast.Attribute) and is_private(node.attr):
            owner = owners.get(ast.unparse(node.value))
            if owner is not None:
                yield f"{place(module, node)} {node.attr} of {owner}"


@pytest.mark.parametrize("top", ["coopenv", *AROUND])
def test_private_names_stay_in_their_folder(top):
    found = [
        taken
        for module in modules()
        if module.split(".")[0] == top
        for taken in private_names(module)
    ]
    assert not found, lines(found)


def test_objects_are_asked_for_public_names_only():
    """But for numba's cache and pymunk's library, which have no public door."""
    found = [
        f"{place(module, node)} {ast.unparse(node)}"
        for module in modules()
        if not module.startswith(("tests", "coopenv.compiled", "coopenv.physics.shard"))
        for node in ast.walk(syntax(module))
        if isinstance(node, ast.Attribute) and is_private(node.attr)
        if ast.unparse(node.value) not in ("self", "cls") and node.attr not in PYTHONS_OWN
    ]
    assert not found, lines(found)


def test_no_folder_holds_more_files_than_one_looks_through():
    folders = {path.parent for name, path in modules().items() if name.split(".")[0] != "tests"}
    counts = {
        folder: sum(not path.stem.endswith("_v0") for path in folder.glob("*.py"))
        for folder in folders
    }
    found = [
        f"{folder.relative_to(ROOT)}: {count} files, at most {MOST_FILES}"
        for folder, count in counts.items()
        if count > MOST_FILES
    ]
    assert not found, lines(found)


def test_every_folder_of_modules_has_a_face():
    folders = {path.parent for name, path in modules().items() if name.split(".")[0] != "examples"}
    found = [str(each.relative_to(ROOT)) for each in folders if not (each / "__init__.py").exists()]
    assert not found, lines(found)


def names_in(node: ast.AST) -> set[str]:
    return {each.id for each in ast.walk(node) if isinstance(each, ast.Name)}


def beside_names(face: str) -> list[str]:
    """What a folder's face holds beside docstring, imports and constants.

    That of a registry also has functions that look something up in a table, a constant in capitals.
    """
    tables: set[str] = set()
    rest: list[ast.stmt] = []
    for node in syntax(face).body:
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = set().union(*map(names_in, targets))
            if all(name.isupper() or name in ("__all__", "__version__") for name in names):
                tables |= names
                continue
        is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if not is_text and not isinstance(node, ast.Import | ast.ImportFrom):
            rest.append(node)
    functions = {node.name: names_in(node) for node in rest if isinstance(node, ast.FunctionDef)}
    direct = {name for name, used in functions.items() if used & tables}
    lookups = direct | {name for name, used in functions.items() if used & direct}
    return [place(face, node) for node in rest if getattr(node, "name", None) not in lookups]


def test_the_face_of_a_folder_only_hands_names_on():
    faces = [name for name, path in modules().items() if path.name == "__init__.py"]
    faces.remove("coopenv")  # importing it registers the environments
    faces.remove("coopenv.cli")  # where it cannot be imported it says what to install
    found = [beside for face in faces for beside in beside_names(face)]
    assert not found, lines(found)


def test_only_the_kinds_of_compilation_and_what_makes_them_compile():
    found = {
        module
        for module in modules()
        if module.split(".")[0] != "tests"
        for node in ast.walk(syntax(module))
        if isinstance(node, ast.Attribute)
        and node.attr in COMPILERS
        and isinstance(node.value, ast.Name)
        and node.value.id in ("numba", "nb")
    }
    found |= {
        module
        for module in modules()
        if module.split(".")[0] != "tests"
        for arrow in arrows(module)
        if arrow.target.split(".")[0] == "numba" and arrow.name in COMPILERS
    }
    assert found == {f"coopenv.compiled.{name}" for name in ("kinds", "parts", "universal")}


def users_of(tool: str) -> set[str]:
    """Modules of the package that import a tool or a part of it."""
    return {
        module
        for module in inside()
        for arrow in arrows(module)
        if arrow.target.split(".")[0] == tool
    }


def test_only_one_module_knows_the_simulator():
    assert users_of("pymunk") == {"coopenv.physics.shard"}


def folders_of(names: set[str]) -> set[Path]:
    return {modules()[name].parent.relative_to(ROOT) for name in names}


def test_only_the_renderer_knows_pygame():
    assert folders_of(users_of("pygame")) == {Path("coopenv/render")}


@pytest.mark.parametrize(
    "tool", ["torch", "torchrl", "stable_baselines3", "sb3_contrib", "tensorboard"]
)
def test_only_agents_know_what_trains_them(tool):
    assert folders_of(users_of(tool)) <= {
        Path("agents"),
        Path("agents/algorithms"),
        Path("agents/learned"),
        Path("agents/rllib"),
        Path("agents/torchrl"),
        Path("agents/training"),
    }


def test_one_folder_and_one_file_know_ray():
    files = {modules()[name].relative_to(ROOT) for name in users_of("ray")}
    assert {path.parent for path in files} == {Path("agents/rllib"), NODES}
    assert [path.name for path in files if path.parent == NODES] == ["on_ray.py"]
