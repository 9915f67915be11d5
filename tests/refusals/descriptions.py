"""Mistakes in the TOML file of a model; its snapshots say what is said of each."""

from __future__ import annotations

from tests.refusals.bases import Row

JAW = "restitution = 0.2\ncontact"
BAR = "crank_radius_mm = 64.0"
ENDS = '[stops.jaw]\njoint = "jaw"'
CLOSURE = '[closures.eccentric_pin]\nframe_a = "rod_head"\nframe_b = "eccentric_pin"\n'

# Of the E62: values, keys, and tables that do not fit one another.
VALUES = {
    "above the range": (JAW, "restitution = 1.2\ncontact"),
    "not positive": ("= 9000.0", "= 0"),
    "not a number": ("= 450.0", "= 'fast'"),
    "infinite": ("= 11.0", "= inf"),
    "no choice": ('direction = "clockwise"', 'direction = "left"'),
    "law": ('law = "geared"', 'law = "chain"'),
    "no law": ('law = "geared"', ""),
    "key": (JAW, "bounce = 3\n" + JAW),
    "key below": ('lower = "bottom', 'lowest = "x", lower = "bottom'),
    "key of a drive": ("ratio = 2.2 ", "ratio = 2.2\nteeth = 40 #"),
    "section": ("[stops.jaw]", "[brakes]\n[stops.jaw]"),
    "section that is no table": ("format = 1", "format = 1\ninitial = 7"),
    "missing key": ('frame_b = "cylinder_axis"', ""),
    "short point": ("[-190.0, -20.0]", "[-190.0]"),
    "whole number": ("number = 2", "number = 2.5"),
    "phase zero": ("number = 2", "number = 0"),
    "phase without a name": ('"jaw open"', '""'),
    "stop without a name": ('["steeve"]', '[""]'),
    "format": ("format = 1", "format = 2"),
    "crank too long": (BAR, "crank_radius_mm = 200.0"),
    "offset too large": ("guide_offset_mm = 0.0", "guide_offset_mm = -130.0"),
    "guide beside its hinge": ("[-190.0, -20.0]", "[-187.0, -16.0]"),
    "geared to itself": ('of = "pendulum"', 'of = "tension"'),
    "two references": ('reference_extreme = "minimum"', "reference_angle_deg = 3.0"),
    "no reference": ('reference_drive = "pendulum"', ""),
    "reference that goes round": ('reference_drive = "pendulum"', 'reference_drive = "round"',
        "[drives.tension]\njoint", '[drives.round]\njoint = "jaw"\nlaw = "constant_speed"\nratio = '
        "1.0\n\n[drives.tension]\njoint"),
    "index of forty": ("reference_index = 24.0", "reference_index = 40.0"),
    **{f"gravity of {text}": ("gravity_m_s2 = 9.81", f"gravity_m_s2 = {text}")
       for text in ("1.1e15", "-1.1e15", "1e308", "10000000000000000")},
    "many turns": ("angle_at_touch_deg = 166.0", "angle_at_touch_deg = -3600.1"),
    "same phase number": ("number = 2", "number = 1"),
    "same phase": ('closed = ["jaw"]', "closed = []"),
    "initial phase": ("initial_phase = 1", "initial_phase = 4"),
    "driven slide": ('joint = "tension_shaft"', 'joint = "steeve"'),
    "driven twice": ('joint = "tension_shaft"', 'joint = "pendulum_shaft"'),
    "driven stop": (ENDS, '[stops.jaw]\njoint = "tension_shaft"'),
    "spring of the other kind": ('[springs.steeve]\njoint = "steeve"',
        '[springs.steeve]\njoint = "jaw"'),
    "shortcut to a text": ('= "stops.jaw.restitution"', '= "stops.jaw.joint"'),
    "no TOML": ("title = ", "title "),
    "no transition stop": ('transition_stop = "jaw"', ""),
    "closure left out": (CLOSURE, ""),
    "drives against closures": ('joint = "tension_shaft"', 'joint = "nipper_pivot"'),
    "stops against drives": ('closed = ["jaw"]', 'closed = ["jaw", "steeve"]'),
    "contact without shapes": ('lower = "bottom_lip"', 'lower = "rocker_foot"'),
}  # fmt: skip
CLOSURES = {
    "twice": (CLOSURE, CLOSURE + CLOSURE.replace("closures.eccentric_pin", "closures.again")),
    "within one link": ('frame_b = "cylinder_axis"', 'frame_b = "rocker_foot"'),
}  # fmt: skip
NAMES = {
    "joint of a drive": ('joint = "tension_shaft"', 'joint = "shaft"'),
    "joint of a stop": (ENDS, '[stops.jaw]\njoint = "lips"'),
    "frame": ('frame_a = "rod_head"', 'frame_a = "head"'),
    "drive": ('of = "pendulum"', 'of = "pendel"'),
    "reference": ('reference_drive = "pendulum"', 'reference_drive = "crank"'),
    "stop of a phase": ('closed = ["jaw"]', 'closed = ["lip"]'),
    "transition stop": ('transition_stop = "jaw"', 'transition_stop = "x"'),
    "shortcut": ("springs.steeve.pre", "springs.sleeve.pre"),
    "shape of a contact": ('lower = "bottom_lip"', 'lower = "foot"'),
}  # fmt: skip

RAIL = 'joint = "rail"'
ROWS = f"{RAIL}, coordinate_mm = [0.0, 2.0, 5.0], force_N = [90.0, 100.0, 130.0]"
POINTS = 'frame_a = "a", frame_b = "b", stiffness_N_per_m = 9000.0, free_length_mm = 186.5'
SPRING = f"{RAIL}, preload_length_mm = 0.0, stiffness_N_per_m = "


def spring(text: str) -> str:
    return f"springs.coil = {{ {text} }}"


# Of the small machine.
SPRINGS = {
    "joint and points": spring(f"{RAIL}, {POINTS}"),
    "one point": spring('frame_a = "a", stiffness_N_per_m = 1.0, free_length_mm = 1.0'),
    "no free length": spring(POINTS.partition(", free")[0]),
    "negative length": spring(POINTS.replace("186.5", "-1.0")),
    "long": spring(POINTS.replace("186.5", "1.1e15")),
    "nowhere": spring("stiffness_N_per_m = 1.0, preload_length_mm = 1.0"),
    "only a joint": spring(RAIL),
    "one link": spring(POINTS.replace('"b"', '"a"')),
    "points that coincide": spring(POINTS.replace('"b"', '"frame"').replace('"a"', '"lever"')),
    "stiffness and rows": spring(f"{ROWS}, stiffness_N_per_m = 3.0"),
    "rows of the other kind": spring(ROWS.replace("force_N", "torque_N_m")),
    "rows that fall back": spring(ROWS.replace("2.0", "6.0")),
    "equal rows": spring(ROWS.replace("5.0", "2.0")),
    "rows too near": spring(ROWS.replace("5.0", "2.0000000005")),
    "rows beside touch": spring(ROWS.replace("[0.0", "[0.5")),
    "columns of two lengths": spring(ROWS.replace("90.0, ", "")),
    "one row": spring(f"{RAIL}, coordinate_mm = [0.0], force_N = [1.0]"),
    "large force": spring(ROWS.replace("100.0", "-2e15")),
    "infinite row": spring(ROWS.replace("2.0", "nan")),
    "text in a row": spring(ROWS.replace("100.0", '"x"')),
    "no stiffness": spring(SPRING + "0.0"),
    "too stiff": spring(SPRING + "1.1e15"),
    "damping of the other kind": f"dampers.oil = {{ {RAIL}, damping_N_m_s_per_rad = 1.0 }}",
    "negative damping": f"dampers.oil = {{ {RAIL}, damping_N_s_per_m = -1e-9 }}",
    "much damping": f"dampers.oil = {{ {RAIL}, damping_N_s_per_m = 1.1e15 }}",
}  # fmt: skip

TURN = "cylinder_angle_deg = [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0, 360.0]"
SWING = "coordinate_rad = [0.0, 0.1, 0.2, 0.1, 0.0, -0.1, -0.2, -0.1, 0.0]"
TABLE = f'joint = "axle", law = "table", {TURN}, {SWING}'
CAM = ('joint = "axle", law = "cam", motion = "cycloidal", lift_deg = 3.0, rise_deg = 200.0, '
       "return_deg = 150.0, dwell_deg = 20.0")  # fmt: skip
GUIDE = ('joint = "axle", law = "oscillating_guide", crank_radius_mm = 30.0, '
         "crank_axis_mm = [0.0, 40.0], guide_axis_mm = [30.0, 0.0]")  # fmt: skip


def drive(text: str) -> str:
    return f"drives.x = {{ {text} }}"


def stop(text: str) -> str:
    return f"stops.x = {{ restitution = 0.0, {text} }}"


def geared(of: str, *names: str) -> str:
    """Drives of the joints in turn, each geared to the next name."""
    joints = ("axle", "pivot", "rail")
    return "\n".join(
        f'drives.{name} = {{ joint = "{joint}", law = "geared", of = "{after}", ratio = 2.0 }}'
        for name, joint, after in zip(names, joints, (*names[1:], of), strict=False)
    )


DRIVES = {
    "few rows": drive('joint = "axle", law = "table", cylinder_angle_deg = [0.0, 360.0], '
        "coordinate_rad = [0.0, 0.0]"),
    "two lengths": drive(TABLE.replace(", 0.0]", "]")),
    "infinite value": drive(TABLE.replace("0.2,", "nan,")),
    "equal angles": drive(TABLE.replace("225.0", "180.0")),
    "falling angles": drive(TABLE.replace("90.0", "30.0")),
    "less than a turn": drive(TABLE.replace("360.0", "359.0")),
    "more than a turn": drive(TABLE.replace("360.0", "360.0000001")),
    "two ends": drive(TABLE.replace(", 0.0]", ", 0.25]")),
    "cam of more than a turn": drive(CAM),
    **{f"cam of a slide: {name}": drive(
        'joint = "rail", law = "cam", motion = "cycloidal", rise_deg = 200.0, return_deg = 150.0'
        f"{text}") for name, text in (
            ("no lift", ""), ("lift of nothing", ", lift_mm = 0.0"),
            ("lift of a hinge", ", lift_deg = 3.0"),
            ("inertia", ", lift_mm = 3.0, reflected_inertia_kg_m2 = 1.0"))},
    "cam that rises at once": drive(CAM.replace("200.0", "0.0")),
    "cam that rises in no time": drive(CAM.replace("200.0", "5e-324")),
    "cam that returns in no time": drive(CAM.replace("150.0", "5e-324")),
    "rows of a turn too near": drive(TABLE.replace("90.0", "45.000000000006")),
    "row of a turn too far": drive(TABLE.replace("0.2,", "1e16,")),
    "motion of a cam": drive(CAM.replace("cycloidal", "harmonic")),
    "series of a hinge on a slide": drive('joint = "rail", law = "fourier", sine_rad = [0.1]'),
    "slide at a constant speed": drive('joint = "rail", law = "constant_speed", ratio = 1.0'),
    "guide that jams": drive(f"{GUIDE}, guide_offset_mm = -21.0"),
    "no crank": drive(GUIDE.replace("30.0,", "0.0,", 1)),
    "crank as long as its distance": drive(GUIDE.replace("30.0,", "50.0,", 1)),
    "force without a law": f"forces.x = {{ {RAIL}, c_N_s2_per_m2 = 1.0 }}",
    "force of no law": f'forces.x = {{ {RAIL}, law = "rubber" }}',
    "restitution without a law": stop(f"{RAIL}, restitution_law = {{ fast = 0.1, scale = 1.0 }}"),
    "stop with two places": stop(f'{RAIL}, at_mm = 3.0, adjusted = {{ law = "screw", '
                                 'pitch_mm = 1.5, turns = 4.0 }'),
    "stop adjusted by no law": stop(f'{RAIL}, adjusted = {{ law = "scruw" }}'),
    "stop adjusted without a law": stop(f"{RAIL}, adjusted = {{ pitch_mm = 1.5, turns = 4.0 }}"),
    "circle of gears": geared("x", "x", "y"),
    "gears before a circle": geared("y", "x", "y", "z"),
}  # fmt: skip
SMALL_NAMES = {
    "gears of nothing": geared("y", "x"),
    "point of a spring": spring(POINTS.replace('"b"', '"pin"')),
    "joint of a spring": spring(ROWS.replace("rail", "rod")),
    "joint of a damper": 'dampers.oil = { joint = "rod", damping_N_s_per_m = 1.0 }',
    "joint that starts": "initial.x = {}",
    "frame of a slot": 'closures.t = { frame_a = "a", frame_b = "d", slot_axis = "x", '
        "block_mass_kg = 1.0 }",
}  # fmt: skip


def start(joint: str, text: str) -> str:
    return f"initial.{joint} = {{ {text} }}"


def tie(text: str, freedom: int = 3) -> tuple[str, str]:
    closed = f'closures.tie = {{ frame_a = "a", frame_b = "b"{text} }}'
    number = "degrees_of_freedom = "
    return f"{number}3", f"{number}{freedom}\n{closed}"


SLOT = ', slot_axis = "x", block_mass_kg = 0.1'
MEET = ("0.103 0 0.004", "0.1 0 0.0")
APART = {
    "frames apart": tie(""),
    "frame beside its slot": tie(SLOT),
}  # fmt: skip
STARTS_AND_STOPS = {
    "start beyond an upper stop": start("pivot", "at_deg = 31.5"),
    "start beyond a lower stop": start("pivot", "at_deg = -22.25"),
    "start beyond the end of a slide": start("rail", "at_mm = -4.5"),
    "start of a slide in degrees": start("rail", "at_deg = 1.0"),
    "rate of a hinge in mm": start("pivot", "rate_mm_per_s = 0.0"),
    "start of a driven joint": 'drives.d = { joint = "axle", law = "constant_speed", ratio = '
        "1.0 }\ninitial.axle = { at_deg = 3.0 }",
    "place of a stop in mm": stop('joint = "axle", at_mm = 1.0'),
    "place of a stop in degrees": stop('joint = "rail", at_deg = 1.0, side = "upper"'),
    "two lower stops": stop('joint = "rail", at_mm = 3.0'),
    "no room between stops": stop('joint = "rail", at_mm = -4.0, side = "upper"'),
    "place of a stop that is none": stop('joint = "rail", at_mm = nan'),
    "side of a stop": stop('joint = "rail", side = "left"'),
    "upper stop below the lower one": stop('joint = "rail", at_mm = -5.0, side = "upper"'),
    "both stops of a joint closed": ("closed = []", 'closed = ["low", "high"]'),
    "restitution": 'stops.x = { joint = "axle", restitution = 1.01 }',
    "freedoms": ("degrees_of_freedom = 3", "degrees_of_freedom = 1"),
    "no freedom": ("degrees_of_freedom = 3", "degrees_of_freedom = 0"),
    "slot without a block": tie(', slot_axis = "x"'),
    "block without a slot": tie(", block_mass_kg = 1.0"),
    "slot called as a joint": 'closures.pivot = { frame_a = "a", frame_b = "b"' + SLOT + " }",
    "block called as a link": ('<link name="c"/>', '<link name="tie_block"/>', 'child link="c"',
        'child link="tie_block"', "gravity_m_s2",
        'closures.tie = { frame_a = "a", frame_b = "b"' + SLOT + " }\ngravity_m_s2"),
    "freedoms with a closure": (*tie(""), *MEET),
    "freedoms with a slot": (*tie(SLOT), "0.103 0 0.004", "0.103 0 0.0"),
    "no title": ('"a lever, a wheel and a sled"', '""'),
    "no phases": ('[{ number = 1, name = "free", closed = [] }]', "[]"),
    "gravity upwards": ("= 9.81", "= -0.1"),
    "name that no message can show": '"a\\nb" = 1',
    "name of a table that none can": 'dampers."x\\t" = {}',
    "name in a list that none can": ("closed = [] }", 'closed = [], deep = { "\\b" = 1 } }'),
    "deep TOML": "x = " + "[" * 10**5 + "]" * 10**5,
    "long number": ("degrees_of_freedom = 3", f"degrees_of_freedom = {'9' * 5000}"),
    "escape in a title": ('"a lever, ', '"\\u001b[2J'),
    "control character of eight bits": ('"a lever, ', '"\\u009b2J'),
    "text that is turned round": ('"a lever, ', '"\\u202etxt'),
    "formula as a key": 'stops."=1+1" = { joint = "axle", restitution = 0.0 }',
}  # fmt: skip

HEAD, LINES = b"coordinate_mm,force_N\n", b"0.0,90.0\n2.0,100.0\n5.0,130.0\n"


def file(content: bytes, more: str = "") -> Row:
    text = f'springs.coil = {{ joint = "rail", file = "coil.csv"{more} }}'
    return Row(text, {"coil.csv": content})


SWINGS = (
    b"cylinder_angle_deg,coordinate_rad\n0,0\n45,1\n90,2\n135,1\n180,0\n225,-1\n270,-2\n360,0\n"
)


def swings(old: bytes = b"", new: bytes = b"", name: str = "x") -> Row:
    text = f'drives.x = {{ joint = "axle", law = "table", file = "{name}.csv" }}'
    return Row(text, {"x.csv": SWINGS.replace(old, new)})


# Rows of springs and drives in a file of their own.
FILES = {
    "column": file(b"coordinate_mm,force\n" + LINES),
    "number": file(HEAD + LINES.replace(b"100.0", b"soft")),
    **{f"number {text}": file(HEAD + LINES.replace(b"100.0", text.encode()))
       for text in ("1_0", "\u0663", "\uff11")},
    "no number": file(HEAD + LINES.replace(b"100.0", b"")),
    "order": file(HEAD + LINES.replace(b"5.0", b"1.0")),
    "one row": file(HEAD + b"0.0,90.0\n"),
    "the other kind": file(b"coordinate_deg,torque_N_m\n" + LINES),
    "file and columns": file(HEAD + LINES, ", force_N = [1.0]"),
    "file and stiffness": file(HEAD + LINES, ", stiffness_N_per_m = 1.0"),
    "bytes": file(HEAD + b"\xff\xfe,1\n"),
    "angles": swings(b"\n135", b"\n35"),
    "swing": swings(b"135,1", b"135,nan"),
    "swing left out": swings(b"135,1", b"135,"),
    "less than a turn": swings(b"360", b"359.5"),
    "ends": swings(b"360,0", b"360,0.5"),
    "columns of a drive": swings(b"coordinate_rad", b"value"),
    "above the folder": swings(name="../x"),
    "anywhere": swings(name="/tmp/x"),
    "missing": swings(name="y"),
    "no text": Row("", {"small.toml": b"\xff\xfe"}),
    "long field": file(HEAD + b"1" * 200_000 + b",1\n"),
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
    "slot": (*tie(SLOT, 2), "0.103 0 0.004", "0.103 0 0.0"),
}  # fmt: skip
