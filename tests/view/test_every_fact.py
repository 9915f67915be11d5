"""Every number in the text of the study's page, in its smaller tables and in its maps.

They are compared with closed forms of made-up results that differ in every place, so that one that
is taken from another place, or in another unit, is seen.
"""

from __future__ import annotations

import csv
import io
import math
import re
from dataclasses import replace
from html import unescape
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import plate_frames
import pytest
from matplotlib.colors import to_hex
from matplotlib.contour import ContourSet
from rich.console import Console

from nipper_pin import Mechanism
from nipper_pin.study.conclusions import conclusions
from nipper_pin.study.paper import PaperStudy
from nipper_pin.study.paper.counts import Counts, collision_counts
from nipper_pin.study.paper.designs import RESTITUTIONS, DesignMap
from nipper_pin.study.paper.drives import FACTORS, DriveComparison, DriveEffect
from nipper_pin.study.paper.fixed_step import FixedStep, Rule
from nipper_pin.study.paper.phase_one import PhaseOne, Release
from nipper_pin.study.paper.published import published
from nipper_pin.study.paper.ratios import Ratio
from nipper_pin.study.paper.shares import Shares
from nipper_pin.study.paper.studies import Studies
from nipper_pin.study.sensitivity import Sensitivities, Sensitivity
from nipper_pin.view.paper import question_figures, report, tables
from nipper_pin.view.paper.canvas import Plate
from nipper_pin.view.paper.report import Material, report_html
from nipper_pin.view.paper.summary import print_paper
from nipper_pin.view.paper.supplements import Supplements
from nipper_pin.view.paper.terms import terms

GIVEN = published()
Array = Any
DECELERATION = 40.0


def series(rate: float, e: float) -> tuple[list[float], list[float]]:
    """Separation rates of bounces under a constant force [rad/s], and times of collisions [s]."""
    rates, times = [rate], [0.0]
    while rates[-1] > 1e-6:
        times.append(times[-1] + 2.0 * rates[-1] / DECELERATION)
        rates.append(e * rates[-1])
    return rates, times


def bounces(name: str, values: Any, cases: list[tuple[float, float]]) -> Any:
    """A study whose transitions are geometric series."""
    found = [series(*case) for case in cases]
    most = max(len(rates) for rates, _ in found)
    fill = np.full((2, len(cases), most), np.nan)
    for place, (rates, times) in enumerate(found):
        fill[0, place, : len(rates)], fill[1, place, : len(times)] = rates, times
    count = len(cases)
    return SimpleNamespace(
        name=name, values=np.array(values), rates=fill[0], bounces=SimpleNamespace(time=fill[1]),
        table=SimpleNamespace(duration_error=1e-15 * np.arange(2.0, 2.0 + count)),
        durations=1e-3 * (2.0 + np.arange(count) + len(name)), without_turn=(),
        shares=0.9 + 0.011 * np.arange(count),
    )  # fmt: skip


RESTITUTION = [(0.1 + 0.1 * i, e) for i, e in enumerate(GIVEN.restitutions)]
STIFFNESS = [(0.45 - 0.06 * i, 0.2) for i in range(len(GIVEN.stiffnesses))]
SPEED = [(0.2 + 0.11 * i, 0.2) for i in range(len(GIVEN.speeds_rpm))]
EFFECTS = tuple(
    DriveEffect(factor, speed, *(s * 1e-3 * (j + 2) * (i + 1) ** s / factor
                                 for j, s in enumerate((1, -1, 1, -1, 1))))
    for i, speed in enumerate(GIVEN.speeds_rpm)
    for factor in FACTORS
)  # fmt: skip
INDEX = np.linspace(24.0, 33.0, 37)
STEPS = np.array([1e-6, 3e-7, 1e-8])


def rule(name: str, size: float) -> Rule:
    errors = size * np.outer(STEPS / STEPS[0], [1.0, -3.0, 5.0, 7.0]) * (1.0 + 0.1 * np.arange(4))
    return Rule(name, STEPS, errors, 0.9 + 1e3 * size, 1e-9 * size * np.array([1, 2, -4, 8.0]))


@pytest.fixture(autouse=True)
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures need not become files."""
    monkeypatch.setattr(
        question_figures,
        "plate",
        lambda name, title, caption, figure: Plate(name, title, caption, figure, "", b""),
    )


@pytest.fixture(scope="module")
def study(e62: Mechanism) -> PaperStudy:
    """Made-up results."""
    studies = Studies(
        bounces("speed", GIVEN.speeds_rpm, SPEED),
        bounces("restitution", GIVEN.restitutions, RESTITUTION),
        bounces("stiffness", GIVEN.stiffnesses, STIFFNESS),
    )
    studies.restitution.without_turn = (0.2, 0.25)  # type: ignore[misc]
    speeds = np.linspace(400.0, 700.0, 61)
    e = np.linspace(0.02, 0.5, 25)
    numbers = np.arange(1, len(GIVEN.ratios) + 1)
    ours = [
        Ratio(name, value, value * (1.0 + 0.011 * k * (-1) ** k))
        for k, (name, value) in zip(numbers, GIVEN.ratios.items(), strict=True)
    ]
    place = np.linspace(0.0, 1.0, len(INDEX))
    # Falls with speed and restitution as planes do, so that lines of equal time are straight.
    durations = 1e-3 * (
        np.array([2.0, 3.0, 4.0])[:, None, None]
        + 10.0 * RESTITUTIONS[None, :, None]
        + 0.01 * (speeds - 400.0)[None, None, :]
    )
    return PaperStudy(
        mechanism=e62,
        published=GIVEN,
        studies=studies,
        ratios=tuple(ours),
        identified=tuple(replace(item, ours=item.published * 1.05) for item in ours[:7])
        + tuple(replace(item, ours=item.published * 0.97) for item in ours[7:]),
        motions=(),
        kinematics=cast("Any", None),
        counts=collision_counts(studies, GIVEN),
        drives=DriveComparison(
            {"pendulum": 1.25, "tension": 0.375},
            EFFECTS,
            tuple(replace(item, ours=item.ours * (1.0 + 1e-4 * k)) for k, item in enumerate(ours)),
        ),
        phase_one=PhaseOne(
            stop="steeve",
            preload=11e-3,
            preloads=np.linspace(5e-3, 17e-3, 9),
            speeds_rpm=np.linspace(400.0, 800.0, 11),
            index=INDEX,
            per_preload=9000.0 + 3000.0 * place,
            weight=4.0 - 2.0 * place,
            per_speed2=0.02 - 0.05 * place,
            releases=(
                Release(450.0, None, 0.0, 0.0),
                Release(550.0, 27.125, 3.3e-6, 1.7e-3),
                Release(650.0, 28.625, 4.7e-5, 2.9e-3),
            ),
        ),
        fixed_step=FixedStep(650.0, 1_234_567, 89, 3.1e-15, (rule("forward", 1e-4),
                                                              rule("semi-implicit", 3e-5))),
        shares=Shares(
            np.array(GIVEN.speeds_rpm), e,
            1.0 - e**2 + 0.04 * e[None] * np.array([[0.5], [1.0], [1.5]]),
            1.0 - e**2, dict(zip(GIVEN.ratios, 0.5 + 0.01 * numbers, strict=True)),
        ),
        designs=DesignMap(np.array([7e3, 9e3, 11e3]), speeds, durations, 11_163, "made up"),
    )  # fmt: skip


@pytest.fixture(scope="module")
def text(study: PaperStudy) -> str:
    """The page's text."""
    names = ["designs", "mechanism", "figure_11", "figure_12", "figure_13", "figure_14", "guide",
             "links", "both_stops", "thresholds", "drives", "stop_force", "fixed_step",
             "shares"]  # fmt: skip
    plates = tuple(Plate(n, n, "", cast("Any", None), "<svg></svg>", b"") for n in names)
    sheets = ["ratios", "table_3", "table_4", "table_5", "collision_counts", "rest_time", "drives",
              "ratios_inertial_shafts", "stop_in_phase_1", "fixed_step",
              "constant_force"]  # fmt: skip
    content = Material(plates, tuple(tables.Table(name, name, (), ()) for name in sheets))
    page = report_html(study, Supplements(), content)
    body = page.partition("<main>")[2]
    return " ".join(re.sub(r"<[^>]*>", "", body).split())


def said(text: str, pattern: str) -> list[float]:
    """Numbers of a sentence, of which there is one."""
    found = re.findall(pattern.replace("#", r"([-+]?[\d.,]+(?:e[-+]?\d+)?)"), text)
    assert len(found) == 1, pattern
    parts = [found[0]] if isinstance(found[0], str) else found[0]
    return [float(part.replace(",", "").rstrip(".")) for part in parts]


def close(found: list[float], *wanted: float, rel: float = 6e-3) -> None:
    assert found == [pytest.approx(value, rel=rel) for value in wanted]


def test_agreement(text: str, study: PaperStudy) -> None:
    """How many ratios agree, and the worst, of both models."""
    off = [0.011 * k for k in range(1, len(GIVEN.ratios) + 1)]
    near, far = (sum(value <= limit for value in off) for limit in (0.04, 0.10))
    close(
        said(text, r"Of # published ratios # agree within # % and # within # %; the largest"),
        len(off), near, 4, far, 10,
    )  # fmt: skip
    close(said(text, r"the largest deviation is # %"), 100.0 * off[-1] * (-1) ** len(off))
    rest = len(off) - 7
    close(said(text, r"inside stated bounds, # agree within # % and # within # %"),
          rest, 4, len(off), 10)  # fmt: skip
    stream = io.StringIO()
    print_paper(study, Console(file=stream, width=300))
    printed = stream.getvalue()
    assert f"e62: {near} of {len(off)} within 4 %, {far} within 10 %" in printed
    assert f"e62_identified: {rest} of {len(off)} within 4 %, {len(off)} within 10 %" in printed
    for k, (name, value) in enumerate(GIVEN.ratios.items(), start=1):
        words = tables.ratio_words(name)
        line = next(line for line in printed.splitlines() if line.startswith(words))
        cells = ["", *line.removeprefix(words).split()]
        change = 0.011 * k * (-1) ** k
        assert [float(cell) for cell in cells[1:4]] == [
            value, pytest.approx(value * (1.0 + change), rel=6e-4),
            pytest.approx(100.0 * change, abs=0.06),
        ]  # fmt: skip


def test_shafts_and_steps(text: str) -> None:
    """Changes by inertial shafts with the model's inertias, and errors of fixed steps."""
    close(
        said(text, r"changes the first amplitude by at most # % and the time to rest by at "
                   r"most # %"),
        100.0 * 3e-3, 100.0 * 5e-3, rel=0.06,
    )  # fmt: skip
    close(said(text, r"inertia of # kg m² \(pendulum\) and # kg m² \(tension\)"), 1.25, 0.375)
    most = 1e-4 * (len(GIVEN.ratios) - 1)
    close(said(text, r"moves by more than # % of itself"), 100.0 * most, rel=0.06)
    last = [1e-4 * 1e-2 * 7.0 * 1.3, 3e-5 * 1e-2 * 7.0 * 1.3]
    close(said(text, r"error of # \(forward\) or # \(semi-implicit\) in the time"), *last, rel=0.06)
    close(said(text, r"after # steps; ours takes # evaluations and states an error of # s"),
          1_234_567, 89, 3.1e-15)  # fmt: skip
    close(said(text, r"forward rule follows the step to the power #"), 1.0, rel=1e-2)
    close(said(text, r"semi-implicit rule follows the step to the power #"), 0.93, rel=1e-2)
    close(said(text, r"to ours within # and #: both"), 4e-13, 1.2e-13, rel=0.3)


def smallest(preload: float, rpm: float) -> float:
    """Least force of the made-up stop [N]."""
    omega = math.tau * rpm / 60.0
    place = np.linspace(0.0, 1.0, len(INDEX))
    force = preload * (9000.0 + 3000.0 * place) + 4.0 - 2.0 * place
    return float((force + omega**2 * (0.02 - 0.05 * place)).min())


def threshold(preload: float) -> float:
    """Speed at which that becomes zero [r/min], by halving."""
    low, high = 0.0, 1e4
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if smallest(preload, middle) > 0.0 else (low, middle)
    return low


def test_the_stop_of_phase_1(text: str) -> None:
    """Speed from which on it lets go, where, and how far."""
    limit = threshold(11e-3)
    close(said(text, r"with the jaw open from # r/min on"), limit, rel=1e-4)
    close(said(text, r"at # r/min at index #, by # µm; at # r/min at index #, by # µm"),
          550, 27.125, 3.3, 650, 28.625, 47.0)  # fmt: skip
    close(said(text, r"with the preload of # mm the steeve stays on its stop up to # r/min"),
          11.0, limit, rel=1e-4)  # fmt: skip


def test_collisions_in_words(text: str, study: PaperStudy, e62: Mechanism) -> None:
    """Thresholds, limits and growth, and the rate at the lips."""
    low, high = GIVEN.restitutions[0], GIVEN.restitutions[-1]
    limit = math.log(low) / math.log(high) - 1.0
    close(said(text, rf"increase from e = {low} to {high} tends to # %"), 100.0 * limit)
    assert f"at most by {100.0 * study.counts.largest_increase:+.0f} %" in text
    contact = e62.stop("jaw").contact
    assert contact is not None
    arm = 1e3 * contact.lever_m
    close(said(text, r"at the lips \(# mm from the hinge\)"), arm, rel=1e-3)
    for match, name in (
        (study.counts.rebounds_match, r"Rebounds \+300 %: ([^;]*?) rad/s"),
        (study.counts.times_match, r"Collisions grow to 3 times: (.*?) rad/s"),
        (study.counts.same_with_stiffness, r"No change with the spring rate: (.*?) rad/s"),
    ):
        told = re.findall(name, text)
        assert told == [", ".join(f"{a:.3g} to {b:.3g}" for a, b in match) or "none"], name
    both = study.counts.both_match
    assert both
    for a, b in both:
        assert f"{a * arm:.3g} to {b * arm:.3g} mm/s" in text
    assert "e transition computed for restitution 0.2, 0.25:" in text


def test_conditions_share_and_map(text: str, study: PaperStudy) -> None:
    """Speeds and rates, limit of the common case, its share, and the range of the map."""
    speeds = ", ".join(f"{speed:g}" for speed in GIVEN.speeds_rpm)
    rates = ", ".join(f"{1e-3 * k:g}" for k in GIVEN.stiffnesses)
    assert f"speeds of {speeds} r/min at e = {GIVEN.common_restitution}" in text
    assert f"spring rates of {rates} N/mm at {GIVEN.common_speed_rpm:g} r/min" in text
    common = GIVEN.speeds_rpm.index(GIVEN.common_speed_rpm)
    close(said(text, r"The limit is # ms"), 2.0 + common + len("speed"), rel=1e-5)
    close(said(text, r"our share is # %"), 100.0 * (0.9 + 0.011 * common), rel=1e-4)
    # 4 % of e times the largest factor, at e = 0.24, the last of the made-up ones up to 0.25.
    close(
        said(text, r"differs by at most # points of % up to e = 0.25"), 4.0 * 0.24 * 1.5, rel=0.06
    )
    durations = study.designs.durations
    close(said(text, r"# transitions, with times to rest from # to # ms"),
          11_163, 1e3 * durations.min(), 1e3 * durations.max())  # fmt: skip


def test_sections_of_other_studies(study: PaperStudy) -> None:
    """Sensitivities with their conclusions, then the identification; accuracy is the last."""
    rows = tuple(
        Sensitivity(path=path, value=7.0, unit=unit, per=np.array(per), control=np.array(per))
        for path, unit, per in (
            ("stops.jaw.restitution", "%", (1.9, 0.7, 0.0)),
            ("springs.steeve.preload_length_mm", "mm", (-8.0, -4.0, 9.0)),
            ("springs.steeve.stiffness_N_per_m", "%", (-0.5, -0.25, 0.5)),
            ("speed_rpm", "%", (1.2, 0.4, -0.1)),
            ("links.top_nipper.mass_kg", "%", (0.6, 0.3, 0.2)),
        )
    )
    found = Sensitivities(
        model="e62", stop="jaw", speed_rpm=650.0, amplitude_rad=5e-3, transition_time_s=6e-3,
        clamping_force_N=80.0, premise_holds=True, rows=rows,
    )  # fmt: skip
    document = {
        "caution": "Fitted.", "title": "some numbers", "model": "e62", "seed": 7,
        "goodness": {"sentence": "They agree."}, "within_4_percent": 3, "targets": [1, 2, 3, 4],
        "identifiable_directions": 2, "parameters": [1, 2, 3, 4, 5],
    }  # fmt: skip
    names = ["designs", "mechanism", "figure_11", "figure_12", "figure_13", "figure_14", "guide",
             "links", "both_stops", "thresholds", "drives", "stop_force", "fixed_step", "shares",
             "sensitivities", "identification"]  # fmt: skip
    plates = tuple(Plate(n, n, "", cast("Any", None), "<svg></svg>", b"") for n in names)
    sheets = ["ratios", "table_3", "table_4", "table_5", "collision_counts", "rest_time", "drives",
              "ratios_inertial_shafts", "stop_in_phase_1", "fixed_step", "constant_force",
              "sensitivities", "identification_targets", "identified_numbers"]  # fmt: skip
    content = Material(plates, tuple(tables.Table(name, name, (), ()) for name in sheets))
    last = ["Method", "Accuracy and limits"]
    for given, sections in (
        (Supplements(found, document), ["Sensitivities", "Identification", *last]),
        (Supplements(found), ["Sensitivities", *last]),
        (Supplements(None, document), ["Identification", *last]),
        (Supplements(), last),
    ):
        page = report_html(study, given, content)
        heads = re.findall(r'<h2 id="section-(\w+)">(\d+) ([^<]*)</h2>', page)
        assert [int(number) for _, number, _ in heads] == list(range(1, len(heads) + 1))
        assert [title for _, _, title in heads[6:]] == sections
        links = re.findall(r'<a href="#section-(\w+)">(\d+) ([^<]*)</a>', page)
        assert links == heads
        told = [sentence in unescape(page) for sentence in conclusions(found)]
        assert told
        assert set(told) == {given.sensitivities is not None}
        words = (
            "some numbers; model e62, seed 7. They agree. 3 of 4 targets are met within 4 %.",
            "they narrow 2 of 5 directions that far (figure A12)",
        )
        flat = re.sub(r"<[^>]*>", "", page)
        assert [text.lower() in flat.lower() for text in words] == [
            given.identification is not None
        ] * 2


def test_numbers_of_figures_and_tables() -> None:
    """Those of the paper keep theirs, all others count on."""
    names = ["figure_11", "guide", "table_3", "figure_x", "drives_2", "figure_12"]
    assert report.numbers(names) == {
        "figure_11": "11", "guide": "A1", "table_3": "3", "figure_x": "A2", "drives_2": "A3",
        "figure_12": "12",
    }  # fmt: skip


def test_which_tables_and_figures_there_are(
    study: PaperStudy, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the order of their numbers; none of what there is no result of."""
    for name in ("ratio", "count", "rest", "drive", "inertial_ratio", "stop", "step", "force",
                 "sensitivity"):  # fmt: skip
        monkeypatch.setattr(report, f"{name}_table", lambda *_, name=name: name)
    monkeypatch.setattr(report, "published_tables", lambda _: ["3", "4", "5"])
    monkeypatch.setattr(report, "identification_tables", lambda _: ["targets", "numbers"])
    for name in ("sensitivity", "identification"):
        monkeypatch.setattr(report, f"{name}_plate", lambda *_, name=name: f"{name} plate")
    every = ["ratio", "3", "4", "5", "count", "rest", "drive", "inertial_ratio", "stop", "step",
             "force"]  # fmt: skip
    drawn: Any = ["one", "two"]
    found = report.material(study, Supplements(), drawn)
    assert (found.plates, found.tables) == (("one", "two"), tuple(every))
    both = Supplements(cast("Any", 1), {"a": 1})
    found = report.material(study, both, drawn)
    assert found.plates == ("one", "two", "sensitivity plate", "identification plate")
    assert found.tables == (*every, "sensitivity", "targets", "numbers")
    other = replace(study, ratios=(), fixed_step=None)
    assert not other.compared
    assert report.material(other, Supplements(), drawn).tables == (
        "3", "4", "5", "count", "rest", "drive", "stop",
    )  # fmt: skip
    for name in ("published", "kinematic"):
        monkeypatch.setattr(report, f"{name}_plates", lambda _, name=name: [name])
    monkeypatch.setattr(report, "question_plates", lambda _: ["question", "map"])
    monkeypatch.setattr(report, "machine_plate", lambda _: "machine")
    told: list[tuple[int, int]] = []
    drawn = report.study_plates(study, lambda *numbers: told.append(numbers))
    assert drawn == ["map", "machine", "published", "kinematic", "question"]
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]


def test_ratios_in_words() -> None:
    """What changes between which two cases; shares with their speed."""
    ends = {
        "speed": "450 to 650 r/min", "restitution": "e = 0.05 to 0.25", "stiffness": "7 to 11 N/mm",
    }  # fmt: skip
    for name in GIVEN.ratios:
        study, _, quantity = name.partition(".")
        if "share" in quantity:
            speed = name.rpartition("_")[2]
            wanted = f"share of the first two rebounds, {speed} r/min"
        else:
            words = quantity.removesuffix("_increase").removesuffix("_change").replace("_", " ")
            wanted = f"{words}, {ends[study]}"
        assert tables.ratio_words(name) == wanted


# Tables.


def columns(table: tables.Table) -> tuple[dict[str, list[str]], dict[str, tuple[str, list[str]]]]:
    """Stored columns by key, and shown ones with their heading."""
    stored = list(csv.DictReader(io.StringIO(table.csv_text())))
    keys = [item.key for item in table.columns]
    shown = {
        key: (item.heading, [row[place] for row in table.shown])
        for place, (key, item) in enumerate(zip(keys, table.columns, strict=True))
    }
    return {key: [row[key] for row in stored] for key in keys}, shown


def test_table_of_the_stop(study: PaperStudy) -> None:
    """Smallest force, index, lift in micrometres and time in milliseconds."""
    stored, shown = columns(tables.stop_table(study))
    speeds = GIVEN.speeds_rpm
    forces = [smallest(11e-3, speed) for speed in speeds]
    assert [float(x) for x in stored["speed_rpm"]] == list(speeds)
    assert [float(x) for x in stored["smallest_force_N"]] == pytest.approx(forces, rel=1e-12)
    assert [float(x) for x in shown["smallest_force_N"][1]] == pytest.approx(forces, rel=6e-4)
    assert stored["release_index"] == ["", "27.125", "28.625"]
    assert shown["release_index"][1] == ["stays closed", "27.125", "28.625"]
    assert [float(x) for x in stored["lift_m"]] == [0.0, 3.3e-6, 4.7e-5]
    assert shown["lift_m"] == ("lift [µm]", ["-", "3.300", "47.00"])
    assert [float(x) for x in stored["duration_s"]] == [0.0, 1.7e-3, 2.9e-3]
    assert shown["duration_s"] == ("for [ms]", ["-", "1.700", "2.900"])


def test_table_of_steps(study: PaperStudy) -> None:
    """Step in microseconds, and errors by quantity."""
    assert study.fixed_step is not None
    stored, shown = columns(tables.step_table(study.fixed_step))
    assert stored["rule"] == ["forward"] * 3 + ["semi-implicit"] * 3
    assert [float(x) for x in stored["step_s"]] == [*STEPS, *STEPS]
    assert shown["step_s"] == ("step [µs]", ["1.000", "0.3000", "0.01000"] * 2)
    names = ("first_time_error", "second_time_error", "rebound_amplitude_1_error", "duration_error")
    factors = (1.0, -3.0 * 1.1, 5.0 * 1.2, 7.0 * 1.3)
    headings = ("T<sub>1</sub>", "T<sub>2</sub>", "A<sub>1</sub>", "time to rest")
    for name, factor, heading in zip(names, factors, headings, strict=True):
        wanted = [size * step / 1e-6 * factor for size in (1e-4, 3e-5) for step in STEPS]
        assert [float(x) for x in stored[name]] == pytest.approx(wanted, rel=1e-12)
        assert shown[name][0] == heading
        assert [float(x) for x in shown[name][1]] == pytest.approx(wanted, rel=0.06)


def test_table_of_a_constant_force(study: PaperStudy) -> None:
    """Ratios of a constant force, ours and the published ones."""
    stored, shown = columns(tables.force_table(study))
    assert stored["name"] == list(GIVEN.ratios)
    numbers = range(1, len(GIVEN.ratios) + 1)
    wanted = {
        "constant_force": [0.5 + 0.01 * k for k in numbers],
        "ours": [v * (1.0 + 0.011 * k * (-1) ** k)
                 for k, v in zip(numbers, GIVEN.ratios.values(), strict=True)],
        "published": list(GIVEN.ratios.values()),
    }  # fmt: skip
    for key, values in wanted.items():
        assert [float(x) for x in stored[key]] == pytest.approx(values, rel=1e-12)
        assert [float(x) for x in shown[key][1]] == pytest.approx(values, rel=6e-4)


# Counts.


def number(case: tuple[float, float], limit: float) -> int:
    """Collisions until the first rebound slower than a limit."""
    rate, e = case
    return next(k for k in range(1, 10_000) if rate * e ** (k - 1) < limit)


def lasting(case: tuple[float, float], limit: float) -> float:
    """Time of the last of these collisions [s]: a geometric sum."""
    rate, e = case
    return 2.0 * rate / DECELERATION * (1.0 - e ** (number(case, limit) - 1)) / (1.0 - e)


def test_counts_are_those_of_geometric_series(study: PaperStudy) -> None:
    """All numbers of the document, and the stretches of thresholds, at random thresholds."""
    counts: Counts = study.counts
    found = counts.record()
    limits = found["threshold_rad_s"]
    assert limits == pytest.approx([10.0 ** (-4.0 + 0.5 * k) for k in range(9)], rel=1e-9)
    for key, cases in (
        ("by_restitution", RESTITUTION), ("by_stiffness", STIFFNESS), ("by_speed", SPEED),
    ):  # fmt: skip
        assert found[key] == [[number(case, limit) for case in cases] for limit in limits], key
    for limit, told in zip(limits, found["transition_time_increase"], strict=True):
        first, last = lasting(RESTITUTION[0], limit), lasting(RESTITUTION[-1], limit)
        assert told == (pytest.approx(last / first - 1.0, rel=1e-9) if first > 0.0 else None)
    most = 0.0
    for limit in 10.0 ** np.random.default_rng(8).uniform(-5.0, 1.0, 300):
        few, many = number(RESTITUTION[0], limit), number(RESTITUTION[-1], limit)
        most = max(most, many / few)
        same = len({number(case, limit) for case in STIFFNESS}) == 1
        rebounds = few > 1 and many - 1 == 4 * (few - 1)
        wanted = {
            "collisions_grow_as_published": many == 4 * few,
            "rebounds_grow_as_published": rebounds,
            "collisions_grow_to_the_published_multiple": many == 3 * few,
            "unchanged_by_stiffness": same,
            "rebounds_as_published_and_unchanged_by_stiffness": rebounds and same,
        }
        for key, holds in wanted.items():
            assert holds == any(low < limit <= high for low, high in found[key]), (key, limit)
    assert found["rebounds_grow_as_published"]
    assert found["collisions_grow_to_the_published_multiple"]
    assert found["largest_increase_of_collisions"] == pytest.approx(most - 1.0, abs=1e-12)


# Figures.


def test_frames_of_the_figures(study: PaperStudy) -> None:
    """Labels, scales, letters, legends and limits of every panel, and lines that only guide."""
    plates = question_figures.question_plates(study)
    names = ["thresholds", "drives", "stop_force", "fixed_step", "shares", "designs"]
    plate_frames.check(plates, names, terms(study).mark)
    figures = {item.name: item.figure for item in plates}
    assert [axes.lines[-1].get_xdata() for axes in figures["drives"].axes] == [[1.0, 1.0]] * 2
    assert figures["stop_force"].axes[0].lines[-1].get_ydata() == [0.0, 0.0]
    steps = figures["fixed_step"]
    words = ["first rebound time", "second rebound time", "first amplitude", "time to rest"]
    entries = [text.get_text() for text in steps.legends[0].get_texts()]
    assert entries == [*words, "order 1"]
    for axes in steps.axes:
        x, y = (np.asarray(values) for values in axes.lines[-1].get_data())
        assert list(x) == [STEPS[0], STEPS[-1]]
        assert y[0] / y[1] == pytest.approx(x[0] / x[1], rel=1e-12)
    # White is no force: blue pushes, red would have to pull.
    (filled, *_) = figures["stop_force"].axes[1].collections
    most = float(np.abs(study.phase_one.smallest_forces()).max())
    assert (filled.norm.vmin, filled.norm.vmax) == pytest.approx((-most, most))
    assert filled.get_cmap().name == "RdBu"
    for axes in figures["thresholds"].axes[:1]:
        assert all(tick == round(tick) for tick in axes.get_yticks())


def test_values_on_the_lines_of_the_map(study: PaperStudy) -> None:
    """Each stands on its line, inside of the frame; those of times and of indices apart."""
    figure = question_figures._designs(study).figure
    for base, axes in zip((2.0, 3.0, 4.0), figure.axes[:3], strict=True):
        found: dict[bool, list[float]] = {True: [], False: []}
        for text in axes.texts:
            (speed, e), value = text.get_position(), float(text.get_text())
            ms = base + 10.0 * e + 0.01 * (speed - 400.0)
            values = (40.0 * ms * 1e-3 * speed / 60.0, ms)
            of_index = abs(values[0] - value) < abs(values[1] - value)
            assert min(abs(item - value) for item in values) < 0.06
            found[of_index].append(speed)
            assert 400.0 < speed < 700.0
            assert RESTITUTIONS[0] + 0.01 < e < RESTITUTIONS[-1] - 0.01
        assert len(found[False]) >= 3
        assert len(found[True]) >= 1
        # Indices to the left, times to the right, as far as their lines go.
        assert np.median(found[True]) < 550.0 < np.median(found[False])


def test_figure_of_thresholds(study: PaperStudy) -> None:
    """Steps of three restitutions, the shaded stretch, and the growth of the time."""
    steps, time = question_figures._thresholds(study).figure.axes
    lines = {line.get_label(): line for line in steps.lines}
    for place in (0, 2, 4):
        line = lines[f"e = {GIVEN.restitutions[place]:g}"]
        for x, y in list(zip(*line.get_data(), strict=True))[::53]:
            assert y == number(RESTITUTION[place], float(x) * (1.0 - 1e-12))
    spans = [(p.get_x(), p.get_x() + p.get_width()) for p in steps.patches]
    assert spans == [pytest.approx(item) for item in study.counts.rebounds_match]
    curve, limit, given = time.lines
    for x, y in list(zip(*curve.get_data(), strict=True))[:-120:53]:
        first, last = (lasting(RESTITUTION[k], float(x) * (1.0 - 1e-12)) for k in (0, -1))
        assert y == pytest.approx(last / first - 1.0, rel=1e-9) if first else math.isnan(y)
    durations = study.studies.restitution.durations
    assert limit.get_ydata()[0] == pytest.approx(durations[-1] / durations[0] - 1.0)
    key = "restitution.transition_time_increase"
    assert given.get_ydata()[0] == GIVEN.ratios[key]


def test_figure_of_shafts(study: PaperStudy) -> None:
    """Sizes of changes in per cent by inertia and speed."""
    panels = question_figures._drives(study).figure.axes
    for axes, name in zip(panels, ("first_amplitude", "transition_time"), strict=True):
        assert axes.get_ylabel().endswith("[%]")
        for i, speed in enumerate(GIVEN.speeds_rpm):
            line = next(item for item in axes.lines if item.get_label() == f"{speed:g} r/min")
            size = {"first_amplitude": 3e-3, "transition_time": 5e-3}[name] / (i + 1)
            wanted = [100.0 * size / factor for factor in FACTORS]
            assert line.get_xdata() == pytest.approx(FACTORS)
            assert line.get_ydata() == pytest.approx(wanted)
    caption = question_figures._drives(study).caption
    close(said(caption, r"the amplitude changes by at most # %"), 0.3, rel=0.06)


def test_figure_of_the_stop(study: PaperStudy) -> None:
    """Force along the phase, the map of the least force, and the line where it is zero."""
    plate = question_figures._stop_force(study)
    curve, chart = plate.figure.axes[:2]
    place = np.linspace(0.0, 1.0, len(INDEX))
    for line, speed in zip(curve.lines, GIVEN.speeds_rpm, strict=False):
        omega2 = (math.tau * speed / 60.0) ** 2
        force = 11e-3 * (9000.0 + 3000.0 * place) + 4.0 - 2.0 * place
        wanted = force + omega2 * (0.02 - 0.05 * place)
        np.testing.assert_allclose(line.get_xdata(), INDEX)
        np.testing.assert_allclose(line.get_ydata(), wanted, rtol=1e-12)
    assert chart.get_ylabel() == "preload [mm]"
    limit = next(line for line in chart.lines if line.get_label() == "lets go beyond")
    for rpm, preload in list(zip(*limit.get_data(), strict=True)):
        assert rpm == pytest.approx(threshold(1e-3 * preload), rel=1e-9)
    assert (limit.get_ydata()[0], limit.get_ydata()[-1]) == pytest.approx((5.0, 17.0))
    marks = [line for line in chart.lines if len(line.get_xdata()) == 1]
    found = [(line.get_xdata()[0], line.get_ydata()[0], line.get_marker()) for line in marks]
    assert found == [(450.0, 11.0, "s"), (550.0, 11.0, "X"), (650.0, 11.0, "X")]
    filled = next(item for item in chart.collections if isinstance(item, ContourSet))
    corners = np.concatenate([path.vertices for path in filled.get_paths()])
    x, y = corners.T
    inside = corners[(x > 401.0) & (x < 799.0) & (y > 5.01) & (y < 16.99)]
    assert len(inside) > 50
    for rpm, preload in inside:
        # Straight between places of the map: a hundredth of the step from one level to the next.
        off = np.abs(filled.levels - smallest(1e-3 * preload, rpm)).min()
        assert off < 0.01 * float(np.diff(filled.levels)[0]) + 0.2
    close(said(plate.caption, r"that begins at # r/min"), threshold(11e-3), rel=1e-4)
    close(said(plate.caption, r"jaw is open, preload # mm"), 11.0)


def test_figure_of_steps(study: PaperStudy) -> None:
    """Sizes of errors over the step, one line a quantity."""
    assert study.fixed_step is not None
    figure = question_figures._fixed_step(study.fixed_step, "").figure
    factors = {"first rebound time": 1.0, "second rebound time": 3.3, "first amplitude": 6.0,
               "time to rest": 9.1}  # fmt: skip
    for axes, size in zip(figure.axes, (1e-4, 3e-5), strict=True):
        lines = {line.get_label(): line for line in axes.lines}
        for label, factor in factors.items():
            assert lines[label].get_xdata() == pytest.approx(STEPS)
            assert lines[label].get_ydata() == pytest.approx(size * STEPS / 1e-6 * factor)


def test_map_of_designs(study: PaperStudy) -> None:
    """Lines of whole milliseconds and of whole indices lie where the plane has these values."""
    figure = question_figures._designs(study).figure
    panels = figure.axes[:3]
    titles = [axes.get_title(loc="left").split()[-2:] for axes in panels]
    assert titles == [["7", "N/mm"], ["9", "N/mm"], ["11", "N/mm"]]
    assert figure.axes[-1].get_ylabel() == "time to rest [ms]"
    for base, axes in zip((2.0, 3.0, 4.0), panels, strict=True):
        assert axes.get_xlabel() == "speed [r/min]"
        sets = [item for item in axes.collections if isinstance(item, ContourSet)]
        (times,) = (s for s in sets if not s.filled and to_hex(s.get_edgecolors()[0]) == "#000000")
        (turns,) = (s for s in sets if not s.filled and to_hex(s.get_edgecolors()[0]) != "#000000")
        checked = 0
        for lines, of_index in ((times, False), (turns, True)):
            for level, path in zip(lines.levels, lines.get_paths(), strict=True):
                for speed, e in path.vertices:
                    ms = base + 10.0 * e + 0.01 * (speed - 400.0)
                    # 40 indices a turn of 60 s by the speed; straight between places of the map.
                    value = 40.0 * ms * 1e-3 * speed / 60.0 if of_index else ms
                    assert value == pytest.approx(level, rel=1e-4)
                    checked += 1
        assert checked > 100
    found = study.designs.record()
    assert found["speed_rpm"] == [400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0]
    assert found["restitution"] == pytest.approx([0.02, 0.07, 0.12, 0.17, 0.22, 0.27, 0.32])
    assert found["stiffness"] == [7e3, 9e3, 11e3]
    for base, panel in zip((2.0, 3.0, 4.0), found["duration_s"], strict=True):
        for e, row in zip(found["restitution"], panel, strict=True):
            wanted = [1e-3 * (base + 10.0 * e + 0.01 * (n - 400.0)) for n in found["speed_rpm"]]
            assert row == pytest.approx(wanted, rel=1e-12)
