"""Mistakes in files of studies: edit, place and value; and values at their bounds."""

from __future__ import annotations

import math

from nipper_pin.mechanism import find_model
from tests.refusals.bases import SMALL, Row
from tests.study.sweep.sweep_studies import FULL

SWEEP = f'format = 1\ntitle = "test"\n{FULL}'
FIT = """
format = 1
title = "mine"
model = "e62"
prior_weight = 0.5
absolute_sigma = false
measured = "seen.csv"
[case]
rest_rate = 1e-3
tolerance = 1e-4
[set]
"stops.steeve.restitution" = 0.25
[parameters.preload]
low = 9.0
high = 13.0
why = "it was measured"
[parameters.restitution]
low = 0.1
high = 0.3
[[targets]]
name = "one"
quantity = "duration_s"
at = { speed_rpm = 650.0, restitution = 0.2, stiffness_N_per_m = 9500.0 }
since = { speed_rpm = 450.0 }
value = -0.25
relative_sigma = 0.02
[[targets]]
name = "two"
quantity = "rebound_time_s_2"
at = { speed_rpm = 550.0 }
value = 0.0
sigma = 0.125
[limits]
at = { speed_rpm = 600.0, stiffness_N_per_m = 8000.0 }
closing_index = { low = 0.0, high = 35.0 }
opening_index = { low = 7.0, high = 40.0 }
stop_force_N = { low = 12.0 }
jaw_opening_deg = { low = 25.0 }
"""
SEEN = """speed_rpm;quantity;stiffness_N_per_m;value;sigma;restitution
650;duration_s;9500;6,5e-3;1e-5;0,5
450;rebound_amplitude_1;;+,007;0,00002;
"""
CAMERA = """speed_rpm,restitution,quantity,value,sigma
650,0.25,rebound_amplitude_1,0.00531,5e-5
450,,rebound_time_s_1,5.44e-3,0.00003
"""
DESIGN = """
format = 1
title = "mine"
model = "e62"
minimise = "rebound_amplitude_1"
maximise = ["clamping_force_N"]
[case]
speed_rpm = 512.5
rest_rate = 1e-3
tolerance = 1e-6
[set]
restitution = 0.25
[parameters.preload]
low = 9.0
high = 13.0
[parameters.speed_rpm]
low = 400.0
high = 600.0
[parameters."links.top_nipper.mass_kg"]
low = 1.3
high = 1.6
[limits]
duration_s = { low = 1e-3, high = 2.0 }
opening_index = { high = 40.0 }
closing_index = { low = 0.0 }
"""
# Files of a study by name; a command reads the first.
BASES = {
    "sweep": {"sweep.toml": SWEEP},
    "identify": {"fit.toml": FIT, "seen.csv": SEEN},
    "camera": {"fit.toml": FIT, "seen.csv": CAMERA},
    "optimise": {"design.toml": DESIGN},
}


def path(old: str, new: str, *more: object) -> Row:
    """A parameter of another name."""
    return Row((f"[parameters.{old}]", f"[parameters.{new}]"), *more)


# Sweeps: the two bounds of a sampled number, the values of a mass, and three points.
BOUNDS, SAMPLED = "low = 0.1\nhigh = 0.3", "parameters.restitution"
MASS, MASSES = '"links.top_nipper.mass_kg"', "values = [1.4, 1.1]"
KEY = "parameters.links.top_nipper.mass_kg"
CUBE = '[samples]\nmethod = "latin_hypercube"\ncount = 6\nseed = 9\n'
CASE = "tolerance = 1e-3"
CYCLE = '[case]\nwindow = "cycle"\n'
NO_SPEED = ("speed_rpm = 512.5\n", "")
HEAD = "format = 1\n"
ONE = "[parameters.restitution]\nvalues = [0.1]\n"
SWEEP_VALUES = {
    "one bound": Row((BOUNDS, "low = 0.1"), SAMPLED, "no values"),
    "other bound": Row((BOUNDS, "high = 0.3"), SAMPLED, "no values"),
    "upside down": Row((BOUNDS, "low = 0.3\nhigh = 0.1"), SAMPLED, [0.3, 0.1]),
    "equal bounds": Row((BOUNDS, "low = 0.1\nhigh = 0.1"), SAMPLED, [0.1, 0.1]),
    "infinite": Row((BOUNDS, "low = 0.1\nhigh = inf"), SAMPLED, math.inf),
    "no number": Row((BOUNDS, "low = nan\nhigh = 0.3"), SAMPLED, ...),
    "no number of some": Row((MASSES, "values = [1.4, nan, 1.1]"), KEY, ...),
    "infinite value": Row((MASSES, "values = [1.4, inf]"), KEY, math.inf),
    "equal values": Row((MASSES, "values = [1.4, 1.1, 1.4]"), KEY, [1.4, 1.1, 1.4]),
    "values and low": Row((MASSES, f"{MASSES}\nlow = 1.0"), KEY, "values and bounds"),
    "values and high": Row((MASSES, f"{MASSES}\nhigh = 2.0"), KEY, "values and bounds"),
    "values and points": Row((MASSES, f"{MASSES}\npoints = 2"), KEY, "values and bounds"),
    "logarithm of nothing": Row(("low = 9.0", "low = 0.0"), "parameters.preload", 0.0),
    "no samples": Row((CUBE, ""), SAMPLED, "no points"),
    "nothing to sample": Row((BOUNDS, "values = [0.1]"), "samples", "latin_hypercube"),
    "large cube": Row(("count = 6", "count = 10_000_001"), "samples.count", 10_000_001),
    "long sequence": Row(('"latin_hypercube"\ncount = 6', f'"sobol"\ncount = {2**30 + 1}'),
                         "samples.count", 2**30 + 1),
    "restitution": Row((BOUNDS, "low = 0.1\nhigh = 1.5"), SAMPLED, 1.5),
    "stiffness": Row(("[parameters.restitution]\nlow = 0.1", "[parameters.stiffness]\nlow = -1.0"),
                     "parameters.stiffness", -1.0),
    "speed": Row((*NO_SPEED, "[parameters.restitution]\nlow = 0.1",
                  "[parameters.speed_rpm]\nlow = 0.0"), "parameters.speed_rpm", 0.0),
    "speed of the case": path("restitution", "speed_rpm", "parameters.speed_rpm", "speed_rpm"),
    "what is set": Row(('"stops.steeve.restitution" = 0.21', "restitution = 0.21"),
                       SAMPLED, "stops.jaw.restitution"),
    "two names": path("restitution", '"springs.steeve.preload_length_mm"]\nvalues = [9.5]\n'
                      "[parameters.restitution", "parameters.preload",
                      "springs.steeve.preload_length_mm"),
    "column": path(MASS, "outcome", "parameters.outcome", "outcome"),
    "column of the premise": path(MASS, "premise_holds", "parameters.premise_holds",
                                  "premise_holds"),
    "column of a quantity": path(MASS, "duration_s", "parameters.duration_s", "duration_s"),
    "quantity twice": Row(('"rebound_amplitude_1"', '"duration_s"'), "quantities", "duration_s"),
    "turns of a transition": Row((CASE, "turns = 3"), "case.turns", 3),
    "force of a transition": Row((CASE, "least_force_N = 0.0"), "case.least_force_N", 0.0),
    "cycle without a stop": Row(f'{HEAD}model = "free"\n{CYCLE}{ONE}', "case.window", "cycle"),
    "no TOML": Row(("[samples]", "[samples"), "TOML", ...),
}  # fmt: skip
SWEEP_KEYS = {
    "format": Row(("format = 1", "format = 2"), "format", None),
    "window": Row((CASE, 'window = "turn"'), "case.window", None),
    "drive": Row(('"inertial"', '"free"'), "case.drive", None),
    "fine": Row((CASE, "tolerance = 0.9e-13"), "case.tolerance", None),
    "coarse": Row((CASE, "tolerance = 1.1e-3"), "case.tolerance", None),
    "no speed": Row(("speed_rpm = 512.5", "speed_rpm = 0.0"), "case.speed_rpm", None),
    "no rest": Row(("rest_rate = 2e-4", "rest_rate = 0.0"), "case.rest_rate", None),
    "no collision": Row(("max_collisions = 77", "max_collisions = 0"), "case.max_collisions", None),
    "no turn": Row((CASE, 'window = "cycle"\nturns = 0'), "case.turns", None),
    "force below zero": Row((CASE, 'window = "cycle"\nleast_force_N = -1e-300'),
                            "case.least_force_N", None),
    "no chunk": Row(("chunk = 3", "chunk = 0"), "chunk", None),
    "large chunk": Row(("chunk = 3", f"chunk = {2**20 + 1}"), "chunk", None),
    "no sample": Row(("count = 6", "count = 0"), "samples.count", None),
    "half a sample": Row(("count = 6", "count = 6.5"), "samples.count", None),
    "seed": Row(("seed = 9", "seed = -1"), "samples.seed", None),
    "method": Row(('"latin_hypercube"', '"random"'), "samples.method", None),
    "scale": Row(('"log"', '"logarithmic"'), "parameters.preload.scale", None),
    "one point": Row(("points = 3", "points = 1"), "parameters.preload.points", None),
    "many points": Row(("points = 3", f"points = {2**20 + 1}"), "parameters.preload.points", None),
    "texts": Row((MASSES, 'values = ["1.4"]'), f"{KEY}.values[0]", None),
    "unknown key": Row(("speed_rpm = 512.5", "speed = 512.5"), "case", None),
    "no parameters": Row(HEAD, "document", None),
    "nothing varies": Row(f"{HEAD}[parameters]\n", "parameters", None),
    "name": path("preload", "nothing", "parameters.nothing", "nothing"),
    "key of a drive": path(MASS, '"drives.tension.rate"', "parameters.drives.tension.rate", "rate"),
    "law": path(MASS, '"drives.tension.law"', "parameters.drives.tension.law", "geared"),
    "place": path(MASS, '"drives.pendulum.guide_axis_mm[2]"',
                  "parameters.drives.pendulum.guide_axis_mm[2]", "[2]"),
    "link": path(MASS, '"links.jaw.mass_kg"', "parameters.links.jaw.mass_kg", "jaw"),
    "coordinate": path(MASS, '"points.jaw.y_mm"', "parameters.points.jaw.y_mm", "y_mm"),
    "two ways of an inertia": Row((f"{MASSES}\n", f'{MASSES}\n[parameters."links.top_nipper.'
        'inertia_kg_m2"]\nvalues = [1e-3]\n[parameters."links.top_nipper.gyration_mm"]\n'
        "values = [30.0]\n"), "parameters", ...),
    "set": Row(('"stops.steeve.restitution" = 0.21', '"stops.jaw.law" = 1'), "set", "law"),
    "model": Row(('model = "e62"', 'model = "e63"'), "model", "e63"),
    "many scenarios": Row((f"{MASSES}\n", f"low = 1.0\nhigh = 1.4\npoints = {2**20}\n",
                           "points = 3", "points = 158_946"), "parameters", None),
}  # fmt: skip
SWEEP_NAMES = {
    "quantity": Row(('"duration_s"', '"force_1"'), "quantity", "force_1"),
    "quantity of no collision": Row(('"duration_s"', '"rebound_time_s"'),
                                    "quantity", "rebound_time_s"),
    "quantity of a transition": Row(f'{HEAD}quantities = ["duration_s"]\n{CYCLE}{ONE}',
                                    "quantity", "duration_s"),
    "column of turns": Row(f'{HEAD}quantities = ["repeats_after"]\n{CYCLE}{ONE}',
                           "quantity", "repeats_after"),
}  # fmt: skip

PRELOAD, ANGULAR = "parameters.springs.steeve.preload_length_mm", "stiffness_N_m_per_rad"
NO_SET = ('"stops.steeve.restitution" = 0.25', "")
AIMS = FIT[FIT.index("[[targets]]") : FIT.index("[limits]")]
FREE = FIT[FIT.index("[parameters.preload]") : FIT.index("[[targets]]")]
FIT_VALUES = {
    "two sigmas": Row(("relative_sigma = 0.02", "sigma = 1.0\nrelative_sigma = 0.02"),
                      "targets: one", 1.0),
    "no sigma": Row(("sigma = 0.125", ""), "targets: two", None),
    "share of nothing": Row(("sigma = 0.125", "relative_sigma = 0.1"), "targets: two: value", 0.0),
    "no number": Row(("value = -0.25", "value = nan"), "targets: one: value", ...),
    "stiffness of a hinge": Row(("stiffness_N_per_m = 9500.0", f"{ANGULAR} = 9.0"),
                                f"targets: one: at.{ANGULAR}", 9.0),
    "earlier stiffness": Row(("{ speed_rpm = 450.0 }", f"{{ speed_rpm = 450.0, {ANGULAR} = 9.0 }}"),
                             f"targets: one: since.{ANGULAR}", 9.0),
    "stiffness of limits": Row(("stiffness_N_per_m = 8000.0", f"{ANGULAR} = 8.0"),
                               f"limits.at.{ANGULAR}", 8.0),
    "index below zero": Row(("low = 0.0, high = 35.0", "low = -1.0, high = 35.0"),
                            "limits.closing_index", [-1.0, 35.0]),
    "no range": Row(("low = 0.0, high = 35.0", "low = 35.0, high = 35.0"),
                    "limits.closing_index", [35.0, 35.0]),
    "index above forty": Row(("high = 40.0", "high = 40.5"), "limits.opening_index", [7.0, 40.5]),
    "equal bounds": Row(("high = 13.0", "high = 9.0"), PRELOAD, [9.0, 9.0]),
    "infinite bound": Row(("high = 13.0", "high = inf"), PRELOAD, [9.0, math.inf]),
    "above the bounds": Row(("high = 13.0", "high = 9.5"), PRELOAD, [9.0, 9.5]),
    "below the bounds": Row(("low = 9.0", "low = 12.0"), PRELOAD, [12.0, 13.0]),
    "what is set": Row(('"stops.steeve.restitution"', "restitution"),
                       "parameters.restitution", "stops.jaw.restitution"),
    "twice": Row(("[parameters.restitution]", '[parameters."springs.steeve.preload_length_mm"]'),
                 PRELOAD, "springs.steeve.preload_length_mm"),
    "text": Row(("[parameters.preload]", '[parameters."springs.steeve.joint"]'),
                "springs.steeve.joint", "steeve"),
    "two ways of an inertia": Row((
        "[parameters.preload]\nlow = 9.0\nhigh = 13.0", '[parameters."links.top_nipper.gyration_mm"'
        ']\nlow = 20.0\nhigh = 40.0\n[parameters."links.top_nipper.inertia_kg_m2"]\nlow = 1e-4\n'
        "high = 1e-2"), "links.top_nipper", ...),
    "two springs": Row((*NO_SET, 'model = "e62"', 'model = "two_springs"'), "stiffness", 9500.0),
    "no spring": Row(f'{HEAD}title = "t"\nmodel = "free"\n{FREE}{AIMS}', "stiffness", 9500.0),
    **{name: Row(('model = "e62"', f'model = "{name}"'), "limits", name)
       for name in ("third_phase", "clamped_first", "one_drive", "stop_elsewhere")},
    "opening of a slide": Row(('model = "e62"', 'model = "steeve_last"'),
                              "limits.jaw_opening_deg", 25.0),
}  # fmt: skip
FIT_KEYS = {
    "fine": Row(("tolerance = 1e-4", "tolerance = 0.9e-13"), "case.tolerance", None),
    "coarse": Row(("tolerance = 1e-4", "tolerance = 1.1e-4"), "case.tolerance", None),
    "no rest": Row(("rest_rate = 1e-3", "rest_rate = 0.0"), "case.rest_rate", None),
    "no speed": Row(("speed_rpm = 450.0", "speed_rpm = 0.0"), "targets[0].since.speed_rpm", None),
    "restitution": Row(("restitution = 0.2,", "restitution = 1.000001,"),
                       "targets[0].at.restitution", None),
    "restitution below zero": Row(("restitution = 0.2,", "restitution = -1e-300,"),
                                  "targets[0].at.restitution", None),
    "no stiffness": Row(("stiffness_N_per_m = 9500.0", "stiffness_N_per_m = 0.0"),
                        "targets[0].at.stiffness_N_per_m", None),
    "stiffness without a unit": Row(("stiffness_N_per_m = 9500.0", "stiffness = 9500.0"),
                                    "targets[0].at", None),
    "weight": Row(("prior_weight = 0.5", "prior_weight = -0.5"), "prior_weight", None),
    "table": Row(("[limits]", "[limit]"), "document", None),
    "other limit": Row(("jaw_opening_deg", "least_opening_deg"), "limits", None),
    "range as a list": Row(("{ low = 0.0, high = 35.0 }", "[33, 35]"),
                           "limits.closing_index", None),
    "tolerance at the top": Row(("prior_weight = 0.5", "tolerance = 1e-8"), "document", None),
    "no targets": Row(f'{HEAD}title = "t"\nmodel = "e62"\n{FREE}', None, None),
    "format": Row(("format = 1", "format = 2"), "format", None),
    "other table": Row((FREE, "[free.preload]\nlow = 9.0\nhigh = 13.0\n"), "document", None),
    "nothing free": Row((FREE, "[parameters]\n"), None, None),
    "no measurements": Row(('"seen.csv"', '"absent.csv"'), None, None),
}  # fmt: skip
FIT_NAMES = {
    "quantity": Row(("rebound_time_s_2", "beauty"), "quantity", "beauty"),
    "key": path("preload", '"springs.steeve.colour"', "key", "colour"),
    "point": path("preload", '"points.elbow.x_mm"', "point", "elbow"),
    "coordinate": path("preload", '"points.jaw.y_mm"', "coordinate", "y_mm"),
}
SEEN_KEYS = {
    "unit": Row(("quantity;stiffness_N_per_m", f"quantity;{ANGULAR}"), ANGULAR, None),
    "stiffness": Row((";9500;", ";0;"), "stiffness_N_per_m", "0"),
    "restitution": Row((";0,5", ";1,01"), "restitution", "1,01"),
    "restitution below zero": Row((";0,5", ";-0,01"), "restitution", "-0,01"),
    "speed": Row(("\n450;", "\n0;"), "speed_rpm", "0"),
    "sigma": Row(("1e-5", "0"), "sigma", "0"),
    "points beside commas": Row(("\n450;", "\n4.5e2;"), None, None),
}  # fmt: skip
CAMERA_KEYS = {
    "decimal comma": Row(("5.44e-3,0.00003", "0,00544,0,00003"), "value", None),
    "comma in quotes": Row(("0.00531", '"0,00531"'), "value", "0,00531"),
    "comma of a speed": Row(("\n450,,", "\n450,5,,"), "speed_rpm", None),
    "word": Row(("5.44e-3", "fast"), "value", "fast"),
    "no number": Row(("5.44e-3", "nan"), "value", "nan"),
    "infinite": Row(("5.44e-3", "1e400"), "value", "1e400"),
    "line below": Row(("5.44e-3", "1_000"), "value", "1_000"),
    "nothing": Row(("5.44e-3", ""), "value", ""),
    "sigma below zero": Row(("5e-5", "-1e-5"), "sigma", "-1e-5"),
    "restitution": Row(("0.25,reb", "1.25,reb"), "restitution", "1.25"),
    "speed below zero": Row(("650,0.25", "-650,0.25"), "speed_rpm", "-650"),
    "many fields": Row(("5e-5", "5e-5,7"), None, None),
    "column twice": Row(("speed_rpm,restitution", "speed_rpm,sigma"), None, None),
    "column missing": Row((",sigma\n", "\n"), None, None),
    "empty": Row((CAMERA, ""), None, None),
    "empty lines": Row((CAMERA, "\n\n"), None, None),
    "heading alone": Row((CAMERA[CAMERA.index("650") :], ""), None, None),
}  # fmt: skip
CAMERA_NAMES = {
    "quantity": Row(("rebound_time_s_1", "bounce"), "quantity", "bounce"),
    "other name": Row(("rebound_time_s_1", "first_rebound_time"),
                      "quantity", "first_rebound_time"),
    "column": Row(("speed_rpm,restitution", "speed_rpm,colour"), "column", "colour"),
}  # fmt: skip

LIMIT, AIM = "low = 1e-3, high = 2.0", 'minimise = "rebound_amplitude_1"'
DESIGN_VALUES = {
    "one aim twice": Row(('["clamping_force_N"]', '["rebound_amplitude_1"]'), "minimise",
                         ["rebound_amplitude_1"] * 2),
    "no aim": Row((AIM, "", 'maximise = ["clamping_force_N"]', ""), "minimise", []),
    "three aims": Row((AIM, 'minimise = ["rebound_amplitude_1", "duration_s"]'), "minimise",
                      ["rebound_amplitude_1", "duration_s", "clamping_force_N"]),
    "limits crossed": Row((LIMIT, "low = 2.5, high = 2.0"), "limits.duration_s", [2.5, 2.0]),
    "no limit": Row((LIMIT, ""), "limits.duration_s", {"low": None, "high": None}),
    "index above forty": Row(("high = 40.0 }", "high = 40.5 }"), "limits.opening_index.high", 40.5),
    "index below zero": Row(("{ low = 0.0 }", "{ low = -0.5 }"), "limits.closing_index.low", -0.5),
    "infinite limit": Row(("high = 2.0", "high = inf"), "limits.duration_s.high", math.inf),
    "limit that is no number": Row(("low = 1e-3", "low = nan"), "limits.duration_s.low", ...),
    "equal bounds": Row(("high = 13.0", "high = 9.0"), "parameters.preload", [9.0, 9.0]),
    "infinite bound": Row(("high = 13.0", "high = inf"), "parameters.preload", [9.0, math.inf]),
    "no speed": Row(("low = 400.0", "low = 0.0"), "parameters.speed_rpm", 0.0),
    "restitution": Row(("restitution = 0.25", "", "[parameters.preload]\nlow = 9.0\nhigh = 13.0",
                        "[parameters.restitution]\nlow = 0.5\nhigh = 1.5"),
                       "parameters.restitution", 1.5),
    "preload that no spring has": Row(("low = 9.0", "low = -1e18"), "parameters.preload", ...),
    "what is set": Row(("restitution = 0.25", "preload = 10.0"), "parameters.preload", "preload"),
    "nothing is free": Row(f'{HEAD}minimise = "duration_s"\nparameters = {{}}\n', "parameters", []),
    "no TOML": Row((AIM, "minimise ="), "TOML", ...),
}  # fmt: skip
DESIGN_KEYS = {
    "format": Row(("format = 1", "format = 2"), "format", None),
    "fine": Row(("tolerance = 1e-6", "tolerance = 0.9e-13"), "case.tolerance", None),
    "coarse": Row(("tolerance = 1e-6", "tolerance = 1.1e-6"), "case.tolerance", None),
    "no rest": Row(("rest_rate = 1e-3", "rest_rate = 0.0"), "case.rest_rate", None),
    "no speed": Row(("speed_rpm = 512.5", "speed_rpm = 0.0"), "case.speed_rpm", None),
    "unknown key": Row(("format = 1", "format = 1\nstart = 1"), "document", None),
    "speed at the top": Row(("format = 1", "format = 1\nspeed_rpm = 60.0"), "document", None),
    "other bounds": Row(("low = 9.0", "lower = 9.0"), "parameters.preload", None),
    "other limit": Row((LIMIT, "upper = 1.0"), "limits.duration_s", None),
    "other limits": Row(("[limits]", "[constraints]"), "document", None),
    "key of no table": Row(f"{HEAD}[optimise]\n", "document", None),
    "list of parameters": Row(f'{HEAD}minimise = "duration_s"\n[[parameters]]\npath = "x"\n',
                              "parameters", None),
    "path": path("preload", '"stops.floor.restitution"', "parameters.stops.floor.restitution",
                 "floor"),
    "name": path("preload", "nothing", "parameters.nothing", "nothing"),
    "two ways of an inertia": Row((
        "[parameters.preload]\nlow = 9.0\nhigh = 13.0", '[parameters."links.top_nipper.gyration_mm"'
        ']\nlow = 20.0\nhigh = 40.0\n[parameters."links.top_nipper.inertia_kg_m2"]\nlow = 1e-4\n'
        "high = 1e-2"), "parameters", ...),
    "no phases": Row(('model = "e62"', 'model = "third_phase"'), None, None),
    "opening of a slide": Row(('model = "e62"', 'model = "steeve_last"', '["clamping_force_N"]',
                               '["jaw_opening_deg"]'), None, None),
    "stroke of a hinge": Row(('model = "e62"', 'model = "steeve_last"',
                              "closing_index =", "stroke_mm ="), None, None),
}  # fmt: skip
DESIGN_NAMES = {
    "aim": Row((AIM, 'minimise = "beauty"'), "quantity", "beauty"),
    "old name": Row((AIM, 'minimise = "transition_time_s"'), "quantity", "transition_time_s"),
    "limit": Row(("duration_s =", "beauty ="), "quantity", "beauty"),
}

E62 = (find_model("e62") / "e62.toml").read_text(encoding="utf-8")
TENSION = E62[E62.index("[drives.tension]") : E62.index("[springs.steeve]")]
STOPS = SMALL[SMALL.index("stops.low") :]
# Models beside the studies: base machine and edits.
BESIDE: dict[str, tuple[str, tuple[str, ...]]] = {
    "two_springs": ("e62", (
        "[springs.steeve]", "[springs.second]\njoint = \"jaw\"\nstiffness_N_m_per_rad = 1.0\n"
        "preload_deg = 0.0\n\n[springs.steeve]")),
    "free": ("small", ('transition_stop = "low"\n', "", STOPS, "")),
    "clamped_first": ("e62", ("initial_phase = 1", "initial_phase = 2")),
    "one_drive": ("e62", (TENSION, "")),
    "stop_elsewhere": ("e62", ('joint = "steeve"\nrestitution',
                               'joint = "steeve"\nat_mm = -0.5\nrestitution')),
    "third_phase": ("e62", ("initial_phase = 1", "initial_phase = 3")),
    "steeve_last": ("e62", ("initial_phase = 1", "initial_phase = 2",
                            'transition_stop = "jaw"', 'transition_stop = "steeve"')),
}  # fmt: skip

# Values at their bounds, which are taken, by study.
TAKEN = {
    "sweep": {
        "finest": (CASE, "tolerance = 1e-13"),
        "least": ("rest_rate = 2e-4\ntolerance = 1e-3\nmax_collisions = 77",
                  "rest_rate = 1e-300\nmax_collisions = 1"),
        "samples": ("count = 6\nseed = 9", "count = 1\nseed = 0"),
        "points": ("points = 3", "points = 2"),
        "chunk": ("chunk = 3", "chunk = 1"),
        "least speed": ("speed_rpm = 512.5", "speed_rpm = 1e-300"),
        "scenarios": (f"{MASSES}\n", "low = 1.0\nhigh = 1.4\npoints = 1_000_000\n",
                      "points = 3", "points = 1_000_000", "count = 6", "count = 1"),
        "cycle": (CASE, 'window = "cycle"\nturns = 1\nleast_force_N = 0.0',
                  '["duration_s", "rebound_amplitude_1"]', '["clamped_time_s"]'),
        "inertia alone": (MASS, '"links.top_nipper.inertia_kg_m2"', MASSES, "values = [1e-3]"),
        "gyration alone": (MASS, '"links.top_nipper.gyration_mm"', MASSES, "values = [30.0]"),
    },
    "identify": {
        "finest": ("tolerance = 1e-4", "tolerance = 1e-13"),
        "least": ("rest_rate = 1e-3", "rest_rate = 1e-300",
                  "speed_rpm = 450.0", "speed_rpm = 1e-300"),
        "no loss": ("restitution = 0.2,", "restitution = 1.0,", "prior_weight = 0.5",
                    "prior_weight = 0.0"),
        "all loss": ("restitution = 0.2,", "restitution = 0,"),
        "nothing set": NO_SET,
        "restitutions at their ends": (";0,5", ";1", ";0,00002;", ";0,00002;0,0"),
        "force of a slide": (*NO_SET, 'model = "e62"', 'model = "steeve_last"',
                             "jaw_opening_deg = { low = 25.0 }", ""),
        "phases that targets do not need": ('model = "e62"', 'model = "third_phase"',
                                            FIT[FIT.index("[limits]") :], ""),
    },
    "optimise": {
        "finest": ("tolerance = 1e-6", "tolerance = 1e-13"),
        "least": ("rest_rate = 1e-3", "rest_rate = 1e-300"),
        "least speed": ("speed_rpm = 512.5", "speed_rpm = 1e-300"),
        "quantities that need no cycle": (
            'model = "e62"', 'model = "third_phase"', '["clamping_force_N"]', '["duration_s"]',
            "opening_index = { high = 40.0 }\nclosing_index = { low = 0.0 }\n", "",
            "duration_s = {", "speed_rpm = {"),
    },
}  # fmt: skip
