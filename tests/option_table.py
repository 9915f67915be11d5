"""For every option of every command: a command line, and all that it may change.

The facts are those of :mod:`command_probe`. A fact of a case or a model has the same value in what
the library is asked, in the case that is saved, in the saved run and in the JSON document.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

GONE = "gone"
"""The fact that is there without the option is not there with it."""


@dataclass(frozen=True)
class Entry:
    """One option.

    Attributes:
        words: What is added to the command line; for an argument the new last word.
        effect: All facts that change, with their values.
        base: The command line that it is added to, after the command.
        moves: Beginnings of facts that have to change, by as much as the run itself decides.
    """

    words: str
    effect: dict[str, Any] = field(default_factory=dict)
    base: str = ""
    moves: tuple[str, ...] = ()


_PLACES = ("simulate", "plot_solution.solution", "saved case", "saved run")
_OUT = "--out run"
_JSON = "--json -"
_RUN_FILES = ("case.json", "collisions.csv", "link_velocities.csv", "motion.csv", "phases.csv",
              "solution.npz", "drawn.png")  # fmt: skip
_PRELOAD = "description.springs.steeve.preload_length_mm"
_STIFFNESS = "description.springs.steeve.stiffness_N_per_m"
_RESTITUTION = "description.stops.jaw.restitution"
_HITS = ("document.collisions.",)


def case(key: str, value: object) -> dict[str, object]:
    """One field of a case: asked for, and saved three times."""
    return {
        f"simulate.case.{key}": value,
        f"plot_solution.solution.case.{key}": value,
        f"document.case.{key}": value,
        f"saved case.case.{key}": value,
        f"saved run.case.{key}": value,
    }


def model(key: str, value: object, shown: str = "") -> dict[str, object]:
    """One number of a model: simulated, saved twice, and in the document if it has a shortcut."""
    found = {f"{place}.mechanism.{key}": value for place in _PLACES}
    return {**found, **({f"document.case.{shown}": value} if shown else {})}


def files(*names: str) -> dict[str, bool]:
    return {f"file {name}": True for name in names}


def seen(key: str, value: object) -> dict[str, object]:
    """One field of a case that is simulated and shown."""
    return {f"simulate.{key}": value, f"write_page.solution.{key}": value}


def of_a_model(*places: str, base: str = "") -> dict[str, Entry]:
    """Options that change a number of a model, for a command that asks ``places`` of one."""
    return {
        name: Entry(words, {f"{place}.mechanism.{path}": value for place in places}, base)
        for name, words, path, value in (
            ("--set", "--set preload=9.25", _PRELOAD, 9.25),
            ("--restitution", "--restitution 0.1", _RESTITUTION, 0.1),
            ("--stiffness", "--stiffness 11000", _STIFFNESS, 11000.0),
        )
    }


DOCUMENT = {"stdout": "document", "document.done": "well", "forces": GONE}
_TURNS = f"--window cycle {_OUT} {_JSON}"
_BOTH = f"{_OUT} {_JSON}"
SIMULATE = {
    "MODEL": Entry("hanging_pendulum", {"simulate.mechanism.name": "hanging_pendulum"},
                   moves=("simulate.",)),
    "--set": Entry("--set preload=9.25", model(_PRELOAD, 9.25, "preload_length_mm"), _BOTH, _HITS),
    "--restitution": Entry("--restitution 0.1", model(_RESTITUTION, 0.1, "restitution"), _BOTH,
                           _HITS),
    "--stiffness": Entry("--stiffness 11000", model(_STIFFNESS, 11000.0, "stiffness_N_per_m"),
                         _BOTH, _HITS),
    "--speed": Entry("--speed 500", case("speed_rpm", 500.0), _BOTH, _HITS),
    "--json": Entry("--json -", {"stdout": "document", "forces": GONE}, moves=("document.",)),
    "--window": Entry("--window cycle", case("window", "cycle"), _BOTH, _HITS),
    "--start-index": Entry("--start-index 20", case("start_index", 20.0), _TURNS,
                           ("document.phases.",)),
    "--cycles": Entry("--cycles 2", case("cycles", 2), _TURNS, _HITS),
    "--drive": Entry("--drive inertial", case("drive", "inertial"), _BOTH, _HITS),
    "--rest-rate": Entry("--rest-rate 0.5", case("rest_rate", 0.5), _BOTH,
                         ("document.transition.duration_s",)),
    "--tolerance": Entry("--tolerance 1e-6", case("resolution.tolerance", 1e-6), _BOTH,
                         ("document.work.evaluations",)),
    "--no-reuse": Entry("--no-reuse", case("reuse_cycles", False), f"--cycles 3 {_TURNS}",
                        ("document.work.turns_computed",)),
    "--reuse": Entry("--reuse", case("reuse_cycles", True), f"--cycles 3 --no-reuse {_TURNS}",
                     ("document.work.turns_computed",)),
    "--forces": Entry("--forces", {"forces": True}, "--window cycle"),
    "--out": Entry("--out run", {**files(*(f"run/{name}" for name in _RUN_FILES)),
                                 "plot_solution called": True},
                   moves=("saved case.", "saved run.", "plot_solution.solution.")),
    "--case": Entry("--case {case}", {"simulate.case.speed_rpm": 620.0,
                                      "document.case.speed_rpm": 620.0}, _JSON, _HITS),
}  # fmt: skip

_PAGE = "--window transition --html a.html"
VIEW = {
    "MODEL": Entry("hanging_pendulum", {"simulate.mechanism.name": "hanging_pendulum",
                                        **seen("case.speed_rpm", 220.0)}, _PAGE,
                   ("simulate.mechanism.", "write_page.solution.")),
    **of_a_model("simulate", "write_page.solution", base=_PAGE),
    "--speed": Entry("--speed 500", seen("case.speed_rpm", 500.0), _PAGE),
    "--json": Entry("--json run.json", files("run.json"), _PAGE, ("in run.json.",)),
    "--window": Entry("--window transition", seen("case.window", "transition"), "--html a.html"),
    "--start-index": Entry("--start-index 20", seen("case.start_index", 20.0), "--html a.html"),
    "--solution": Entry(
        "--solution {run}",
        {"load_solution.path": "{run}", "load_solution called": True, "simulate called": GONE,
         "write_page.solution.case.speed_rpm": 620.0,
         "write_page.solution.case.window": "transition"}, "--html a.html", ("simulate.",)),
    "--slow": Entry("--slow 50", {"write_page.look.slow": 50.0}, _PAGE),
    "--exaggerate": Entry("--exaggerate 7", {"write_page.look.exaggerate": 7.0}, _PAGE),
    "--html": Entry("--html b.html", {**files("b.html"), "write_page called": True,
                                      "write_page.path": "b.html"}, "--gif a.gif",
                    ("write_page.",)),
    "--gif": Entry("--gif b.gif", {**files("b.gif"), "write_gif called": True,
                                   "write_gif.path": "b.gif"}, _PAGE, ("write_gif.",)),
    "--port": Entry("--port 7123", {"serve.port": 7123}, "--window transition"),
    "--no-browser": Entry("--no-browser", {"serve.browser": False}, "--window transition"),
}  # fmt: skip
LIVE = {
    "MODEL": Entry("hanging_pendulum", {"serve_live.mechanism.name": "hanging_pendulum",
                                        "serve_live.speed_rpm": 220.0},
                   moves=("serve_live.mechanism.",)),
    **of_a_model("serve_live"),
    "--speed": Entry("--speed 500", {"serve_live.speed_rpm": 500.0}),
    "--port": Entry("--port 7123", {"serve_live.port": 7123}),
    "--no-browser": Entry("--no-browser", {"serve_live.browser": False}),
}  # fmt: skip
_BRIEF = "--window transition"
_SIDES = ("compare.a", "compare.b", "simulate")
_FOLLOWS = ("print_comparison.",)


def sides(key: str, value: object, *places: str) -> dict[str, object]:
    """One fact of both sides of a comparison, or of some; the last run is that of B."""
    return {f"{place}.{key}": value for place in places or _SIDES}


COMPARE = {
    "A": Entry("hanging_pendulum", sides("mechanism.name", "hanging_pendulum"), _BRIEF,
               (*(f"{place}." for place in _SIDES), *_FOLLOWS)),
    "B": Entry("hanging_pendulum", sides("mechanism.name", "hanging_pendulum", *_SIDES[1:]),
               f"{_BRIEF} e62", (*(f"{place}." for place in _SIDES[1:]), *_FOLLOWS)),
    **{name: replace(item, moves=_FOLLOWS)
       for name, item in of_a_model(*_SIDES, base=_BRIEF).items()},
    "--set-a": Entry("--set-a preload=9.25", sides(f"mechanism.{_PRELOAD}", 9.25, "compare.a"),
                     _BRIEF, _FOLLOWS),
    "--set-b": Entry("--set-b speed=500", sides("case.speed_rpm", 500.0, *_SIDES[1:]), _BRIEF,
                     _FOLLOWS),
    "--speed": Entry("--speed 450 500", sides("case.speed_rpm", 500.0, *_SIDES[1:]), _BRIEF,
                     _FOLLOWS),
    "--window": Entry("--window transition", sides("case.window", "transition"), moves=_FOLLOWS),
    "--start-index": Entry("--start-index 20", sides("case.start_index", 20.0), moves=_FOLLOWS),
    "--cycles": Entry("--cycles 2", sides("case.cycles", 2), moves=_FOLLOWS),
    "--drive": Entry("--drive held inertial", sides("case.drive", "inertial", *_SIDES[1:]), _BRIEF,
                     _FOLLOWS),
    "--html": Entry("--html b.html", {**files("b.html"), "write_comparison called": True,
                                      "write_comparison.path": "b.html"}, _BRIEF,
                    ("write_comparison.", *_FOLLOWS)),
    "--browser": Entry("--browser", {"serve called": True, "serve.browser": True,
                                     "comparison_page called": True}, _BRIEF,
                       ("serve.", "comparison_page.")),
    "--slow": Entry("--slow 50", {"write_comparison.look.slow": 50.0}, f"{_BRIEF} --html a.html"),
    "--exaggerate": Entry("--exaggerate 7", {"write_comparison.look.exaggerate": 7.0},
                          f"{_BRIEF} --html a.html"),
    "--out": Entry("--out here", {**files("here/table.json"), "write_files called": True,
                                  "write_files.folder": "here"}, _BRIEF, _FOLLOWS),
    "--json": Entry("--json -", DOCUMENT | {"print_comparison called": GONE}, _BRIEF, _FOLLOWS),
}  # fmt: skip
CHECK = {
    "MODEL": Entry("hanging_pendulum", {"check_model.mechanism.name": "hanging_pendulum",
                                        "check_model.speed_rpm": 220.0,
                                        "next_steps.model": "hanging_pendulum"},
                   moves=("check_model.mechanism.",)),
    **{name: replace(item, moves=("next_steps.given.",))
       for name, item in of_a_model("check_model").items()},
    "--speed": Entry("--speed 500", {"check_model.speed_rpm": 500.0},
                     moves=("next_steps.given.",)),
    "--provenance": Entry("--provenance", {"print_report.provenance": True}),
    "--start-index": Entry("--start-index 20", {"check_model.start_index": 20.0},
                           moves=("next_steps.start.",)),
    "--drawing": Entry("--drawing machine.svg", {
        "write_sketch called": True, "write_sketch.path": "machine.svg", "stdout": "lines",
        **files("machine.svg"),
    }, moves=("write_sketch.mechanism.",)),
    "--json": Entry("--json -", DOCUMENT | {"next_steps called": GONE, "next_steps.model": GONE,
                                            "print_report called": GONE,
                                            "print_report.provenance": GONE,
                                            "print_report.steps.commands.0": GONE}),
}  # fmt: skip
_OTHER_GONE = {"file other/other.toml": GONE, "file other/other.urdf": GONE,
               "file other/model.schema.json": GONE}  # fmt: skip
_SKELETON_GONE = {"write_skeleton called": GONE, "write_skeleton.folder": GONE}
NEW = {
    "MODEL": Entry("press", {
        **files("press/press.toml", "press/press.urdf", "press/model.schema.json"), **_OTHER_GONE,
        "write_skeleton.folder": "press"}, moves=("in press/", "in other/")),
    "--from": Entry("--from toggle_press", {
        **_SKELETON_GONE, "write_drawing called": True, "write_drawing.folder": "press",
        "write_drawing.drawing.name": "toggle_press"}, "press", ("write_drawing.drawing.",)),
    "--list": Entry("--list", {**_OTHER_GONE, **_SKELETON_GONE}, moves=("in other/",)),
}  # fmt: skip
PAPER = {
    "MODEL": Entry("e62_identified", {"paper_study.mechanism.name": "e62_identified"},
                   moves=("paper_study.mechanism.",)),
    "--set": of_a_model("paper_study")["--set"],
    "--out": Entry("--out here", {"write_paper called": True, "write_paper.folder": "here",
                                  **files("here/paper.json")}, moves=("in here/",)),
    "--json": Entry("--json -", DOCUMENT | {"print_paper called": GONE}),
}  # fmt: skip
SPEED_LIMIT = {
    "MODEL": Entry("e62_identified", {"speed_limit.mechanism.name": "e62_identified"},
                   moves=("speed_limit.mechanism.",)),
    "--set": of_a_model("speed_limit")["--set"],
    "--from": Entry("--from 300", {"speed_limit.low_rpm": 300.0}),
    "--to": Entry("--to 700", {"speed_limit.high_rpm": 700.0}),
    "--speeds": Entry("--speeds 7", {"speed_limit.speeds": 7}),
    "--turns": Entry("--turns 9", {"speed_limit.turns": 9}),
    "--least-force": Entry("--least-force 5", {"speed_limit.least_force": 5.0}),
    "--plot": Entry("--plot limit.json", {
        "plot_speed_limit called": True, "plot_speed_limit.path": "limit.json",
        "check_figure called": True, "check_figure.path": "limit.json",
        **files("limit.json")}, moves=("in limit.json",)),
    "--json": Entry("--json -", DOCUMENT | {"print_speed_limit called": GONE}),
}  # fmt: skip
STRESS = {
    "--cases": Entry("--cases 3", {"run_campaign.cases": 3}),
    "--seed": Entry("--seed 7", {"run_campaign.seed": 7, "document.seed": 7}, _JSON),
    "--family": Entry("--family chain --family linkage", {
        "run_campaign.families.0": "chain", "run_campaign.families.1": "linkage"}),
    "--first": Entry("--first 5", {"run_campaign.first": 5}),
    "--workers": Entry("--workers 1", {"run_campaign.workers": 1}),
    "--out": Entry("--out run", {**files("run/stress.json")}, moves=("in run/",)),
    "--time-limit": Entry("--time-limit 50", {"run_campaign.time_limit_s": 50.0}),
    "--json": Entry("--json -", {"stdout": "document", "forces": GONE,
                                 "print_campaign called": GONE},
                    moves=("document.", "print_campaign.")),
}  # fmt: skip
IDENTIFY = {
    "PROBLEM.toml": Entry("{identify}", {}, moves=("identify.problem.",)),
    "--seed": Entry("--seed 7", {"identify.seed": 7}, "{identify}"),
    "--starts": Entry("--starts 2", {"identify.starts": 2}, "{identify}"),
    # Of profiles the last call is seen: the numbers a, b and c, the best determined first.
    "--profiles": Entry("--profiles 3", {"profile.path": "c", "print_fit.profiles.2": "c"},
                        "{identify}"),
    "--workers": Entry("--workers 1", {"identify.workers": 1, "profile.workers": 1}, "{identify}"),
    "--out": Entry("--out machine", {"write_model called": True, "write_model.folder": "machine"},
                   "{identify}", ("write_model.",)),
    "--json": Entry("--json -", DOCUMENT | {"print_fit called": GONE, "record called": True},
                    "{identify}", ("print_fit.", "record.")),
}  # fmt: skip
OPTIMISE = {
    "STUDY.toml": Entry("{other_optimise}", {"optimise.problem.title": "another one",
                                             **files("out/other_optimise/front.svg",
                                                     "out/other_optimise/result.json")},
                        moves=("optimise.problem.", "in out/", "file out/optimise/")),
    "--out": Entry("--out here", files("here/front.svg", "here/result.json"), "{optimise}",
                   ("in here/", "in out/", "file out/optimise/")),
    "--seed": Entry("--seed 7", {"optimise.seed": 7}, "{optimise}"),
    "--starts": Entry("--starts 2", {"optimise.starts": 2}, "{optimise}"),
    "--points": Entry("--points 3", {"optimise.points": 3}, "{optimise}"),
    "--no-check": Entry("--no-check", {"optimise.check": False}, "{optimise}"),
    "--workers": Entry("--workers 1", {"optimise.workers": 1}, "{optimise}"),
    "--format": Entry("--format png", {**files("out/optimise/front.png"),
                                       "file out/optimise/front.svg": GONE}, "{optimise}"),
    "--json": Entry("--json -", DOCUMENT | {"print_optimum called": GONE}, "{optimise}"),
}  # fmt: skip
SWEEP = {
    "STUDY.toml": Entry("{other_sweep}", {"run_sweep.folder": "out/other_sweep",
                                          "run_sweep.plan.title": "another one"},
                        moves=("run_sweep.plan.",)),
    "--out": Entry("--out here", {"run_sweep.folder": "here"}, "{sweep}"),
    "--workers": Entry("--workers 1", {"run_sweep.workers": 1}, "{sweep}"),
    "--scheduler": Entry("--scheduler tcp://host:1", {"run_sweep.scheduler": "tcp://host:1"},
                         "{sweep}"),
    "--chunks": Entry("--chunks 1-4", {"run_sweep.chunks": GONE, "run_sweep.chunks.0": 1,
                                       "run_sweep.chunks.1": 4}, "{sweep}"),
    "--dry-run": Entry("--dry-run", {
        "run_sweep called": GONE, "document.done": GONE, "document.scenarios": 3,
        "document.mechanisms": 1, "document.chunks": 2, "document.estimate.done": "well",
        "estimate called": True, "estimate.workers": None, "estimate.chunks": None},
        f"{{sweep}} {_JSON}",
        ("run_sweep.", "estimate.plan.", "document.hash")),
    "--json": Entry("--json -", DOCUMENT, "{sweep}"),
}  # fmt: skip
PLOT = {
    "DIR": Entry("elsewhere", {"plot_sweep.folder": "elsewhere"}),
    "--quantity": Entry("--quantity duration_s --quantity collisions", {
        "plot_sweep.quantities": GONE, "plot_sweep.quantities.0": "duration_s",
        "plot_sweep.quantities.1": "collisions"}, "folder"),
    "--x": Entry("--x restitution", {"plot_sweep.across": "restitution"}, "folder"),
    "--y": Entry("--y stiffness", {"plot_sweep.upwards": "stiffness"}, "folder"),
    "--format": Entry("--format png", {"plot_sweep.kind": "png"}, "folder"),
    "--out": Entry("--out here", {"plot_sweep.target": "here"}, "folder"),
}  # fmt: skip
BENCHMARK = {
    "--quick": Entry("--quick", {"benchmark.quick": True}),
    "--repeats": Entry("--repeats 7", {"benchmark.repeats": 7}),
    "--json": Entry("--json -", DOCUMENT | {"print_benchmark called": GONE}),
    "--out": Entry("--out here", {"write_benchmark called": True, "write_benchmark.folder": "here",
                                  "file here/all.json": True, "in here/all.json.done": "well"},
                   moves=("write_benchmark.",)),
}  # fmt: skip

TABLE = {
    f"{command} {option}": entry
    for command, entries in {
        "simulate": SIMULATE, "view": VIEW, "compare": COMPARE, "live": LIVE,
        "new": NEW, "check": CHECK,
        "paper": PAPER, "speed-limit": SPEED_LIMIT, "identify": IDENTIFY,
        "optimise": OPTIMISE, "sweep": SWEEP,
        "plot": PLOT, "stress": STRESS, "run": BENCHMARK,
    }.items()
    for option, entry in entries.items()
}  # fmt: skip
