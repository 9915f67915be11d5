"""Mistakes in files of studies, and values at their bounds; snapshots say what is said of each."""

from __future__ import annotations

from nipper_pin.mechanism import find_model
from tests.refusals.bases import SMALL
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


def path(old: str, new: str) -> tuple[str, str]:
    """A parameter of another name."""
    return f"[parameters.{old}]", f"[parameters.{new}]"


# Sweeps: the two bounds of a sampled number, the values of a mass, and three points.
BOUNDS, SAMPLED = "low = 0.1\nhigh = 0.3", "parameters.restitution"
MASS, MASSES = '"links.top_nipper.mass_kg"', "values = [1.4, 1.1]"
CUBE = '[samples]\nmethod = "latin_hypercube"\ncount = 6\nseed = 9\n'
CASE = "tolerance = 1e-3"
CYCLE = '[case]\nwindow = "cycle"\n'
NO_SPEED = ("speed_rpm = 512.5\n", "")
HEAD = "format = 1\n"
ONE = "[parameters.restitution]\nvalues = [0.1]\n"
SWEEP_VALUES = {
    "one bound": (BOUNDS, "low = 0.1"),
    "other bound": (BOUNDS, "high = 0.3"),
    "upside down": (BOUNDS, "low = 0.3\nhigh = 0.1"),
    "equal bounds": (BOUNDS, "low = 0.1\nhigh = 0.1"),
    "infinite": (BOUNDS, "low = 0.1\nhigh = inf"),
    "no number": (BOUNDS, "low = nan\nhigh = 0.3"),
    "no number of some": (MASSES, "values = [1.4, nan, 1.1]"),
    "infinite value": (MASSES, "values = [1.4, inf]"),
    "equal values": (MASSES, "values = [1.4, 1.1, 1.4]"),
    "values and low": (MASSES, f"{MASSES}\nlow = 1.0"),
    "values and high": (MASSES, f"{MASSES}\nhigh = 2.0"),
    "values and points": (MASSES, f"{MASSES}\npoints = 2"),
    "logarithm of nothing": ("low = 9.0", "low = 0.0"),
    "no samples": (CUBE, ""),
    "nothing to sample": (BOUNDS, "values = [0.1]"),
    "large cube": ("count = 6", "count = 10_000_001"),
    "long sequence": ('"latin_hypercube"\ncount = 6', f'"sobol"\ncount = {2**30 + 1}'),
    "restitution": (BOUNDS, "low = 0.1\nhigh = 1.5"),
    "stiffness": ("[parameters.restitution]\nlow = 0.1", "[parameters.stiffness]\nlow = -1.0"),
    "speed": (*NO_SPEED, "[parameters.restitution]\nlow = 0.1",
        "[parameters.speed_rpm]\nlow = 0.0"),
    "speed of the case": path("restitution", "speed_rpm"),
    "what is set": ('"stops.steeve.restitution" = 0.21', "restitution = 0.21"),
    "two names": path("restitution", '"springs.steeve.preload_length_mm"]\nvalues = [9.5]\n'
        "[parameters.restitution"),
    "column": path(MASS, "outcome"),
    "column of the premise": path(MASS, "premise_holds"),
    "column of a quantity": path(MASS, "duration_s"),
    "quantity twice": ('"rebound_amplitude_1"', '"duration_s"'),
    "turns of a transition": (CASE, "turns = 3"),
    "force of a transition": (CASE, "least_force_N = 0.0"),
    "cycle without a stop": f'{HEAD}model = "free"\n{CYCLE}{ONE}',
    "no TOML": ("[samples]", "[samples"),
}  # fmt: skip
SWEEP_KEYS = {
    "format": ("format = 1", "format = 2"),
    "window": (CASE, 'window = "turn"'),
    "drive": ('"inertial"', '"free"'),
    "fine": (CASE, "tolerance = 0.9e-13"),
    "coarse": (CASE, "tolerance = 1.1e-3"),
    "no speed": ("speed_rpm = 512.5", "speed_rpm = 0.0"),
    "no rest": ("rest_rate = 2e-4", "rest_rate = 0.0"),
    "no collision": ("max_collisions = 77", "max_collisions = 0"),
    "no turn": (CASE, 'window = "cycle"\nturns = 0'),
    "force below zero": (CASE, 'window = "cycle"\nleast_force_N = -1e-300'),
    "no chunk": ("chunk = 3", "chunk = 0"),
    "large chunk": ("chunk = 3", f"chunk = {2**20 + 1}"),
    "no sample": ("count = 6", "count = 0"),
    "half a sample": ("count = 6", "count = 6.5"),
    "seed": ("seed = 9", "seed = -1"),
    "method": ('"latin_hypercube"', '"random"'),
    "scale": ('"log"', '"logarithmic"'),
    "one point": ("points = 3", "points = 1"),
    "many points": ("points = 3", f"points = {2**20 + 1}"),
    "texts": (MASSES, 'values = ["1.4"]'),
    "unknown key": ("speed_rpm = 512.5", "speed = 512.5"),
    "no parameters": HEAD,
    "nothing varies": f"{HEAD}[parameters]\n",
    "name": path("preload", "nothing"),
    "key of a drive": path(MASS, '"drives.tension.rate"'),
    "law": path(MASS, '"drives.tension.law"'),
    "place": path(MASS, '"drives.pendulum.guide_axis_mm[2]"'),
    "link": path(MASS, '"links.jaw.mass_kg"'),
    "coordinate": path(MASS, '"points.jaw.y_mm"'),
    "two ways of an inertia": (f"{MASSES}\n", f'{MASSES}\n[parameters."links.top_nipper.'
        'inertia_kg_m2"]\nvalues = [1e-3]\n[parameters."links.top_nipper.gyration_mm"]\n'
        "values = [30.0]\n"),
    "set": ('"stops.steeve.restitution" = 0.21', '"stops.jaw.law" = 1'),
    "model": ('model = "e62"', 'model = "e63"'),
    "many scenarios": (f"{MASSES}\n", f"low = 1.0\nhigh = 1.4\npoints = {2**20}\n", "points = 3",
        "points = 158_946"),
}  # fmt: skip
SWEEP_NAMES = {
    "quantity": ('"duration_s"', '"force_1"'),
    "quantity of no collision": ('"duration_s"', '"rebound_time_s"'),
    "quantity of a transition": f'{HEAD}quantities = ["duration_s"]\n{CYCLE}{ONE}',
    "column of turns": f'{HEAD}quantities = ["repeats_after"]\n{CYCLE}{ONE}',
}  # fmt: skip

PRELOAD, ANGULAR = "parameters.springs.steeve.preload_length_mm", "stiffness_N_m_per_rad"
NO_SET = ('"stops.steeve.restitution" = 0.25', "")
AIMS = FIT[FIT.index("[[targets]]") : FIT.index("[limits]")]
FREE = FIT[FIT.index("[parameters.preload]") : FIT.index("[[targets]]")]
FIT_VALUES = {
    "two sigmas": ("relative_sigma = 0.02", "sigma = 1.0\nrelative_sigma = 0.02"),
    "no sigma": ("sigma = 0.125", ""),
    "share of nothing": ("sigma = 0.125", "relative_sigma = 0.1"),
    "no number": ("value = -0.25", "value = nan"),
    "stiffness of a hinge": ("stiffness_N_per_m = 9500.0", f"{ANGULAR} = 9.0"),
    "earlier stiffness": ("{ speed_rpm = 450.0 }", f"{{ speed_rpm = 450.0, {ANGULAR} = 9.0 }}"),
    "stiffness of limits": ("stiffness_N_per_m = 8000.0", f"{ANGULAR} = 8.0"),
    "index below zero": ("low = 0.0, high = 35.0", "low = -1.0, high = 35.0"),
    "no range": ("low = 0.0, high = 35.0", "low = 35.0, high = 35.0"),
    "index above forty": ("high = 40.0", "high = 40.5"),
    "equal bounds": ("high = 13.0", "high = 9.0"),
    "infinite bound": ("high = 13.0", "high = inf"),
    "above the bounds": ("high = 13.0", "high = 9.5"),
    "below the bounds": ("low = 9.0", "low = 12.0"),
    "what is set": ('"stops.steeve.restitution"', "restitution"),
    "twice": ("[parameters.restitution]", '[parameters."springs.steeve.preload_length_mm"]'),
    "text": ("[parameters.preload]", '[parameters."springs.steeve.joint"]'),
    "two ways of an inertia": ("[parameters.preload]\nlow = 9.0\nhigh = 13.0",
        '[parameters."links.top_nipper.gyration_mm"'
        ']\nlow = 20.0\nhigh = 40.0\n[parameters."links.top_nipper.inertia_kg_m2"]\nlow = 1e-4\n'
        "high = 1e-2"),
    "two springs": (*NO_SET, 'model = "e62"', 'model = "two_springs"'),
    "no spring": f'{HEAD}title = "t"\nmodel = "free"\n{FREE}{AIMS}',
    **{name: ('model = "e62"', f'model = "{name}"') for name in ("third_phase", "clamped_first",
        "one_drive", "stop_elsewhere")},
    "opening of a slide": ('model = "e62"', 'model = "steeve_last"'),
}  # fmt: skip
FIT_KEYS = {
    "fine": ("tolerance = 1e-4", "tolerance = 0.9e-13"),
    "coarse": ("tolerance = 1e-4", "tolerance = 1.1e-4"),
    "no rest": ("rest_rate = 1e-3", "rest_rate = 0.0"),
    "no speed": ("speed_rpm = 450.0", "speed_rpm = 0.0"),
    "restitution": ("restitution = 0.2,", "restitution = 1.000001,"),
    "restitution below zero": ("restitution = 0.2,", "restitution = -1e-300,"),
    "no stiffness": ("stiffness_N_per_m = 9500.0", "stiffness_N_per_m = 0.0"),
    "stiffness without a unit": ("stiffness_N_per_m = 9500.0", "stiffness = 9500.0"),
    "weight": ("prior_weight = 0.5", "prior_weight = -0.5"),
    "table": ("[limits]", "[limit]"),
    "other limit": ("jaw_opening_deg", "least_opening_deg"),
    "range as a list": ("{ low = 0.0, high = 35.0 }", "[33, 35]"),
    "tolerance at the top": ("prior_weight = 0.5", "tolerance = 1e-8"),
    "no targets": f'{HEAD}title = "t"\nmodel = "e62"\n{FREE}',
    "format": ("format = 1", "format = 2"),
    "other table": (FREE, "[free.preload]\nlow = 9.0\nhigh = 13.0\n"),
    "nothing free": (FREE, "[parameters]\n"),
    "no measurements": ('"seen.csv"', '"absent.csv"'),
}  # fmt: skip
FIT_NAMES = {
    "quantity": ("rebound_time_s_2", "beauty"),
    "key": path("preload", '"springs.steeve.colour"'),
    "point": path("preload", '"points.elbow.x_mm"'),
    "coordinate": path("preload", '"points.jaw.y_mm"'),
}  # fmt: skip
SEEN_KEYS = {
    "unit": ("quantity;stiffness_N_per_m", f"quantity;{ANGULAR}"),
    "stiffness": (";9500;", ";0;"),
    "restitution": (";0,5", ";1,01"),
    "restitution below zero": (";0,5", ";-0,01"),
    "speed": ("\n450;", "\n0;"),
    "sigma": ("1e-5", "0"),
    "points beside commas": ("\n450;", "\n4.5e2;"),
}  # fmt: skip
CAMERA_KEYS = {
    "decimal comma": ("5.44e-3,0.00003", "0,00544,0,00003"),
    "comma in quotes": ("0.00531", '"0,00531"'),
    "comma of a speed": ("\n450,,", "\n450,5,,"),
    "word": ("5.44e-3", "fast"),
    "no number": ("5.44e-3", "nan"),
    "infinite": ("5.44e-3", "1e400"),
    "line below": ("5.44e-3", "1_000"),
    "nothing": ("5.44e-3", ""),
    "sigma below zero": ("5e-5", "-1e-5"),
    "restitution": ("0.25,reb", "1.25,reb"),
    "speed below zero": ("650,0.25", "-650,0.25"),
    "many fields": ("5e-5", "5e-5,7"),
    "column twice": ("speed_rpm,restitution", "speed_rpm,sigma"),
    "column missing": (",sigma\n", "\n"),
    "empty": (CAMERA, ""),
    "empty lines": (CAMERA, "\n\n"),
    "heading alone": (CAMERA[CAMERA.index("650") :], ""),
}  # fmt: skip
CAMERA_NAMES = {
    "quantity": ("rebound_time_s_1", "bounce"),
    "other name": ("rebound_time_s_1", "first_rebound_time"),
    "column": ("speed_rpm,restitution", "speed_rpm,colour"),
}  # fmt: skip

LIMIT, AIM = "low = 1e-3, high = 2.0", 'minimise = "rebound_amplitude_1"'
DESIGN_VALUES = {
    "one aim twice": ('["clamping_force_N"]', '["rebound_amplitude_1"]'),
    "no aim": (AIM, "", 'maximise = ["clamping_force_N"]', ""),
    "three aims": (AIM, 'minimise = ["rebound_amplitude_1", "duration_s"]'),
    "limits crossed": (LIMIT, "low = 2.5, high = 2.0"),
    "no limit": (LIMIT, ""),
    "index above forty": ("high = 40.0 }", "high = 40.5 }"),
    "index below zero": ("{ low = 0.0 }", "{ low = -0.5 }"),
    "infinite limit": ("high = 2.0", "high = inf"),
    "limit that is no number": ("low = 1e-3", "low = nan"),
    "equal bounds": ("high = 13.0", "high = 9.0"),
    "infinite bound": ("high = 13.0", "high = inf"),
    "no speed": ("low = 400.0", "low = 0.0"),
    "restitution": ("restitution = 0.25", "", "[parameters.preload]\nlow = 9.0\nhigh = 13.0",
        "[parameters.restitution]\nlow = 0.5\nhigh = 1.5"),
    "preload that no spring has": ("low = 9.0", "low = -1e18"),
    "what is set": ("restitution = 0.25", "preload = 10.0"),
    "nothing is free": f'{HEAD}minimise = "duration_s"\nparameters = {{}}\n',
    "no TOML": (AIM, "minimise ="),
}  # fmt: skip
DESIGN_KEYS = {
    "format": ("format = 1", "format = 2"),
    "fine": ("tolerance = 1e-6", "tolerance = 0.9e-13"),
    "coarse": ("tolerance = 1e-6", "tolerance = 1.1e-6"),
    "no rest": ("rest_rate = 1e-3", "rest_rate = 0.0"),
    "no speed": ("speed_rpm = 512.5", "speed_rpm = 0.0"),
    "unknown key": ("format = 1", "format = 1\nstart = 1"),
    "speed at the top": ("format = 1", "format = 1\nspeed_rpm = 60.0"),
    "number among the aims": ('["clamping_force_N"]', '["clamping_force_N", 3]'),
    "other bounds": ("low = 9.0", "lower = 9.0"),
    "other limit": (LIMIT, "upper = 1.0"),
    "other limits": ("[limits]", "[constraints]"),
    "key of no table": f"{HEAD}[optimise]\n",
    "list of parameters": f'{HEAD}minimise = "duration_s"\n[[parameters]]\npath = "x"\n',
    "path": path("preload", '"stops.floor.restitution"'),
    "name": path("preload", "nothing"),
    "two ways of an inertia": ("[parameters.preload]\nlow = 9.0\nhigh = 13.0",
        '[parameters."links.top_nipper.gyration_mm"'
        ']\nlow = 20.0\nhigh = 40.0\n[parameters."links.top_nipper.inertia_kg_m2"]\nlow = 1e-4\n'
        "high = 1e-2"),
    "no phases": ('model = "e62"', 'model = "third_phase"'),
    "opening of a slide": ('model = "e62"', 'model = "steeve_last"', '["clamping_force_N"]',
        '["jaw_opening_deg"]'),
    "stroke of a hinge": ('model = "e62"', 'model = "steeve_last"', "closing_index =",
        "stroke_mm ="),
}  # fmt: skip
DESIGN_NAMES = {
    "aim": (AIM, 'minimise = "beauty"'),
    "old name": (AIM, 'minimise = "transition_time_s"'),
    "limit": ("duration_s =", "beauty ="),
}  # fmt: skip

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
