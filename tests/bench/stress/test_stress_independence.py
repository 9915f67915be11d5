"""The judge of the campaign shares no code with what it judges: read off its sources.

Solutions, events and panels are what is judged, so their types are known to it. Bounds, forces and
states are found by its own code; another engine is run by files that judge nothing.
"""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest
from machine_of_all_elements import CASE, everything
from numpy.polynomial import chebyshev

import benchmarks.stress as stress
from benchmarks.stress.mechanics.equations import Equations
from benchmarks.stress.observations import polynomial
from nipper_pin import Solution, simulate
from nipper_pin.mechanism import from_sources

FOLDER = Path(stress.__file__).resolve().parent
CHECKOUT = FOLDER.parents[1]
# Those that run engines, hold what is run, or write it.
RUNNING = {
    "__init__",
    "campaign",
    "engines",
    "files",
    "judging",
    "small_machines",
    "space",
}
RESULTS = {
    "segment": {"Segment"},
    "error_estimate.event_errors": {"EventError"},
    "event": {"Event", "EventKind"},
    "motion.panel": {"Panel"},
    "result.solution": {"Solution"},
    "result.tables": {"Collision"},
    "run.outcome": {"Outcome"},
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


@pytest.fixture(scope="module")
def run() -> Solution:
    source = everything()
    machine = from_sources(source.name, source.urdf, source.description, source.folder)
    return simulate(machine, CASE)


def test_own_accelerations_are_those_of_the_motion(run: Solution) -> None:
    """Two ways to one number, within the round-off that the judge says; it says 1e-11 at most.

    Velocities at times 2e-4 s apart, differences of the third order.
    """
    equations, h = Equations(run), 2e-4
    segment = max(run.segments, key=lambda item: item.t_end - item.t_start)
    t = 0.5 * (segment.t_start + segment.t_end)
    at = run.trajectory.evaluate(t + h * np.array([-2.0, -1.0, 0.0, 1.0, 2.0]))
    a = equations.accelerations(t, at.q[2], at.v[2], segment.closed)
    unsure = equations.round_off(t, at.q[2], at.v[2], segment.closed)
    slopes = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) @ at.v / (12.0 * h)
    size = float(np.abs(a).max())
    assert np.abs(a - slopes).max() < 1e-7 * size
    told = run.trajectory.reactions(t).a[0]
    assert (np.abs(a - told) <= 2.0 * unsure).all()
    assert 0.0 < unsure.max() < 1e-11 * size


@pytest.mark.parametrize("count", [3, 4, 7, 13, 32])
def test_panels_are_read_as_polynomials(count: int) -> None:
    """One of degree N - 1 is met between the nodes and in its slope; at nodes exactly."""
    coefficients = np.random.default_rng(count).normal(size=count)
    nodes = chebyshev.chebpts2(count)
    found = polynomial(chebyshev.chebval(nodes, coefficients)[:, None])
    eps = np.finfo(float).eps
    # Lebesgue's constant, for round-off in every value, and of the node that a place is next to.
    most = (1.0 + 2.0 / np.pi * np.log(count)) * count * eps * np.abs(coefficients).sum()
    between = chebyshev.chebpts1(count - 1)
    true = chebyshev.chebval(between, coefficients)
    assert np.abs(found(0.5 * (1.0 + between))[:, 0] - true).max() < 4.0 * most
    assert found(found.xi[1])[0] == found.yi[1, 0]
    rising = chebyshev.chebval(nodes, 2.0 * chebyshev.chebder(coefficients))
    assert np.abs(found.derivative(found.xi)[:, 0] - rising).max() < 4.0 * count**2 * most
