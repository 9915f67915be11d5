"""What a campaign says of its trials: verdicts, shares, records and case files, all made up."""

from __future__ import annotations

import hashlib
import json
import warnings
from dataclasses import asdict
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mpmath
import pytest

from benchmarks.stress import judging, refusals
from benchmarks.stress.campaign import Campaign
from benchmarks.stress.checks.invariants import Violation
from benchmarks.stress.files import begin, keep
from benchmarks.stress.judging import Verdict, judge
from benchmarks.stress.machines.parts import Source
from benchmarks.stress.refusals import Excess, allowed_share, excesses
from benchmarks.stress.space import Trial
from nipper_pin.errors import InputError, SelfCheckError, SimulationError
from nipper_pin.hybrid.case import Window
from nipper_pin.hybrid.run.outcome import Outcome


def verdict(
    number: int, family: str = "speed", word: str = "right", kind: str = "AT_REST"
) -> Verdict:
    return Verdict(number, family, word, kind, f"because {number}", f"f{number}", 0.5)


TRIAL: Any = SimpleNamespace(number=7, family="edges")


def sha(text: bytes) -> str:
    return hashlib.sha256(text).hexdigest()


def test_verdicts_of_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Right with its outcome; wrong by its first violation, six of them told."""
    found = [Violation(f"k{n}", f"d{n}") for n in range(8)]
    monkeypatch.setattr(judging, "_run", lambda _: ("AT_REST", b"bits", []))
    one = judge(TRIAL)
    assert (one.number, one.family, one.word, one.kind, one.detail) == (
        7, "edges", "right", "AT_REST", "",
    )  # fmt: skip
    assert one.fingerprint == sha(b"bits")
    assert one.wall_s >= 0.0
    monkeypatch.setattr(judging, "_run", lambda _: ("AT_REST", b"bits", found))
    one = judge(TRIAL)
    assert (one.word, one.kind) == ("wrong", "k0")
    assert one.detail == "k0: d0; k1: d1; k2: d2; k3: d3; k4: d4; k5: d5"


@pytest.mark.parametrize(
    ("error", "word", "kind", "detail"),
    [
        (InputError("no such"), "refused", "InputError", "no such"),
        (SimulationError("please report it"), "wrong", "confession", "please report it"),
        (SimulationError(""), "wrong", "confession", ""),
        (ValueError("a shape"), "wrong", "traceback", "ValueError: a shape"),
    ],
)
def test_verdicts_of_errors(
    monkeypatch: pytest.MonkeyPatch, error: Exception, word: str, kind: str, detail: str
) -> None:
    def run(_: Trial) -> Any:
        raise error

    monkeypatch.setattr(judging, "_run", run)
    one = judge(TRIAL)
    assert (one.word, one.kind) == (word, kind)
    if kind == "traceback":
        assert detail in one.detail
        assert "in run" in one.detail
    else:
        assert one.detail == detail
        assert one.fingerprint == sha(f"{word} {kind} {detail}".encode())


def test_hangs_and_warnings(monkeypatch: pytest.MonkeyPatch) -> None:
    """A warning is a fault; what takes longer than its time of the processor is a hang."""

    def endless(_: Trial) -> Any:
        while True:
            pass

    monkeypatch.setattr(judging, "_run", endless)
    one = judge(TRIAL, 0.05)
    assert (one.word, one.kind, one.detail) == ("wrong", "hang", "no end after 0.05 s")
    monkeypatch.setattr(judging, "_run", lambda _: warnings.warn("small", stacklevel=1))
    assert "UserWarning: small" in judge(TRIAL).detail


class Runs:
    """A trial whose runs are told: by their machine and their tolerance."""

    number, family = 1, "edges"

    def __init__(self, monkeypatch: pytest.MonkeyPatch, tolerance: float, **changes: Any) -> None:
        self.case = {
            "speed_rpm": 300.0, "resolution": {"tolerance": tolerance}, "window": Window.TRANSITION,
        }  # fmt: skip
        self.image: Any = SimpleNamespace(name="image")
        self.refused: tuple[str, ...] = ()
        self.runs: list[tuple[str, float]] = []
        self.solution = {"evaluations": 100_000, "outcome": Outcome.AT_REST, **changes}
        monkeypatch.setattr(judging, "simulate", self.simulate)
        monkeypatch.setattr(judging, "violations", lambda one: [f"own {one.name}"])
        monkeypatch.setattr(judging, "need_sound", lambda _: None)
        monkeypatch.setattr(judging, "bits", lambda one: f"bits {one.name}".encode())
        for name in ("same_bits", "within_errors", "mirror_images", "engines_agree"):
            monkeypatch.setattr(judging, name, lambda *s, name=name: [(name, *map(self.told, s))])

    @staticmethod
    def told(item: Any) -> Any:
        return item if isinstance(item, float) else (item.name, item.tolerance)

    def mechanism(self) -> Any:
        return SimpleNamespace(name="machine")

    def mirror_image(self) -> Any:
        return self.image

    def simulate(self, machine: Any, case: Any) -> Any:
        tolerance = case.resolution.tolerance
        name = machine.name if tolerance == self.case["resolution"]["tolerance"] else "finer"  # type: ignore[index]
        if name in self.refused:
            raise SimulationError(name)
        self.runs.append((machine.name, tolerance))
        return SimpleNamespace(name=name, tolerance=tolerance, **self.solution)


def test_each_trial_is_run_in_four_ways(monkeypatch: pytest.MonkeyPatch) -> None:
    item: Any = Runs(monkeypatch, 1e-9)
    outcome, kept, found = judging._run(item)
    assert (outcome, kept) == ("AT_REST", b"bits machine")
    one, fine = ("machine", 1e-9), ("finer", 1e-9 / 16.0)
    assert found == [
        "own machine", ("same_bits", one, one), ("within_errors", one, fine),
        ("mirror_images", one, ("image", 1e-9)), ("engines_agree", one, 1e-9),
    ]  # fmt: skip
    assert item.runs == [("machine", 1e-9), ("machine", 1e-9), ("machine", 1e-9 / 16.0),
                         ("image", 1e-9)]  # fmt: skip


def test_a_right_run_that_refuses_itself_is_a_violation(monkeypatch: pytest.MonkeyPatch) -> None:
    """It would be counted among the refused ones otherwise, which may be any."""

    def refuse(_: Any) -> None:
        message = "this run fails its own check"
        raise SelfCheckError(message)

    item: Any = Runs(monkeypatch, 1e-9)
    monkeypatch.setattr(judging, "need_sound", refuse)
    assert judging._run(item)[2][1] == Violation("self-check", "this run fails its own check")


@pytest.mark.parametrize(
    ("tolerance", "changes", "names"),
    [
        (1e-9, {"evaluations": 100_001}, []),
        (1e-9, {"outcome": Outcome.NO_REST}, ["same_bits", "within_errors", "mirror_images"]),
        (1e-14, {}, ["same_bits", "mirror_images", "engines_agree"]),
        (1.5e-14, {}, ["same_bits", "within_errors", "mirror_images", "engines_agree"]),
    ],
)  # fmt: skip
def test_ways_that_are_left_out(
    monkeypatch: pytest.MonkeyPatch, tolerance: float, changes: dict[str, Any], names: list[str]
) -> None:
    """Long runs are run once, and the finest tolerance has no finer one."""
    item: Any = Runs(monkeypatch, tolerance, **changes)
    _, kept, found = judging._run(item)
    assert kept == b"bits machine"
    assert [line if isinstance(line, str) else line[0] for line in found] == ["own machine", *names]
    if tolerance == 1.5e-14:
        assert found[2][2] == ("finer", 1e-14)


def test_ways_that_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    item: Any = Runs(monkeypatch, 1e-9)
    item.refused, item.image = ("finer",), None
    names = [line if isinstance(line, str) else line[0] for line in judging._run(item)[2]]
    assert names == ["own machine", "same_bits", "engines_agree"]
    other: Any = Runs(monkeypatch, 1e-9)
    other.refused = ("image",)
    other.case["window"] = Window.CYCLE
    names = [line if isinstance(line, str) else line[0] for line in judging._run(other)[2]]
    assert names == ["own machine", "same_bits", "within_errors"]


def test_shares_that_may_be_refused() -> None:
    """A fifth and 0.02 more than was measured on 385 cases, never beyond half the way."""
    assert allowed_share("spring") == pytest.approx(0.02)
    assert allowed_share("grazing") == pytest.approx(1.2 * 89 / 385 + 0.02)
    assert allowed_share("dead centre") == pytest.approx(0.5 * (1.0 + 289 / 385))
    mean = sum(refusals.MEASURED.values()) / len(refusals.MEASURED) / 385
    assert allowed_share("all") == allowed_share("a new one") == pytest.approx(1.2 * mean + 0.02)


@pytest.mark.parametrize(("family", "cases"), [("spring", 40), ("grazing", 60), ("reach", 385)])
def test_excesses_are_those_of_the_binomial_law(family: str, cases: int) -> None:
    """From so many refusals on as chance brings once in a million, in 40 digits."""
    with mpmath.workdps(40):
        share = mpmath.mpf(allowed_share(family))
        terms = [
            mpmath.binomial(cases, k) * share**k * (1 - share) ** (cases - k)
            for k in range(cases + 1)
        ]
        first = next(k for k in range(cases + 1) if mpmath.fsum(terms[k:]) < 1e-6)
    for refused in (first - 1, first):
        verdicts = [verdict(n, family, "refused" if n < refused else "right") for n in range(cases)]
        found = [item for item in excesses(verdicts) if item.family == family]
        assert found == ([Excess(family, first, cases, float(share))] if refused == first else [])
    assert excesses([verdict(1, family), verdict(2, family, "wrong")]) == []


def test_record_of_a_campaign(monkeypatch: pytest.MonkeyPatch) -> None:
    verdicts = (
        verdict(0), verdict(1, "edges", "wrong", "hang"),
        verdict(2, word="refused", kind="InputError"), verdict(3, "edges", kind="NO_REST"),
        verdict(4, word="refused", kind="AError"),
        verdict(5),
    )  # fmt: skip
    excess = Excess("speed", 2, 4, 0.25)
    monkeypatch.setattr("benchmarks.stress.campaign.excesses", lambda _: [excess])
    found = Campaign(9, verdicts, 12.5).record()
    assert found == {
        "cases": 6, "right": 3, "refused": 2, "wrong": 1, "seed": 9, "wall_s": 12.5,
        "errors": {"AError": 1, "InputError": 1, "hang": 1},
        "outcomes": {"AT_REST": 2, "NO_REST": 1},
        "families": {"speed": {"right": 2, "refused": 2, "wrong": 0},
                     "edges": {"right": 1, "refused": 0, "wrong": 1}},
        "failures": [{"number": 1, "family": "edges", "kind": "hang", "detail": "because 1"}],
        "refused_too_often": [asdict(excess)], "digest": sha(b"f0f1f2f3f4f5"),
    }  # fmt: skip
    assert list(found["errors"]) == ["AError", "InputError", "hang"]
    assert list(found["outcomes"]) == ["AT_REST", "NO_REST"]


def test_case_files(tmp_path: Path) -> None:
    """A wrong trial is a saved case, and its file says what was wrong; others are a line each."""
    source = Source("one", "<robot/>", {"format": 1}, str(tmp_path))
    case = {"speed_rpm": 300.0, "rest_rate": 1e-3, "resolution": {"tolerance": 1e-8}}
    item = Trial(number=42, seed=3, family="edges", source=source, case=case)
    folder = tmp_path / "new"
    begin(folder)
    wrong, right = verdict(42, "edges", "wrong", "hang"), verdict(43)
    for one in (wrong, right):
        keep(item, one, folder)
    assert {path.name for path in folder.iterdir()} == {"trial-42.json", "verdicts.jsonl"}
    document = json.loads((folder / "trial-42.json").read_text(encoding="utf-8"))
    assert document["stress"] == {
        "seed": 3, "number": 42, "family": "edges", "word": "wrong", "kind": "hang",
        "detail": "because 42",
    }  # fmt: skip
    assert document["mechanism"] == asdict(source)
    assert document["case"]["speed_rpm"] == 300.0
    assert document["case"]["resolution"]["tolerance"] == 1e-8
    lines = (folder / "verdicts.jsonl").read_text(encoding="utf-8").splitlines()
    assert [Verdict(**json.loads(line)) for line in lines] == [wrong, right]
    with pytest.raises(InputError, match="verdicts of another campaign"):
        begin(folder)


def test_measured_refusals_are_the_published_ones() -> None:
    """The table of families in benchmarks/README.md."""
    text = (Path(__file__).parents[3] / "benchmarks/README.md").read_text(encoding="utf-8")
    table = text.partition("| family | what varies | refused |\n")[2].partition("\n\n")[0]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()[1:]]
    assert {name: int(refused) for name, _, refused in rows} == refusals.MEASURED
