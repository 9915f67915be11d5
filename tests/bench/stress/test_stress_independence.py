"""The judge of the campaign shares no code with what it judges: read off its sources.

Solutions, events and panels are what is judged, so their types are known to it. Bounds, forces and
states are found by its own code, whose equations are those of the text of a model; another engine
is run by files that judge nothing.
"""

from __future__ import annotations

import ast
import math
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from any_plane import rewritten

import benchmarks.stress as stress
from benchmarks.stress.mechanics.planar_tree import PlanarTree

FOLDER = Path(stress.__file__).resolve().parent
CHECKOUT = FOLDER.parents[1]
# Those that run engines, hold what is run, or write it.
RUNNING = {"__init__", "campaign", "engines", "files", "judging", "small_machines", "space"}
RESULTS = {
    "": {"Collision", "Event", "EventError", "EventKind", "Outcome", "Segment", "Solution"},
    "motion.panel": {"Panel"},
}
DYNAMICS = {"system": {"System"}}
# What the engine computes accelerations, impulses and states with.
COMPUTING = {
    "closed_velocity", "constraint_set", "determined_accelerations",
    "forcing", "impulse_response", "interpolate", "interpolate_at", "prescribe", "refined",
    "respond",
}  # fmt: skip


def judging() -> list[Path]:
    """All files of the campaign that neither run nor draw: those that `invariants` comes to."""
    found, new = set(), {FOLDER / "checks/invariants.py", FOLDER / "checks/agreement.py"}
    while new:
        path = new.pop()
        found.add(path)
        files = {
            CHECKOUT.joinpath(*module.split(".")).with_suffix(".py") for module, _ in imports(path)
        }
        new |= {file for file in files if FOLDER in file.parents and file.exists()} - found
    return sorted(found)


def imports(path: Path) -> list[tuple[str, str]]:
    """Modules by their whole names, and the names imported, also within functions."""
    folders = path.resolve().relative_to(CHECKOUT).parts[:-1] if CHECKOUT in path.parents else ()
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            above = folders[: len(folders) + 1 - node.level] if node.level else ()
            module = ".".join((*above, *filter(None, [node.module])))
            found += [(module, item.name) for item in node.names]
        elif isinstance(node, ast.Import):
            found += [(item.name, "") for item in node.names]
    return found


def foreign(path: Path) -> list[tuple[str, str]]:
    """What a file imports of the engines beyond the types of results."""
    allowed = {"hybrid": RESULTS, "dynamics": DYNAMICS, "reduced": {}}
    found = []
    for module, name in imports(path):
        package, _, inside = module.partition(".")
        room, _, rest = inside.partition(".")
        if package != "nipper_pin":
            continue
        # The door of the package opens every room.
        if not room or (room in allowed and name not in allowed[room].get(rest, set())):
            found.append((module, name))
    return found


def test_files_that_judge_are_found() -> None:
    names = {path.stem for path in judging()}
    assert names >= {"agreement", "applied_forces", "elements", "equations", "flights", "impacts",
                     "invariants", "observations", "planar_tree", "rebounds"}  # fmt: skip
    assert not names & RUNNING


@pytest.mark.parametrize("path", judging(), ids=lambda path: path.stem)
def test_the_judge_imports_nothing_of_the_engines_but_results(path: Path) -> None:
    assert foreign(path) == []
    assert "pinocchio" not in {module for module, _ in imports(path)}
    used = [n for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.Attribute)]
    assert not {node.attr for node in used} & COMPUTING
    # The judge's own are asked of its own equations.
    of = {ast.unparse(node.value) for node in used if node.attr == "accelerations"}
    assert of <= {"equations"}


def test_a_bound_of_the_engine_would_be_found(tmp_path: Path) -> None:
    """Also where it is imported within a function."""
    planted = tmp_path / "planted.py"
    for line, module, name in (
        ("from nipper_pin.hybrid.motion.noise_floor import roughness",
         "nipper_pin.hybrid.motion.noise_floor", "roughness"),
        ("from nipper_pin import simulate", "nipper_pin", "simulate"),
        ("import nipper_pin.reduced", "nipper_pin.reduced", ""),
    ):  # fmt: skip
        planted.write_text(f"def f():\n    {line}\n")
        assert foreign(planted) == [(module, name)]


# --- its own equations ---------------------------------------------------------------------------


INERTIA = '<inertia ixx="0.3" iyy="0.4" izz="0.5" ixy="0.02" ixz="-0.03" iyz="0.04"/>'
# Hinges of both senses, a slide between them, and a link that is fixed to the last one.
TREE = f"""<robot name="tree"><link name="frame"/>
<link name="one"><inertial><origin xyz="0.1 0.2 -0.3" rpy="0.4 -0.5 0.6"/><mass value="2.5"/>
{INERTIA}</inertial></link>
<link name="two"><inertial><origin xyz="0 0 0"/><mass value="0.7"/>{INERTIA}</inertial></link>
<link name="three"><inertial><origin xyz="0 0.3 0.1"/><mass value="1.2"/>{INERTIA}</inertial></link>
<link name="tail"><inertial><origin xyz="0.3 0 0" rpy="0 0 1.1"/><mass value="0.4"/>{INERTIA}
</inertial></link>
<joint name="a" type="continuous"><parent link="frame"/><child link="one"/>
<origin xyz="0.5 -0.1 0.2" rpy="0 0.2 0"/><axis xyz="0 -1 0"/></joint>
<joint name="b" type="prismatic"><parent link="one"/><child link="two"/>
<origin xyz="0.2 0.4 0.1" rpy="0 -0.7 0"/><axis xyz="3 0 4"/>
<limit lower="-9" upper="9" effort="9" velocity="9"/></joint>
<joint name="c" type="continuous"><parent link="two"/><child link="three"/>
<origin xyz="0 0.3 0.2"/><axis xyz="0 2 0"/></joint>
<joint name="tail_fixed" type="fixed"><parent link="three"/><child link="tail"/>
<origin xyz="0.2 0.1 0.4" rpy="0.2 0.3 0.4"/></joint>
</robot>"""


@pytest.mark.parametrize("order", [["a", "b", "c"], ["c", "a", "b"]])
@pytest.mark.parametrize("seed", range(4))
def test_inertias_of_a_tree_in_any_plane(order: list[str], seed: int) -> None:
    """Mass matrix and forces by Pinocchio's recursions in space, in any order of coordinates.

    The machine is turned as a whole, and each of its frames for itself.
    """
    rng = np.random.default_rng(seed)
    turn = pin.rpy.rpyToMatrix(*rng.uniform(-3.0, 3.0, 3)) if seed else np.eye(3)
    urdf = rewritten(TREE, turn, {"a": (-1.0) ** seed}, rng if seed else None)
    model = pin.buildModelFromXML(urdf)
    # A hinge without limits is a point of the circle there.
    model.gravity.linear = np.array([0.0, 0.0, -7.5])
    data = model.createData()
    q, v, a = ({"a": x, "b": y, "c": z} for x, y, z in rng.normal(size=(3, 3)))
    pin_q = np.array([math.cos(q["a"]), math.sin(q["a"]), q["b"], math.cos(q["c"]),
                      math.sin(q["c"])])  # fmt: skip
    matrix = pin.crba(model, data, pin_q)
    matrix = np.triu(matrix) + np.triu(matrix, 1).T
    force = pin.rnea(model, data, pin_q, *(np.array([x[n] for n in "abc"]) for x in (v, a)))
    places = ["abc".index(name) for name in order]
    tree = PlanarTree(urdf, {"gravity_m_s2": 7.5}, order)
    state = [np.array([x[name] for name in order]) for x in (q, v, a)]
    # Sums of a few dozen terms of the size of one.
    wanted = matrix[np.ix_(places, places)]
    assert tree.mass_matrix(state[0]) == pytest.approx(wanted, abs=1e-13)
    assert tree.inverse_dynamics(*state) == pytest.approx(force[places], abs=1e-12)
    many = [np.stack([x, 0.5 * x]) for x in state]
    assert tree.inverse_dynamics(*many)[0] == pytest.approx(force[places], abs=1e-12)


def test_links_that_are_fixed_and_the_block_of_a_slot() -> None:
    """Two masses on a hinge at (3, 4) and (-3, 0); the block slides from where the pin is."""

    def link(name: str, mass: float, place: str) -> str:
        return (
            f'<link name="{name}"><inertial><origin xyz="{place}"/><mass value="{mass}"/>'
            '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )

    def fixed(name: str, parent: str, place: str) -> str:
        return (
            f'<link name="{name}"/><joint name="{name}_f" type="fixed"><parent link="{parent}"/>'
            f'<child link="{name}"/><origin xyz="{place}" rpy="0 -0.5 0"/></joint>'
        )

    urdf = (
        '<robot name="r"><link name="frame"/>'
        + link("arm", 2.0, "3 0 4") + link("back", 5.0, "-3 0 0")
        + '<joint name="h" type="continuous"><parent link="frame"/><child link="arm"/>'
        '<axis xyz="0 -1 0"/></joint><joint name="back_f" type="fixed"><parent link="arm"/>'
        '<child link="back"/></joint>' + fixed("slot", "arm", "1 0 0")
        + fixed("pin", "frame", "2 0 1")
        + "</robot>"
    )  # fmt: skip
    tree, still = PlanarTree(urdf, {"gravity_m_s2": 10.0}, ["h"]), np.zeros(1)
    weight = tree.inverse_dynamics(still, still, still)
    assert weight == pytest.approx([10.0 * (2.0 * 3.0 - 5.0 * 3.0)])
    assert tree.mass_matrix(still) == pytest.approx(np.array([[2.0 * 25.0 + 5.0 * 9.0]]))
    for axis, towards in (("x", (math.cos(0.5), math.sin(0.5))),
                          ("z", (-math.sin(0.5), math.cos(0.5)))):  # fmt: skip
        closure = {"frame_a": "slot", "frame_b": "pin", "slot_axis": axis, "block_mass_kg": 0.25}
        tree = PlanarTree(urdf, {"gravity_m_s2": 10.0, "closures": {"s": closure}}, ["h", "s"])
        along = 1.0 * towards[0] + 1.0 * towards[1] + 0.5
        x, z = 1.0 + along * towards[0], along * towards[1]
        q, still = np.array([0.0, 0.5]), np.zeros(2)
        # A hinge counts counter-clockwise: it moves (x, z) by (-z, x).
        cross = -z * towards[0] + x * towards[1]
        matrix = [[95.0 + 0.25 * (x * x + z * z), 0.25 * cross], [0.25 * cross, 0.25]]
        assert tree.mass_matrix(q) == pytest.approx(np.array(matrix))
        weight = tree.inverse_dynamics(q, still, still)
        assert weight == pytest.approx([-90.0 + 2.5 * x, 2.5 * towards[1]])
