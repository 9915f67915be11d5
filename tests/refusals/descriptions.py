"""Mistakes in the TOML file of a model: edit, place and value."""

from __future__ import annotations

import math

from tests.refusals.bases import Row

JAW = "restitution = 0.2\ncontact"
BAR = "crank_radius_mm = 64.0"
ENDS = '[stops.jaw]\njoint = "jaw"'
CLOSURE = '[closures.eccentric_pin]\nframe_a = "rod_head"\nframe_b = "eccentric_pin"\n'

# Of the E62: values, keys, and tables that do not fit one another.
VALUES = {
    "above the range": Row((JAW, "restitution = 1.2\ncontact"), "stops.jaw.restitution", 1.2),
    "not positive": Row(("= 9000.0", "= 0"), "springs.steeve.stiffness_N_per_m", 0),
    "not a number": Row(("= 450.0", "= 'fast'"), "cylinder.rated_speed_rpm", "fast"),
    "infinite": Row(("= 11.0", "= inf"), "springs.steeve.preload_length_mm", math.inf),
    "no choice": Row(('direction = "clockwise"', 'direction = "left"'),
                     "cylinder.direction", "left"),
    "law": Row(('law = "geared"', 'law = "chain"'), "drives.tension.law", "chain"),
    "no law": Row(('law = "geared"', ""), "drives.tension.law", None),
    "key": Row((JAW, "bounce = 3\n" + JAW), "stops.jaw.bounce", 3),
    "key below": Row(('lower = "bottom', 'lowest = "x", lower = "bottom'),
                     "stops.jaw.contact.lowest", "x"),
    "key of a drive": Row(("ratio = 2.2 ", "ratio = 2.2\nteeth = 40 #"),
                          "drives.tension.teeth", 40),
    "section": Row(("[stops.jaw]", "[brakes]\n[stops.jaw]"), "brakes", {}),
    "section that is no table": Row(("format = 1", "format = 1\ninitial = 7"), "initial", 7),
    "missing key": Row(('frame_b = "cylinder_axis"', ""), "closures.rocker_axis.frame_b", None),
    "short point": Row(("[-190.0, -20.0]", "[-190.0]"), "drives.pendulum.guide_axis_mm", [-190.0]),
    "whole number": Row(("number = 2", "number = 2.5"), "phases[1].number", 2.5),
    "phase zero": Row(("number = 2", "number = 0"), "phases[1].number", 0),
    "phase without a name": Row(('"jaw open"', '""'), "phases[0].name", ""),
    "stop without a name": Row(('["steeve"]', '[""]'), "phases[0].closed[0]", ""),
    "format": Row(("format = 1", "format = 2"), "format", 2),
    "crank too long": Row((BAR, "crank_radius_mm = 200.0"), "drives.pendulum.crank_radius_mm", 200),
    "offset too large": Row(("guide_offset_mm = 0.0", "guide_offset_mm = -130.0"),
                            "drives.pendulum.guide_offset_mm", -130.0),
    "guide beside its hinge": Row(("[-190.0, -20.0]", "[-187.0, -16.0]"),
                                  "drives.pendulum.guide_axis_mm", [-187.0, -16.0]),
    "geared to itself": Row(('of = "pendulum"', 'of = "tension"'), "drives.tension.of", "tension"),
    "two references": Row(('reference_extreme = "minimum"', "reference_angle_deg = 3.0"),
                          "cylinder.reference_drive", "pendulum"),
    "no reference": Row(('reference_drive = "pendulum"', ""), "cylinder.reference_drive", None),
    "reference that goes round": Row((
        'reference_drive = "pendulum"', 'reference_drive = "round"',
        "[drives.tension]\njoint", '[drives.round]\njoint = "jaw"\nlaw = "constant_speed"\nratio = '
        "1.0\n\n[drives.tension]\njoint"), "cylinder.reference_drive", "round"),
    "index of forty": Row(("reference_index = 24.0", "reference_index = 40.0"),
                          "cylinder.reference_index", 40.0),
    **{f"gravity of {text}": Row(("gravity_m_s2 = 9.81", f"gravity_m_s2 = {text}"),
                                 "gravity_m_s2", value)
       for text, value in (("1.1e15", 1.1e15), ("-1.1e15", -1.1e15), ("1e308", 1e308),
                           ("10000000000000000", 10**16))},
    "many turns": Row(("angle_at_touch_deg = 166.0", "angle_at_touch_deg = -3600.1"),
                      "cylinder.angle_at_touch_deg", -3600.1),
    "same phase number": Row(("number = 2", "number = 1"), "phases[1].number", 1),
    "same phase": Row(('closed = ["jaw"]', "closed = []"), "phases[2].closed", []),
    "initial phase": Row(("initial_phase = 1", "initial_phase = 4"), "initial_phase", 4),
    "driven slide": Row(('joint = "tension_shaft"', 'joint = "steeve"'),
                        "drives.tension.joint", "steeve"),
    "driven twice": Row(('joint = "tension_shaft"', 'joint = "pendulum_shaft"'),
                        "drives.tension.joint", "pendulum_shaft"),
    "driven stop": Row((ENDS, '[stops.jaw]\njoint = "tension_shaft"'),
                       "stops.jaw.joint", "tension_shaft"),
    "spring of the other kind": Row(('[springs.steeve]\njoint = "steeve"',
                                     '[springs.steeve]\njoint = "jaw"'),
                                    "springs.steeve.stiffness_N_per_m", 9000.0),
    "shortcut to a text": Row(('= "stops.jaw.restitution"', '= "stops.jaw.joint"'),
                              "shortcuts.restitution", "stops.jaw.joint"),
    "no TOML": Row(("title = ", "title "), "TOML", ...),
    "no transition stop": Row(('transition_stop = "jaw"', ""), "transition_stop", None),
    "closure left out": Row((CLOSURE, ""), "degrees_of_freedom", 3),
    "drives against closures": Row(('joint = "tension_shaft"', 'joint = "nipper_pivot"'), ..., ...),
    "stops against drives": Row(('closed = ["jaw"]', 'closed = ["jaw", "steeve"]'),
                                "phases[1].closed", ["jaw", "steeve"]),
    "contact without shapes": Row(('lower = "bottom_lip"', 'lower = "rocker_foot"'),
                                  "link rocker_foot collision", None),
}  # fmt: skip
CLOSURES = {
    "twice": Row((CLOSURE, CLOSURE + CLOSURE.replace("closures.eccentric_pin", "closures.again")),
                 "closures", ["eccentric_pin x", "eccentric_pin z", "again x", "again z"]),
    "within one link": Row(('frame_b = "cylinder_axis"', 'frame_b = "rocker_foot"'),
                           "closures", ["rocker_axis x", "rocker_axis z"]),
}  # fmt: skip
NAMES = {
    "joint of a drive": Row(('joint = "tension_shaft"', 'joint = "shaft"'), "joint", "shaft"),
    "joint of a stop": Row((ENDS, '[stops.jaw]\njoint = "lips"'), "joint", "lips"),
    "frame": Row(('frame_a = "rod_head"', 'frame_a = "head"'), "frame", "head"),
    "drive": Row(('of = "pendulum"', 'of = "pendel"'), "drive", "pendel"),
    "reference": Row(('reference_drive = "pendulum"', 'reference_drive = "crank"'),
                     "drive", "crank"),
    "stop of a phase": Row(('closed = ["jaw"]', 'closed = ["lip"]'), "stop", "lip"),
    "transition stop": Row(('transition_stop = "jaw"', 'transition_stop = "x"'), "stop", "x"),
    "shortcut": Row(("springs.steeve.pre", "springs.sleeve.pre"), "key", "sleeve"),
    "shape of a contact": Row(('lower = "bottom_lip"', 'lower = "foot"'),
                              "link or collision element", "foot"),
}  # fmt: skip

RAIL = 'joint = "rail"'
ROWS = f"{RAIL}, coordinate_mm = [0.0, 2.0, 5.0], force_N = [90.0, 100.0, 130.0]"
POINTS = 'frame_a = "a", frame_b = "b", stiffness_N_per_m = 9000.0, free_length_mm = 186.5'
SPRING = f"{RAIL}, preload_length_mm = 0.0, stiffness_N_per_m = "


def spring(text: str, place: str, value: object) -> Row:
    return Row(f"springs.coil = {{ {text} }}", f"springs.coil.{place}", value)


# Of the small machine.
SPRINGS = {
    "joint and points": spring(f"{RAIL}, {POINTS}", "joint", "rail"),
    "one point": spring('frame_a = "a", stiffness_N_per_m = 1.0, free_length_mm = 1.0',
                        "frame_b", None),
    "no free length": spring(POINTS.partition(", free")[0], "free_length_mm", None),
    "negative length": spring(POINTS.replace("186.5", "-1.0"), "free_length_mm", -1.0),
    "long": spring(POINTS.replace("186.5", "1.1e15"), "free_length_mm", 1.1e15),
    "nowhere": spring("stiffness_N_per_m = 1.0, preload_length_mm = 1.0", "joint", None),
    "only a joint": spring(RAIL, "stiffness_N_per_m", None),
    "one link": spring(POINTS.replace('"b"', '"a"'), "frame_b", "a"),
    "points that coincide": spring(POINTS.replace('"b"', '"frame"').replace('"a"', '"lever"'),
                                   "frame_b", "frame"),
    "stiffness and rows": spring(f"{ROWS}, stiffness_N_per_m = 3.0", "stiffness_N_per_m", 3.0),
    "rows of the other kind": spring(ROWS.replace("force_N", "torque_N_m"), "force_N", None),
    "rows that fall back": spring(ROWS.replace("2.0", "6.0"), "coordinate_mm", "3 rows"),
    "equal rows": spring(ROWS.replace("5.0", "2.0"), "coordinate_mm", "3 rows"),
    "rows too near": spring(ROWS.replace("5.0", "2.0000000005"), "coordinate_mm", "3 rows"),
    "rows beside touch": spring(ROWS.replace("[0.0", "[0.5"), "coordinate_mm", ...),
    "columns of two lengths": spring(ROWS.replace("90.0, ", ""), "coordinate_mm", "3 rows"),
    "one row": spring(f"{RAIL}, coordinate_mm = [0.0], force_N = [1.0]", "coordinate_mm", "1 rows"),
    "large force": spring(ROWS.replace("100.0", "-2e15"), "force_N[1]", -2e15),
    "infinite row": spring(ROWS.replace("2.0", "nan"), "coordinate_mm[1]", ...),
    "text in a row": spring(ROWS.replace("100.0", '"x"'), "force_N[1]", "x"),
    "no stiffness": spring(SPRING + "0.0", "stiffness_N_per_m", 0.0),
    "too stiff": spring(SPRING + "1.1e15", "stiffness_N_per_m", 1.1e15),
    "damping of the other kind": Row(f"dampers.oil = {{ {RAIL}, damping_N_m_s_per_rad = 1.0 }}",
                                     "dampers.oil.damping_N_s_per_m", None),
    "negative damping": Row(f"dampers.oil = {{ {RAIL}, damping_N_s_per_m = -1e-9 }}",
                            "dampers.oil.damping_N_s_per_m", -1e-9),
    "much damping": Row(f"dampers.oil = {{ {RAIL}, damping_N_s_per_m = 1.1e15 }}",
                        "dampers.oil.damping_N_s_per_m", 1.1e15),
}  # fmt: skip

TURN = "cylinder_angle_deg = [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0, 360.0]"
SWING = "coordinate_rad = [0.0, 0.1, 0.2, 0.1, 0.0, -0.1, -0.2, -0.1, 0.0]"
TABLE = f'joint = "axle", law = "table", {TURN}, {SWING}'
CAM = ('joint = "axle", law = "cam", motion = "cycloidal", lift_deg = 3.0, rise_deg = 200.0, '
       "return_deg = 150.0, dwell_deg = 20.0")  # fmt: skip
GUIDE = ('joint = "axle", law = "oscillating_guide", crank_radius_mm = 30.0, '
         "crank_axis_mm = [0.0, 40.0], guide_axis_mm = [30.0, 0.0]")  # fmt: skip


def drive(text: str, place: str, value: object) -> Row:
    return Row(f"drives.x = {{ {text} }}", f"drives.x.{place}", value)


def geared(of: str, *names: str) -> str:
    """Drives of the joints in turn, each geared to the next name."""
    joints = ("axle", "pivot", "rail")
    return "\n".join(
        f'drives.{name} = {{ joint = "{joint}", law = "geared", of = "{after}", ratio = 2.0 }}'
        for name, joint, after in zip(names, joints, (*names[1:], of), strict=False)
    )


DRIVES = {
    "few rows": drive('joint = "axle", law = "table", cylinder_angle_deg = [0.0, 360.0], '
                      "coordinate_rad = [0.0, 0.0]", "cylinder_angle_deg", "2 rows"),
    "two lengths": drive(TABLE.replace(", 0.0]", "]"), "cylinder_angle_deg", "9 rows"),
    "infinite value": drive(TABLE.replace("0.2,", "nan,"), "coordinate_rad[2]", ...),
    "equal angles": drive(TABLE.replace("225.0", "180.0"), "cylinder_angle_deg", "9 rows"),
    "falling angles": drive(TABLE.replace("90.0", "30.0"), "cylinder_angle_deg", "9 rows"),
    "less than a turn": drive(TABLE.replace("360.0", "359.0"), "cylinder_angle_deg", "9 rows"),
    "more than a turn": drive(TABLE.replace("360.0", "360.0000001"),
                              "cylinder_angle_deg", "9 rows"),
    "two ends": drive(TABLE.replace(", 0.0]", ", 0.25]"), "cylinder_angle_deg", "9 rows"),
    "cam of more than a turn": drive(CAM, "dwell_deg", 20.0),
    **{f"cam of a slide: {name}": drive(
        'joint = "rail", law = "cam", motion = "cycloidal", rise_deg = 200.0, return_deg = 150.0'
        f"{text}", place, value) for name, text, place, value in (
            ("no lift", "", "lift_mm", None),
            ("lift of nothing", ", lift_mm = 0.0", "lift_mm", 0.0),
            ("lift of a hinge", ", lift_deg = 3.0", "lift_deg", 3.0),
            ("inertia", ", lift_mm = 3.0, reflected_inertia_kg_m2 = 1.0",
             "reflected_inertia_kg_m2", 1.0))},
    "cam that rises at once": drive(CAM.replace("200.0", "0.0"), "rise_deg", 0.0),
    "cam that rises in no time": drive(CAM.replace("200.0", "5e-324"), "dwell_deg", 20.0),
    "cam that returns in no time": drive(CAM.replace("150.0", "5e-324"), "dwell_deg", 20.0),
    "rows of a turn too near": drive(TABLE.replace("90.0", "45.000000000006"),
                                     "cylinder_angle_deg", "9 rows"),
    "row of a turn too far": drive(TABLE.replace("0.2,", "1e16,"), "coordinate_rad[2]", 1e16),
    "motion of a cam": drive(CAM.replace("cycloidal", "harmonic"), "motion", "harmonic"),
    "series of a hinge on a slide": drive('joint = "rail", law = "fourier", sine_rad = [0.1]',
                                          "sine_rad", ...),
    "slide at a constant speed": drive('joint = "rail", law = "constant_speed", ratio = 1.0',
                                       "joint", "rail"),
    "guide that jams": drive(f"{GUIDE}, guide_offset_mm = -21.0", "guide_offset_mm", -21.0),
    "no crank": drive(GUIDE.replace("30.0,", "0.0,", 1), "crank_radius_mm", 0.0),
    "crank as long as its distance": drive(GUIDE.replace("30.0,", "50.0,", 1),
                                           "crank_radius_mm", 50.0),
    "circle of gears": Row(geared("x", "x", "y"), "drives.y.of", "x"),
    "gears before a circle": Row(geared("y", "x", "y", "z"), "drives.z.of", "y"),
}  # fmt: skip
SMALL_NAMES = {
    "gears of nothing": Row(geared("y", "x"), "drive", "y"),
    "point of a spring": spring(POINTS.replace('"b"', '"pin"'), "", "pin")._replace(place="frame"),
    "joint of a spring": spring(ROWS.replace("rail", "rod"), "", "rod")._replace(place="joint"),
    "joint of a damper": Row('dampers.oil = { joint = "rod", damping_N_s_per_m = 1.0 }',
                             "joint", "rod"),
    "joint that starts": Row("initial.x = {}", "joint", "x"),
    "frame of a slot": Row('closures.t = { frame_a = "a", frame_b = "d", slot_axis = "x", '
                           "block_mass_kg = 1.0 }", "frame", "d"),
}  # fmt: skip


def start(joint: str, text: str, place: str, value: object) -> Row:
    return Row(f"initial.{joint} = {{ {text} }}", f"initial.{joint}{place}", value)


def stop(text: str, place: str, value: object) -> Row:
    return Row(f"stops.x = {{ restitution = 0.0, {text} }}", f"stops.x{place}", value)


def tie(text: str, place: str, value: object, freedom: int = 3) -> Row:
    closed = f'closures.tie = {{ frame_a = "a", frame_b = "b"{text} }}'
    number = "degrees_of_freedom = "
    return Row((f"{number}3", f"{number}{freedom}\n{closed}"), place, value)


SLOT = ', slot_axis = "x", block_mass_kg = 0.1'
MEET = ("0.103 0 0.004", "0.1 0 0.0")
APART = {
    "frames apart": tie("", "closures.tie", "a gap of 5 mm (x 3, z 4) from a to b"),
    "frame beside its slot": tie(SLOT, "closures.tie",
                                 "a gap of 4 mm (x 0, z 4) from the slot along x of a to b"),
}  # fmt: skip
STARTS_AND_STOPS = {
    "start beyond an upper stop": start("pivot", "at_deg = 31.5", ".at_deg", 31.5),
    "start beyond a lower stop": start("pivot", "at_deg = -22.25", ".at_deg", -22.25),
    "start beyond the end of a slide": start("rail", "at_mm = -4.5", ".at_mm", -4.5),
    "start of a slide in degrees": start("rail", "at_deg = 1.0", ".at_deg", 1.0),
    "rate of a hinge in mm": start("pivot", "rate_mm_per_s = 0.0", ".rate_mm_per_s", 0.0),
    "start of a driven joint": Row('drives.d = { joint = "axle", law = "constant_speed", ratio = '
                                   "1.0 }\ninitial.axle = { at_deg = 3.0 }", "initial.axle", 3.0),
    "place of a stop in mm": stop('joint = "axle", at_mm = 1.0', ".at_mm", 1.0),
    "place of a stop in degrees": stop('joint = "rail", at_deg = 1.0, side = "upper"',
                                       ".at_deg", 1.0),
    "two lower stops": stop('joint = "rail", at_mm = 3.0', "", "lower stop at 3 mm"),
    "no room between stops": stop('joint = "rail", at_mm = -4.0, side = "upper"', "",
                                  "upper stop at -4 mm"),
    "place of a stop that is none": stop('joint = "rail", at_mm = nan', ".at_mm", ...),
    "side of a stop": stop('joint = "rail", side = "left"', ".side", "left"),
    "upper stop below the lower one": stop('joint = "rail", at_mm = -5.0, side = "upper"', "",
                                           "upper stop at -5 mm"),
    "both stops of a joint closed": Row(("closed = []", 'closed = ["low", "high"]'),
                                        "phases[0].closed", ["high", "low"]),
    "restitution": Row('stops.x = { joint = "axle", restitution = 1.01 }',
                       "stops.x.restitution", 1.01),
    "freedoms": Row(("degrees_of_freedom = 3", "degrees_of_freedom = 1"), "degrees_of_freedom", 1),
    "no freedom": Row(("degrees_of_freedom = 3", "degrees_of_freedom = 0"),
                      "degrees_of_freedom", 0),
    "slot without a block": tie(', slot_axis = "x"', "closures.tie.block_mass_kg", None),
    "block without a slot": tie(", block_mass_kg = 1.0", "closures.tie.slot_axis", None),
    "slot called as a joint": Row('closures.pivot = { frame_a = "a", frame_b = "b"' + SLOT + " }",
                                  "closures.pivot", "pivot"),
    "block called as a link": Row(('<link name="c"/>', '<link name="tie_block"/>',
                                   'child link="c"', 'child link="tie_block"',
                                   "gravity_m_s2", 'closures.tie = { frame_a = "a", frame_b = "b"'
                                   + SLOT + " }\ngravity_m_s2"), "closures.tie", "tie"),
    "freedoms with a closure": Row((*tie("", "", 0).edits, *MEET), "degrees_of_freedom", 3),
    "freedoms with a slot": Row((*tie(SLOT, "", 0).edits, "0.103 0 0.004", "0.103 0 0.0"),
                                "degrees_of_freedom", 3),
    "no title": Row(('"a lever, a wheel and a sled"', '""'), "title", ""),
    "no phases": Row(('[{ number = 1, name = "free", closed = [] }]', "[]"), "phases", []),
    "gravity upwards": Row(("= 9.81", "= -0.1"), "gravity_m_s2", -0.1),
    "name that no message can show": Row('"a\\nb" = 1', "key", "a\nb"),
    "name of a table that none can": Row('dampers."x\\t" = {}', "dampers", "x\t"),
    "name in a list that none can": Row(("closed = [] }", 'closed = [], deep = { "\\b" = 1 } }'),
                                        "phases.deep", "\b"),
    "deep TOML": Row("x = " + "[" * 10**5 + "]" * 10**5, "TOML", "too deep"),
    "long number": Row(("degrees_of_freedom = 3", f"degrees_of_freedom = {'9' * 5000}"),
                       "TOML", "a number too long"),
    "escape in a title": Row(('"a lever, ', '"\\u001b[2J'), "title", ...),
    "control character of eight bits": Row(('"a lever, ', '"\\u009b2J'), "title", ...),
    "text that is turned round": Row(('"a lever, ', '"\\u202etxt'), "title", ...),
    "formula as a key": Row('stops."=1+1" = { joint = "axle", restitution = 0.0 }',
                            "stops", "=1+1"),
}  # fmt: skip

HEAD, LINES = b"coordinate_mm,force_N\n", b"0.0,90.0\n2.0,100.0\n5.0,130.0\n"


def file(content: bytes, place: object, value: object, more: str = "") -> Row:
    text = f'springs.coil = {{ joint = "rail", file = "coil.csv"{more} }}'
    return Row(text, place, value, {"coil.csv": content})


SWINGS = (
    b"cylinder_angle_deg,coordinate_rad\n0,0\n45,1\n90,2\n135,1\n180,0\n225,-1\n270,-2\n360,0\n"
)


def swings(
    place: object, value: object, old: bytes = b"", new: bytes = b"", name: str = "x"
) -> Row:
    text = f'drives.x = {{ joint = "axle", law = "table", file = "{name}.csv" }}'
    return Row(text, place, value, {"x.csv": SWINGS.replace(old, new)})


# Rows of springs and drives in a file of their own.
FILES = {
    "column": file(b"coordinate_mm,force\n" + LINES, ..., ...),
    "number": file(HEAD + LINES.replace(b"100.0", b"soft"), "line 3 force_N", "soft"),
    "no number": file(HEAD + LINES.replace(b"100.0", b""), "line 3 force_N", ""),
    "order": file(HEAD + LINES.replace(b"5.0", b"1.0"), "table", "3 rows"),
    "one row": file(HEAD + b"0.0,90.0\n", ..., ...),
    "the other kind": file(b"coordinate_deg,torque_N_m\n" + LINES, ..., ...),
    "file and columns": file(HEAD + LINES, ..., ..., ", force_N = [1.0]"),
    "file and stiffness": file(HEAD + LINES, ..., ..., ", stiffness_N_per_m = 1.0"),
    "bytes": file(HEAD + b"\xff\xfe,1\n", ..., ...),
    "angles": swings("table", "8 rows", b"\n135", b"\n35"),
    "swing": swings("line 5 coordinate_rad", "nan", b"135,1", b"135,nan"),
    "swing left out": swings("line 5 coordinate_rad", "", b"135,1", b"135,"),
    "less than a turn": swings("table", "8 rows", b"360", b"359.5"),
    "ends": swings("table", "8 rows", b"360,0", b"360,0.5"),
    "columns of a drive": swings("first line", ..., b"coordinate_rad", b"value"),
    "above the folder": swings("drives.x.file", "../x.csv", name="../x"),
    "anywhere": swings("drives.x.file", "/tmp/x.csv", name="/tmp/x"),
    "missing": swings("drives.x.file", "y.csv", name="y"),
    "no text": Row("", ..., ..., {"small.toml": b"\xff\xfe"}),
    "long field": file(HEAD + b"1" * 200_000 + b",1\n", ..., ...),
}  # fmt: skip

# Values at their bounds, which are taken.
TAKEN = {
    "no bounce and no loss": 'stops.x = { joint = "axle", restitution = 1.0 }\n'
                             'stops.y = { joint = "rail", side = "upper", restitution = 0 }',
    "dampers": f"dampers.x = {{ {RAIL}, damping_N_s_per_m = 1e15 }}\n"
               'dampers.y = { joint = "axle", damping_N_m_s_per_rad = 0.0 }',
    "stiffest": f"springs.coil = {{ {SPRING}1e15 }}",
    "rows of springs": f"springs.coil = {{ {ROWS.replace('5.0', '2.000000002')} }}",
    "rows of a drive": f"drives.x = {{ {TABLE.replace('225.0, 270.0, ', '')} }}".replace(
        "-0.1, -0.2, ", ""),
    "end of a turn": f"drives.x = {{ {TABLE.replace('360.0', '360.00000005')} }}",
    "ends of a swing": f"drives.x = {{ {TABLE.replace(', 0.0]', ', 9e-10]')} }}",
    "index": ("reference_index = 0.0", "reference_index = 39.999999"),
    "ten turns": ("angle_at_touch_deg = 0.0", "angle_at_touch_deg = -3600.0"),
    "start at a stop": "initial.pivot = { at_deg = 30.0, rate_rad_per_s = -2.0 }",
    "slot": (*tie(SLOT, "", 0, 2).edits, "0.103 0 0.004", "0.103 0 0.0"),
}  # fmt: skip
