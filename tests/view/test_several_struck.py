"""What views tell of stops that one event strikes together: of each its own."""

from __future__ import annotations

import io
from importlib import import_module
from typing import Any

import pytest
from rich.console import Console
from small_machines import link, machine, slide

from nipper_pin import Case, Solution, Window, simulate
from nipper_pin.view.run.table import print_solution
from nipper_pin.view.scene.arrows import drawn_collisions
from nipper_pin.view.scene.readings import collision_text, readings
from nipper_pin.view.scene.rebounds import rebound_flights

film: Any = import_module("nipper_pin.view.scene.film")


@pytest.fixture(scope="module", params=["s0", "s1"])
def both(request: pytest.FixtureRequest) -> Solution:
    """Two balls from one height; either of their floors is the transition stop."""
    balls = machine(
        [link("m0", 1.0), slide("z0", "frame", "m0", axis=(0.0, 1.0)),
         link("m1", 2.0), slide("z1", "frame", "m1", axis=(0.0, 1.0), at=(1.0, 0.0))],
        2, gravity=9.81, transition_stop=request.param,
        stops={"s0": {"joint": "z0", "restitution": 0.3},
               "s1": {"joint": "z1", "restitution": 0.4}},
        initial={"z0": {"at_mm": 100.0}, "z1": {"at_mm": 100.0}},
    )  # fmt: skip
    return simulate(balls, Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0))


def test_each_stop_has_its_table(both: Solution) -> None:
    """Loss of the first row: m g h (1 - e^2), 893 and 1648 mJ."""
    stream = io.StringIO()
    print_solution(both, Console(width=100, file=stream))
    left, right = stream.getvalue().split("Collisions of stop s0")[1].split("Collisions of stop s1")
    assert left.split("─\n")[1].split()[0] == "1"
    assert "892.7" in left
    assert right.split("─\n")[1].split()[0] == "2"
    assert "1648" in right


def test_the_page_tells_both(both: Solution) -> None:
    """One text for the event; a mark for the curve of each."""
    said: Any = readings(film.film(both, film.Look()))
    first, second, *_ = said["collisions"]
    assert (first["stop"], second["stop"]) == ("s0", "s1")
    assert first["at"] == second["at"]
    assert first["text"] == second["text"]
    hits = both.collisions[:2]
    assert first["text"] == collision_text(both.mechanism, hits)
    assert first["text"].startswith("last: collisions 1 (s0): impulse 1.821 N s; 2 (s1): impulse ")
    assert said["collisions"][2]["text"].startswith("last: collision 3 (s")


def test_arrows_and_rebounds_are_those_of_each_stop(both: Solution) -> None:
    """The heights that are drawn larger are those of the transition stop."""
    assert [hit.stop for hit in drawn_collisions(both, 1.0)[:2]] == ["s0", "s1"]
    main = both.mechanism.transition_stop
    e_N = both.mechanism.stop(main).restitution
    assert rebound_flights(both)[0].highest == pytest.approx(e_N**2 * 0.1, rel=1e-12)
