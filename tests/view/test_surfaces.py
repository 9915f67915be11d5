"""The terminal, CSV files, the figure of impulses and both pages show what the document has.

Each surface is read as a person reads it: numbers with the units that stand beside them, which say
by how much a number of the document is multiplied. A number that is missing fails as well. The
document and the motion themselves are judged in test_judged.py.
"""

from __future__ import annotations

import io
import math
import re
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from rich.console import Console
from runs_shown import TURNS, run_of
from units_shown import factor, force, impulse, index, kind, rows, unit_of

from nipper_pin import Case, Solution, load, load_solution, record, save, simulate
from nipper_pin.study.compare import Row
from nipper_pin.terms import Shown, digits, fixed
from nipper_pin.view.compare.words import difference_text, percent_text
from nipper_pin.view.live.answer import answer
from nipper_pin.view.live.settings import knobs
from nipper_pin.view.run import print_solution
from nipper_pin.view.run.bounces import impulse_figure
from nipper_pin.view.scene import Look, film
from nipper_pin.view.scene.readings import readings
from nipper_pin.view.studies.sweep_plots import short

DIGITS = 5.1e-4  # four digits
PLACES = 5.1e-4  # three decimals


class Told(NamedTuple):
    """A number that a surface shows.

    Attributes:
        of: Number of the collision, place of the phase, or nothing.
        name: The quantity, as the document calls it.
        value: The number.
        unit: What stands beside it.
        rel: How many digits it has, as a relative error.
        off: How many decimals it has, as an error.
    """

    of: int
    name: str
    value: float
    unit: str
    rel: float = DIGITS
    off: float = 0.0


def unit(run: Solution, name: str, stop: str) -> str:
    """The document's unit of a quantity."""
    if name in ("rebound_amplitude", "approach_rate", "separation_rate"):
        return kind(run, stop) + ("/s" if name.endswith("rate") else "")
    ends = {"_N_m_s": "N m s", "_N_s": "N s", "_J": "J", "_rad": "rad", "_s": "s"}
    return next((found for end, found in ends.items() if name.endswith(end)), "")


def is_told(told: Told, value: float, own: str) -> bool:
    """Whether a number that is shown is the document's, in the unit beside it."""
    wanted = factor(own, told.unit) * value
    return bool(told.value == pytest.approx(wanted, rel=told.rel, abs=told.off))


def printed(run: Solution) -> str:
    """All tables of the terminal."""
    stream = io.StringIO()
    print_solution(run, Console(file=stream, width=200), with_forces=True)
    return stream.getvalue()


def table(text: str, title: str) -> tuple[list[str], list[list[str]]]:
    """Headings of a printed table, those of several lines put together, and its rows.

    Numbers end at the right end of their column, so that a row tells where columns end.
    """
    above, below = text.split(title, 1)[1].split("───", 1)
    lines = below.split("\n", 1)[1].splitlines()
    count = next(k for k, line in enumerate([*lines, ""]) if not re.match(r"\s*\d+ (?!more)", line))
    ends = [match.end() for match in re.finditer(r"\S+", lines[0])]
    heads = above.splitlines()[1:]
    return [
        " ".join(" ".join(line[one:other] for line in heads).split())
        for one, other in zip([0, *ends[:-1]], ends, strict=True)
    ], [line.split() for line in lines[:count]]


# Collisions.

HEADINGS = {
    "no.": "number", "index": "index", "t": "t_s", "rate before": "approach_rate",
    "rate after": "separation_rate", "energy lost": "energy_lost_J",
    "rebound amplitude": "rebound_amplitude", "rebound time": "rebound_time_s",
}  # fmt: skip


def csv_collisions(run: Solution) -> Iterator[Told]:
    """All that the document has with all its digits, and the angle in degrees."""
    for row in rows(run, "collisions.csv"):
        number, stop = int(row["number"]), row.pop("stop")
        assert stop == run.collisions[number - 1].stop
        for name, text in row.items():
            if name == "cylinder_angle_deg":
                yield Told(number, "cylinder_angle_rad", float(text), "deg", 1e-15)
            elif text:
                yield Told(number, name, float(text), unit(run, name, stop), 0.0)


def at_hinge(run: Solution, stop: str, of: int, gap_mm: float) -> Told:
    """The rebound that a gap at the contact tells, which has four decimals."""
    per_mm = 1e-3 / run.mechanism.stop(stop).lever
    return Told(of, "rebound_amplitude", per_mm * gap_mm, "rad", 0.0, 0.501e-4 * per_mm)


def printed_collisions(run: Solution) -> Iterator[Told]:
    """A table for each stop; below it how many rebounds are too small for a row."""
    text = printed(run)
    for stop in sorted({hit.stop for hit in run.collisions}):
        own = f"Collisions of stop {stop} "
        heads, lines = table(text, own)
        for line in lines:
            for head, cell in zip(heads, line, strict=True):
                if head == "gap at the contact mm":
                    height = run.collisions[int(line[0]) - 1].rebound_amplitude
                    assert (cell == "-") is (height is None)
                    if height is not None:
                        assert is_told(at_hinge(run, stop, 1, float(cell)), height, "rad")
                    continue
                words = next(words for words in (*HEADINGS, "impulse") if head.startswith(words))
                name = HEADINGS.get(words) or impulse(run, stop)
                off = PLACES if words in ("index", "t") else 0.0
                if cell != "-":
                    shown = head.removeprefix(words).strip()
                    yield Told(int(line[0]), name, float(cell), shown, 0.0 if off else DIGITS, off)
        backs = [hit.rebound_amplitude for hit in run.collisions if hit.stop == stop]
        heights = [height for height in backs if height is not None]
        small = sum(height < 1e-3 * max(heights) for height in heights)
        block = text.split(own, 1)[1].split("\n\n", 1)[0]
        for count, limit, shown in re.findall(
            r"^(\d+) more rebounds? below (\S+) (\S+) ", block, re.M
        ):
            assert int(count) == small
            edge = Told(0, "rebound_amplitude", float(limit), shown)
            assert is_told(edge, 1e-3 * max(heights), kind(run, stop))
            small = 0
        assert small == 0


def bars(run: Solution) -> Iterator[Told]:
    """The figure of impulses: a mark on a bar from the ground, by numbers of collisions."""
    (axes,) = impulse_figure(run).axes
    units = {f"{force(run, hit.stop)} s" for hit in run.collisions}
    assert axes.get_ylabel().endswith(f"[{' or '.join(sorted(units))}]")
    for line, bar in zip(axes.lines, axes.collections, strict=True):
        stop = str(line.get_label()).removeprefix("stop ")
        ends: Any = bar.get_paths()
        np.testing.assert_array_equal([end.vertices[1] for end in ends], line.get_xydata())
        feet = {float(end.vertices[0][1]) for end in ends}
        assert feet == {axes.get_ylim()[0]}
        for number, value in line.get_xydata():
            assert run.collisions[int(number) - 1].stop == stop
            yield Told(int(number), impulse(run, stop), value, f"{force(run, stop)} s", 1e-14)


def page_collisions(run: Solution) -> Iterator[Told]:
    """Texts of the page, one for each event, from its time of the film on."""
    shown = film(run, Look(exaggerate=1.0))
    said: Any = readings(shown)["collisions"]
    for number, item in enumerate(said, start=1):
        t = float(np.interp(item["at"], shown.pace.playback, shown.pace.machine))
        yield Told(number, "t_s", t, "s", 1e-9)
        told = re.findall(r"(\d+) \((\w+)\): impulse (\S+) ([^;]+)", item["text"])
        together = [hit for hit in run.collisions if hit.t == run.collisions[number - 1].t]
        assert [int(part[0]) for part in told] == [hit.number for hit in together]
        (own,) = (part for part in told if int(part[0]) == number)
        assert (own[1], item["stop"]) == (run.collisions[number - 1].stop,) * 2
        yield Told(number, impulse(run, own[1]), float(own[2]), own[3])


COLLISIONS: dict[str, Callable[[Solution], Iterator[Told]]] = {
    "csv": csv_collisions, "terminal": printed_collisions, "impulses": bars,
    "page": page_collisions,
}  # fmt: skip


@pytest.mark.parametrize("surface", COLLISIONS)
@pytest.mark.parametrize("name", TURNS)
def test_collisions(name: str, surface: str) -> None:
    """Numbers of each are the document's; each that has a place on the surface is there, once."""
    run = run_of(name)
    document: Any = record(run)["collisions"]
    counts: Counter[tuple[int, str]] = Counter()
    for told in COLLISIONS[surface](run):
        row = document[told.of - 1]
        counts[told.of, told.name] += 1
        assert is_told(told, row[told.name], unit(run, told.name, row["stop"])), told
    every = {(row["number"], key) for row in document for key, value in row.items()
             if value is not None and key != "stop"}  # fmt: skip
    impulses = {(number, key) for number, key in every if key.startswith("impulse_N")}
    named = {*HEADINGS.values(), *(key for _, key in impulses)}
    # Rebounds too small for a row are counted below the table.
    rows_there = {number for number, _ in counts}
    wanted = {
        "csv": every,
        "terminal": {
            (number, key) for number, key in every if number in rows_there and key in named
        },
        "impulses": impulses,
        "page": impulses | {pair for pair in every if pair[1] == "t_s"},
    }[surface]
    angles = {pair: 2 for pair in every if pair[1] == "cylinder_angle_rad"}
    assert counts == dict.fromkeys(wanted, 1) | (angles if surface == "csv" else {})


# Phases.


def numbered(run: Solution, row: dict[str, Any]) -> bool:
    """False where the transition stop is open and does not bounce: that is no phase."""
    stop = run.mechanism.transition_stop
    return bool(row["closed_stops"]) or any(
        hit.stop == stop and row["t_start_s"] <= hit.t < row["t_end_s"] for hit in run.collisions
    )


def csv_phases(run: Solution) -> Iterator[Told]:
    for place, row in enumerate(rows(run, "phases.csv")):
        document: Any = record(run)["phases"][place]  # type: ignore[index]
        assert row["closed_stops"].split() == document["closed_stops"]
        assert row["phase"] == str(document["phase"] or "")
        for key in ("t_start_s", "t_end_s"):
            yield Told(place, key, float(row[key]), "s", 0.0)
        for key in ("start_index", "end_index"):
            yield Told(place, key, float(row[key]), "", 0.0, 1e-9)


def printed_phases(run: Solution) -> Iterator[Told]:
    """Its number or what it is instead, closed stops, indices, start and length."""
    block = printed(run).split("\nPhases", 1)[1]
    assert block.split("───")[0].split()[-2:] == ["ms", "ms"]
    for place, line in enumerate(block.split("─\n", 1)[1].split("\n\n", 1)[0].splitlines()):
        document: Any = record(run)["phases"][place]  # type: ignore[index]
        words, values = line.split()[:-4], [float(cell) for cell in line.split()[-4:]]
        own = document["closed_stops"] or ["none"]
        assert " ".join(words).endswith(", ".join(own))
        if numbered(run, document) and document["phase"]:
            assert words[0] == str(document["phase"])
        elif not numbered(run, document):
            assert line.startswith(f"{run.mechanism.transition_stop} open")
        for key, value, shown in zip(("start_index", "end_index", "t_start_s", "duration_s"),
                                     values, ("", "", "ms", "ms"), strict=True):  # fmt: skip
            yield Told(place, key, value, shown, 0.0, PLACES)


def page_phases(run: Solution) -> Iterator[Told]:
    shown = film(run, Look(exaggerate=1.0))
    said: Any = readings(shown)["phases"]
    for place, item in enumerate(said):
        document: Any = record(run)["phases"][place]  # type: ignore[index]
        start = "phase" if numbered(run, document) else f"{run.mechanism.transition_stop} open"
        assert item["name"].startswith(start)
        if numbered(run, document) and document["phase"]:
            assert item["name"].split()[1] == str(document["phase"])
        t = float(np.interp(item["start"], shown.pace.playback, shown.pace.machine))
        yield Told(place, "t_start_s", t, "s", 1e-9, 1e-12)


PHASES = {
    "csv": (csv_phases, {"t_start_s", "t_end_s", "start_index", "end_index"}),
    "terminal": (printed_phases, {"t_start_s", "duration_s", "start_index", "end_index"}),
    "page": (page_phases, {"t_start_s"}),
}


@pytest.mark.parametrize("surface", PHASES)
@pytest.mark.parametrize("name", TURNS)
def test_phases(name: str, surface: str) -> None:
    """Starts, ends and lengths of all phases."""
    run = run_of(name)
    document: Any = record(run)["phases"]
    read, names = PHASES[surface]
    seen = set()
    for told in read(run):
        row = document[told.of]
        values = row | {
            "duration_s": row["t_end_s"] - row["t_start_s"],
            "start_index": index(run, row["t_start_s"]), "end_index": index(run, row["t_end_s"]),
        }  # fmt: skip
        seen.add((told.of, told.name))
        value = values[told.name]
        # Before an index of zero stands forty.
        if told.name.endswith("index") and abs(told.value - value) > 20.0:
            value += math.copysign(40.0, told.value - value)
        assert is_told(told, value, unit(run, told.name, "")), told
    assert seen == {(place, key) for place in range(len(document)) for key in names}


def test_a_saved_run_shows_the_same(tmp_path: Path) -> None:
    """Sides and places of stops survive a file."""
    run = run_of("boxed")
    again = load_solution(save(run, tmp_path / "box"))
    assert record(again)["collisions"] == record(run)["collisions"]
    assert printed(again) == printed(run)


# Velocities of links, and numbers of a transition.


@pytest.mark.parametrize("name", TURNS)
def test_link_velocities(name: str) -> None:
    """The file has them before and after each collision, with all their digits."""
    run = run_of(name)
    found = iter(rows(run, "link_velocities.csv"))
    for hit in run.collisions:
        sides = dict(zip(("before", "after"), run.link_velocities(hit.event), strict=True))
        for place, link in enumerate(sides["before"].links):
            row = next(found)
            assert (row.pop("collision"), row.pop("link")) == (str(hit.number), link)
            wanted = {}
            for word, side in sides.items():
                wanted[f"angular_{word}_rad_s"] = side.angular[place]
                for axis, value in zip("xz", side.centroid[place], strict=True):
                    wanted[f"centroid_{axis}_{word}_m_s"] = value
            assert {key: float(text) for key, text in row.items()} == wanted
    assert next(found, None) is None


def of_transition(run: Solution) -> dict[str, float]:
    """The document's, by what the live page calls them."""
    document: Any = record(run)
    first, whole = document["collisions"][0], document["transition"]
    return {
        "amplitude": first["rebound_amplitude"], "rebound": first["rebound_time_s"],
        "duration": whole["duration_s"], "collisions": whole["collisions"],
        "share": whole["first_two_share"], "approach": first["approach_rate"],
        "impulse": first["impulse_N_s"],
    }  # fmt: skip


UNITS = {"amplitude": "rad", "rebound": "s", "duration": "s", "collisions": "", "share": "",
         "approach": "rad/s", "impulse": "N s"}  # fmt: skip
SETTINGS = (
    {},
    {"speed": 700.0, "restitution": 0.35},
    {"speed": 545.0, "restitution": 0.05, "stiffness": 11.0, "preload": 8.0},
)


@pytest.mark.parametrize("setting", SETTINGS)
def test_live_page(setting: dict[str, float]) -> None:
    """Numbers and curves of a setting of the sliders: those of a run of the model's file.

    All sliders move the numbers by more than their digits, so one without effect, or with another
    one's, fails.
    """
    mechanism = load("e62")
    controls = knobs(mechanism, 650.0)
    asked = {item.key: setting.get(item.key.rpartition(".")[2], item.start) for item in controls}
    found = answer(mechanism, controls, asked)
    values = {"speed": 650.0, "restitution": 0.2, "stiffness": 9.0, "preload": 11.0} | setting
    speed, values["stiffness"] = values.pop("speed"), 1e3 * values["stiffness"]
    run = simulate(load("e62", values), Case(speed_rpm=speed))
    wanted = of_transition(run)
    told = {row.key: (row.label, row.text) for row in found.rows}
    label, text = told.pop("lips")
    assert label == "gap at the contact [mm]"
    assert is_told(at_hinge(run, "jaw", 1, float(text)), wanted["amplitude"], "rad")
    assert list(told) == [*wanted, "engine"]
    for key, value in wanted.items():
        label, text = told[key]
        shown = unit_of(label) if "[" in label else ""
        assert is_told(Told(1, key, float(text), shown), value, UNITS[key]), key
    hits: Any = record(run)["collisions"]
    times, impulses = found.impulse
    np.testing.assert_allclose(times, [1e3 * row["time_s"] for row in hits], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(impulses, [row["impulse_N_s"] for row in hits], rtol=1e-9)
    t, drawn = found.gap
    assert (np.diff(t) > 0.0).all()
    bouncing = t <= 1e3 * run.segments[-1].t_end
    states = run.trajectory.evaluate(1e-3 * t[bouncing]).q
    gap = factor("rad", "mdeg") * run.mechanism.stop("jaw").gaps(states)
    np.testing.assert_allclose(drawn[bouncing], gap, rtol=0.0, atol=1e-6 * gap.max())
    assert not drawn[~bouncing].any()


MM = Shown(words="gap", unit="mm", factor=1e3)
TENTHS = Shown(words="gap", unit="mm", factor=1e3, decimals=1)
BARE = Shown(words="ratio", unit="")

FORMATS: dict[str, tuple[Callable[[Any], str], dict[Any, str]]] = {
    # Four digits; powers of ten below a thousandth and from a million on.
    "digits": (digits, {
        None: "-", 0.0: "0", 1.0: "1.000", -12.34567: "-12.35", 123.456: "123.5",
        1234.56: "1235", 12345.6: "12346", 999_999.4: "999999", 1e6: "1.000e6",
        0.00123456: "0.001235", 1e-3: "0.001000", 9.99e-4: "9.990e-4", 1.23456e-12: "1.235e-12",
        -4.5e15: "-4.500e15",
    }),
    "fixed": (partial(fixed, decimals=2), {
        0.0: "0.00", -1e-9: "0.00", -0.004: "0.00", -0.006: "-0.01", 2.675: "2.67", 1e3: "1000.00",
    }),
    "no decimals": (partial(fixed, decimals=0), {0.4: "0", -0.4: "0", 1.6: "2", -1.6: "-2"}),
    # Beside an axis: three digits, whole numbers from a thousand to a million.
    "short": (short, {
        0.0: "0", 0.12345: "0.123", 12.345: "12.3", 999.4: "999", 1e3: "1000", -1234.5: "-1234",
        999_999.0: "999999", 1e6: "1e+06", 1.2345e-5: "1.23e-05",
    }),
    # Differences: as many decimals as leave three digits.
    "difference": (percent_text, {
        0.0: "< 0.01 %", -0.00499: "< 0.01 %", 0.0051: "+0.01 %", -9.994: "-9.99 %",
        10.04: "+10.0 %", -999.94: "-999.9 %", 1000.4: "+1000 %",
    }),
    # In tables of a comparison, by what the unit and the values let one say.
    "row": (lambda given: difference_text(Row(*given)), {
        ("duration_s", "s", 2.0, 2.2): "+10.0 %", ("duration_s", "s", 2.0, 1.99): "-0.50 %",
        ("duration_s", "s", 2.0, 2.0000001): "< 0.01 %", ("duration_s", "s", 2.0, 2.0): "0",
        ("duration_s", "s", 1.0, 31.0): "+3000 %", ("duration_s", "s", None, 2.0): "-",
        ("energy_lost_turn_J", "J", 0.0, 0.002): "+2.000 mJ",
        ("closing_index", "", 34.0, 34.25): "+0.250",
        ("closing_index", "", 34.0, 34.0 + 1e-9): "< 0.001",
        ("collisions_jaw", "", 6.0, 4.0): "-2",
    }),
    "text": (MM.text, {None: "-", math.nan: "-", 0.00123456: "1.235", -2e-7: "-2.000e-4"}),
    "phrase": (TENTHS.phrase, {None: "- mm", 0.00126: "1.3 mm", -1e-5: "0.0 mm"}),
    "no unit": (BARE.phrase, {0.5: "0.5000", None: "-"}),
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "value", "wanted"),
    [(name, value, text) for name, (_, table) in FORMATS.items() for value, text in table.items()],
)
def test_a_number_as_it_is_read(name: str, value: Any, wanted: str) -> None:
    assert FORMATS[name][0](value) == wanted
