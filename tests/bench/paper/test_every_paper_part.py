"""The published study as a whole: its record, its conditions, what is done and what is told."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up_studies import STUDIES
from scipy.interpolate import CubicSpline

from benchmarks.paper import phases, published, ratios, study
from benchmarks.paper.ratios import Ratio
from benchmarks.paper.study import PaperStudy
from nipper_pin.mechanism import Mechanism, load


def part(name: str) -> Any:
    return SimpleNamespace(record=lambda: {"of": name})


def test_the_whole_record(e62: Mechanism) -> None:
    given = published.published()
    ours = tuple(Ratio(str(k), 1.0, 1.0 + off) for k, off in enumerate((0.03, -0.039, 0.09, 0.2)))
    names = ("counts", "drives", "phase_one", "fixed_step", "shares", "durations")
    made = PaperStudy(mechanism=e62, published=given, studies=STUDIES, ratios=ours,
                      identified=ours[:3], motions=(), kinematics={"of": 1.0},
                      **{name: part(name) for name in names})  # fmt: skip
    record = made.record()
    assert record == {
        "model": "e62", "title": e62.title, "note": made.note, "source": given.source,
        "ratios": [item.record() for item in ours],
        "agreement": {"of": 4, "within_4_percent": 2, "within_10_percent": 3},
        "changes": ratios.ratio_values(STUDIES),
        "identified": {"model": "e62_identified", "ratios": [item.record() for item in ours[:3]],
                       "agreement": {"of": 3, "within_4_percent": 2,
                                     "within_10_percent": 3}},
        "studies": {name: getattr(STUDIES, name).record()
                    for name in ("speed", "restitution", "stiffness")},
        "collision_counts": {"of": "counts"}, "kinematics": {"of": 1.0},
        "drives": {"of": "drives"}, "phase_1": {"of": "phase_one"},
        "fixed_step": {"of": "fixed_step"}, "shares": {"of": "shares"},
        "duration_map": {"of": "durations"},
    }  # fmt: skip
    assert "from the published ratios, never the maker's data" in record["note"]
    other = PaperStudy(**{**made.__dict__, "ratios": (), "fixed_step": None})
    assert other.record()["fixed_step"] is None
    assert other.record()["note"].startswith("Every result is as good as the numbers")
    assert (made.compared, other.compared) == (True, False)


def test_the_published_numbers_for_another_machine(e62: Mechanism) -> None:
    given = published.conditions(e62)
    assert given == published.published()
    assert (given.speeds_rpm, given.common_speed_rpm) == ((450.0, 550.0, 650.0), 650.0)
    assert given.stiffnesses == (7e3, 8e3, 9e3, 10e3, 11e3)
    assert (given.common_restitution, given.count_increase) == (given.restitutions[3], 3.0)
    other = load("hanging_pendulum")
    found = published.conditions(other)
    rated, own = other.cylinder.rated_speed_rpm, other.springs[0].stiffness
    assert found.speeds_rpm == tuple(round(rated * s / 450.0) for s in given.speeds_rpm)
    assert found.common_speed_rpm == found.speeds_rpm[2]
    assert found.stiffnesses == pytest.approx([own * k / 9.0 for k in (7, 8, 9, 10, 11)])
    assert (found.ratios, found.count_increase) == ({}, None)
    assert found.restitutions == given.restitutions


@pytest.mark.parametrize("of_e62", [True, False])
def test_what_is_done_and_told(
    monkeypatch: pytest.MonkeyPatch, e62: Mechanism, of_e62: bool
) -> None:
    """Each part once, with what it needs, in the order that is told; the other model beside it."""
    asked: list[tuple[str, tuple[Any, ...]]] = []

    def stub(name: str) -> None:
        def called(*words: Any) -> str:
            asked.append((name, words))
            return f"{name} of {getattr(words[0], 'name', words[0])}"

        monkeypatch.setattr(study, name, called)

    for name in ("run_studies", "ratios", "compare_drives", "kinematics", "phase_one",
                 "fixed_step", "simulate", "collision_counts", "shares",
                 "duration_map"):  # fmt: skip
        stub(name)
    given = published.published() if of_e62 else published.conditions(load("hanging_pendulum"))
    monkeypatch.setattr(study, "conditions", lambda _: given)
    said: list[str] = []
    found: Any = study.paper_study(e62, said.append)
    fixed = ["fixed steps as published"] if of_e62 else []
    assert said == ["three studies", "held and inertial shafts", "phases 1 and 2", *fixed, "maps"]
    assert found.mechanism is e62
    assert found.published is given
    assert found.studies == "run_studies of e62"
    assert found.ratios == "ratios of run_studies of e62"
    assert found.identified == ("ratios of run_studies of e62_identified" if of_e62 else ())
    assert (found.drives, found.kinematics) == ("compare_drives of e62", "kinematics of e62")
    assert (found.phase_one, found.shares) == ("phase_one of e62", "shares of e62")
    assert found.fixed_step == ("fixed_step of e62" if of_e62 else None)
    assert (found.counts, found.durations) == (
        "collision_counts of run_studies of e62", "duration_map of e62",
    )  # fmt: skip
    told = dict(asked)
    assert told["kinematics"] == (e62, given.speeds_rpm[0])
    assert told["phase_one"] == (e62, given.speeds_rpm)
    speeds = [words[1].speed_rpm for name, words in asked if name == "simulate"]
    assert speeds == list(given.speeds_rpm)
    for name in ("compare_drives", "shares", "duration_map"):
        assert told[name] == (e62, given)
    own = study.paper_study(load("e62_identified"), said.append)
    assert own.identified == ()


def test_marks_of_a_turn(e62: Mechanism) -> None:
    """The jaw's angle with the steeve on its stop crosses zero twice; it is open in between.

    Zeros of a cubic spline through the samples, 1e-3 of the index; where it opens and closes are
    13 of 40 apart, and taken for one another they would be found out.
    """
    turn = phases.kinematics(e62, 650.0)
    index = phases.touch_index(e62) + np.linspace(0.0, 40.0, 1001)
    opened, _ = phases.branch(e62, frozenset({"steeve"}), 650.0, index)
    angle = CubicSpline(index, opened[:, e62.stop("jaw").index])
    inside = [x for x in angle.roots(extrapolate=False) if index[1] < x < index[-2]]
    opens = [x for x in inside if angle(x, 1) > 0.0]
    assert len(opens) == 1
    assert turn["opening_index"] == pytest.approx(opens[0] % 40.0, abs=1e-3)
    assert turn["closing_index"] == pytest.approx(index[0] % 40.0, abs=1e-9)
    assert turn["largest_jaw_angle_rad"] == pytest.approx(angle(index).max(), rel=1e-5)
    closed, _ = phases.branch(e62, frozenset({"jaw"}), 650.0, index)
    stroke = closed[:, e62.stop("steeve").index].max()
    assert turn["largest_stroke"] == pytest.approx(stroke, rel=1e-5)
    assert turn["speed_rpm"] == 650.0
