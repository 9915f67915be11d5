"""Every sentence and number that is concluded from sensitivities, from rows that are made up."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nipper_pin.errors import SimulationError
from nipper_pin.mechanism import Mechanism
from nipper_pin.study import sensitivity
from nipper_pin.study.conclusions import conclusions, label
from nipper_pin.study.identify.problem.geometry import Sources
from nipper_pin.study.sensitivity import Sensitivities, Sensitivity


def row(path: str, unit: str, *per: float, off: float = 0.0) -> Sensitivity:
    values = np.array(per)
    control = values - np.array([0.0, off, 0.0])
    return Sensitivity(path=path, value=3.0, unit=unit, per=values, control=control)


def made_up(*rows: Sensitivity, holds: bool | None = True) -> Sensitivities:
    return Sensitivities(
        model="mine", stop="peg", speed_rpm=612.5, premise_holds=holds, amplitude_rad=2.346e-3,
        transition_time_s=6.789e-3, clamping_force_N=147.26, rows=rows,
    )  # fmt: skip


FIRST = (
    "mine at 612.5 r/min: the first bounce opens peg by 134.4 mdeg, it is at rest after "
    "6.79 ms, and then presses with 147 N."
)


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("points.rod_pin.x_mm", "pin rod forward"),
        ("points.rod_pin.z_mm", "pin rod upward"),
        ("points.eccentric_pin.radius_mm", "distance of pin eccentric from its shaft"),
        ("points.eccentric_pin.angle_deg", "angle of pin eccentric about its shaft"),
        ("links.top_nipper.mass_kg", "mass of top nipper"),
        ("links.top_nipper.gyration_mm", "radius of gyration of top nipper"),
        ("links.top_nipper.com_x_mm", "centre of mass of top nipper forward"),
        ("links.top_nipper.com_z_mm", "centre of mass of top nipper upward"),
        ("springs.steeve.stiffness_N_per_m", "stiffness of spring steeve"),
        ("springs.own_one.stiffness_N_m_per_rad", "stiffness of spring own one"),
        ("springs.steeve.preload_length_mm", "preload length of spring steeve"),
        ("stops.jaw.restitution", "restitution of stop jaw"),
        ("drives.tension.ratio", "ratio of drive tension"),
        ("cylinder.angle_at_touch_deg", "cylinder angle at touch"),
        ("speed_rpm", "cylinder speed"),
        ("other.limit_mm", "other limit"),
    ],
)  # fmt: skip
def test_numbers_of_a_model_in_words(path: str, words: str) -> None:
    assert label(path) == words


def test_all_sentences() -> None:
    """Speed, each quantity by each unit, what helps, what is doubtful, and what does nothing.

    The first row lowers the bounce by 4 % a millimetre: 2.5 mm for 10 %, inside of the 5 mm that
    are still small, and presses harder by 2.5 * 0.8 = 2 %. The fourth needs 1 / 0.03 degrees.
    """
    found = made_up(
        row("speed_rpm", "%", 2.04, -1.11, 0.72),
        row("springs.steeve.preload_length_mm", "mm", -4.0, -3.0, 0.8),
        row("points.jaw.z_mm", "mm", 0.5, 5.0, -0.02),
        row("points.eccentric_pin.angle_deg", "deg", -0.3, -0.2, 0.1),
        row("cylinder.angle_at_touch_deg", "deg", 2.5, 0.5, -3.0),
        row("stops.jaw.restitution", "%", -9.0, -8.0, 7.0),
        row("springs.steeve.stiffness_N_per_m", "%", -0.5, -0.6, 0.7),
        row("drives.tension.ratio", "0.01", 7.0, -1e-9, 1e-9),
        row("points.rod_pin.x_mm", "mm", 60.0, 70.0, 80.0, off=0.09),
        row("links.crank.mass_kg", "%", 0.0, 9e-7, 0.0),
        row("links.crank.gyration_mm", "mm", 0.0, 0.0, 0.0),
        row("links.arm_two.mass_kg", "%", 0.0, 0.0, 0.0),
        row("springs.steeve.loss", "%", 0.0, 0.0, -9e-7),
    )
    preload, touch = "preload length of spring steeve", "cylinder angle at touch"
    eccentric, stiffness = "angle of pin eccentric about its shaft", "stiffness of spring steeve"
    assert conclusions(found) == (
        FIRST,
        "1 % more speed makes the first bounce 2 % higher, the transition 1.1 % shorter and the "
        "clamping force 0.72 % larger.",
        f"What 1 mm more changes the first bounce by, the strongest first: {preload} -4 %, "
        "pin jaw upward +0.5 %.",
        "What 1 degree more changes the first bounce by, the strongest first: "
        f"{touch} +2.5 %, {eccentric} -0.3 %.",
        "What 1 % more changes the first bounce by, the strongest first: restitution of stop jaw "
        f"-9 %, {stiffness} -0.5 %.",
        "What 0.01 more changes the first bounce by, the strongest first: ratio of drive tension "
        "+7 %.",
        f"What 1 mm more changes the transition by, the strongest first: pin jaw upward +5 %, "
        f"{preload} -3 %.",
        "What 1 degree more changes the transition by, the strongest first: "
        f"{touch} +0.5 %, {eccentric} -0.2 %.",
        "What 1 % more changes the transition by, the strongest first: restitution of stop jaw "
        f"-8 %, {stiffness} -0.6 %.",
        f"What 1 mm more changes the clamping force by, the strongest first: {preload} +0.8 %, "
        "pin jaw upward -0.02 %.",
        "What 1 degree more changes the clamping force by, the strongest first: "
        f"{touch} -3 %, {eccentric} +0.1 %.",
        "What 1 % more changes the clamping force by, the strongest first: restitution of stop jaw "
        f"+7 %, {stiffness} +0.7 %.",
        "These calm the bounce and press harder at the same time: "
        f"{stiffness} +20 % for a bounce lower by 10 % (clamping force +14 %); "
        f"{touch} -4 degrees for a bounce lower by 10 % (clamping force +12 %); "
        f"{preload} +2.5 mm for a bounce lower by 10 % (clamping force +2 %).",
        "The two ways to find them disagree, so that nothing is said of: pin rod forward.",
        "Without any effect while the shafts hold their speed: loss of spring steeve, mass and "
        "inertia of arm two, mass and inertia of crank.",
    )


def test_sentences_that_do_not_apply() -> None:
    """Nothing of a speed that is not asked for, of numbers without gain, or of none in doubt."""
    one = row("points.jaw.z_mm", "mm", 0.5, 5.0, -0.02)
    assert [line.split(",")[0] for line in conclusions(made_up(one))[1:]] == [
        f"What 1 mm more changes the {word} by"
        for word in ("first bounce", "transition", "clamping force")
    ]
    told = conclusions(made_up(one, holds=False))
    assert told[1].startswith("The machine does not arrive at the touch as a transition assumes:")
    assert len(told) == 5
    assert len(conclusions(made_up(one, holds=None))) == 4
    doubtful = conclusions(made_up(row("speed_rpm", "%", 2.0, 1.0, 1.0, off=0.1)))
    assert len(doubtful) == 2
    assert doubtful[1].endswith("nothing is said of: cylinder speed.")
    slower = conclusions(made_up(row("speed_rpm", "%", -2.0, 3.0, -0.5)))[1]
    assert "2 % lower, the transition 3 % longer and the clamping force 0.5 % smaller" in slower


@pytest.mark.parametrize(
    ("unit", "per", "helps"),
    [
        ("mm", (2.01, 1.0, -1.0), True), ("mm", (1.99, 1.0, -1.0), False),
        ("mm", (-2.01, -1.0, 1.0), True), ("mm", (2.01, -1.0, -1.0), False),
        ("mm", (2.01, 1.0, 1.0), False), ("mm", (-2.01, 1.0, 1.0), False),
        ("deg", (2.01, 1.0, -1.0), True), ("deg", (1.99, 1.0, -1.0), False),
        ("%", (0.51, 1.0, -1.0), True), ("%", (0.49, 1.0, -1.0), False),
        ("10 N/m", (90.0, 1.0, -1.0), False),
    ],
)  # fmt: skip
def test_what_helps(unit: str, per: tuple[float, float, float], helps: bool) -> None:
    """Bounce and time down, force up, for 10 % by a change that is small: 5 mm, 5 deg or 20 %."""
    text = " ".join(conclusions(made_up(row("points.jaw.z_mm", unit, *per))))
    assert ("calm the bounce" in text) is helps


def test_the_best_three_help_and_three_are_named() -> None:
    """Of four, the three that gain most force for the same bounce, the best first."""
    rows = [
        row(f"points.p{n}.x_mm", "mm", 10.0, 1.0, -float(n)) for n in (2, 4, 1, 3)
    ]  # fmt: skip
    text = conclusions(made_up(*rows))
    (helps,) = [line for line in text if line.startswith("These")]
    assert [helps.index(f"pin p{n} ") for n in (4, 3, 2)] == sorted(
        helps.index(f"pin p{n} ") for n in (4, 3, 2)
    )
    assert "pin p1" not in helps
    (forces,) = [line for line in text if "clamping force by" in line]
    assert forces.count("pin p") == 3
    assert "pin p1" not in forces


def test_doubt() -> None:
    """From a thousandth of the largest effect on, or of 0.1 % where all effects are smaller."""
    for per, off, doubtful in (
        ((5.0, 1.0, 1.0), 0.0049, False), ((5.0, 1.0, 1.0), 0.0051, True),
        ((0.01, 0.0, 0.0), 0.99e-4, False), ((0.01, 0.0, 0.0), 1.01e-4, True),
        ((5.0, 1.0, math.nan), 0.0, True),
    ):  # fmt: skip
        one = row("x", "%", *per, off=off)
        assert one.doubtful is doubtful
        if not math.isnan(per[2]):
            assert one.disagreement == pytest.approx(off)


def test_record_of_sensitivities() -> None:
    one = row("points.jaw.z_mm", "mm", 0.5, 5.0, -0.02, off=0.75)
    assert made_up(one, holds=None).record() == {
        "model": "mine", "speed_rpm": 612.5, "premise_holds": None,
        "rebound_amplitude_1": 2.346e-3, "duration_s": 6.789e-3, "mean_clamping_force_N": 147.26,
        "percent_per_unit": [
            {
                "path": "points.jaw.z_mm", "value": 3.0, "unit": "mm",
                "rebound_amplitude_1": 0.5, "duration_s": 5.0, "clamping_force_N": -0.02,
                "disagreement_of_two_ways": pytest.approx(0.75), "doubtful": True,
            }
        ],
    }  # fmt: skip


def test_rows_of_laws(monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    """Quantities that are powers of a number: their exponents are the percentages.

    Richardson's extrapolation of powers up to the third is exact but for round-off, 1e-10; the
    control is off by h^2 / 6 of the third derivative, with h = 1e-3 of the value: (n-1)(n-2) / 6.
    """
    asked: list[tuple[float, bool]] = []

    def law(mechanism: Mechanism, speed: float, *, true: bool, **_: object) -> np.ndarray:
        asked.append((speed, true))
        k = mechanism.springs[0].stiffness / 9000.0
        return np.array([3.0 * k**3, 0.5 * speed**2 / k, 100.0 * speed])

    monkeypatch.setattr(sensitivity, "_direct", law)
    monkeypatch.setattr(sensitivity, "_other", law)
    done: list[tuple[int, int]] = []
    paths = ("springs.steeve.stiffness_N_per_m", "speed_rpm")
    found = sensitivity.sensitivities(
        e62, 500.0, paths, progress=lambda *counts: done.append(counts)
    )
    assert done == [(1, 2), (2, 2)]
    assert {true for _, true in asked} == {False}
    assert (found.model, found.speed_rpm, found.premise_holds) == ("e62", 500.0, True)
    assert found.amplitude_rad == pytest.approx(3.0)
    assert found.transition_time_s == pytest.approx(0.5 * 500.0**2)
    assert found.clamping_force_N == pytest.approx(5e4)
    stiffness, speed = found.rows
    assert (stiffness.path, stiffness.value, stiffness.unit) == (paths[0], 9000.0, "%")
    assert (speed.path, speed.value, speed.unit) == ("speed_rpm", 500.0, "%")
    assert stiffness.per == pytest.approx([3.0, -1.0, 0.0], abs=1e-8)
    assert stiffness.control == pytest.approx([3.0 + 1e-6, -1.0 - 1e-6, 0.0], abs=1e-8)
    assert speed.per == pytest.approx([0.0, 2.0, 1.0], abs=1e-8)
    monkeypatch.setattr(sensitivity, "_direct", lambda *_, **__: np.array([1.0, 0.0, 2.0]))
    with pytest.raises(SimulationError, match=r"500 r/min: duration_s is zero") as caught:
        sensitivity.sensitivities(e62, 500.0, paths)
    assert caught.value.evidence["quantities"] == ["duration_s"]


def test_the_numbers_that_are_asked_for(e62: Mechanism) -> None:
    """All of the document but those that nothing sees, and the dimensions of pins and links."""
    paths = sensitivity.every_path(e62)
    assert paths[0] == "speed_rpm"
    document = Sources.of(e62).document
    tables = [path for path in paths[1:] if not path.startswith(("points.", "links."))]
    order = ["cylinder", "drives", "springs", "dampers", "stops"]
    places = [order.index(path.split(".")[0]) for path in tables]
    assert places == sorted(places)
    assert {"cylinder.angle_at_touch_deg", "drives.tension.ratio", "stops.jaw.restitution"} <= {
        *tables
    }
    for path in tables:
        value: object = document
        for step in path.split("."):
            value = value[step]  # type: ignore[index]
        assert isinstance(value, int | float)
    for unseen in ("rated_speed_rpm", "reference_index", "reflected_inertia_kg_m2"):
        assert not any(path.endswith(unseen) for path in paths)
    assert {path for path in paths if path.startswith("points.eccentric_pin.")} == {
        "points.eccentric_pin.radius_mm", "points.eccentric_pin.angle_deg",
    }  # fmt: skip
    assert {path for path in paths if path.startswith("points.jaw.")} == {
        "points.jaw.x_mm", "points.jaw.z_mm",
    }  # fmt: skip
    ofone = [path for path in paths if path.startswith("links.top_nipper.")]
    assert ofone == [
        f"links.top_nipper.{key}" for key in ("mass_kg", "gyration_mm", "com_x_mm", "com_z_mm")
    ]
