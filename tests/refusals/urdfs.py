"""Mistakes in the URDF of a model, and hostile models; snapshots say what is said of each."""

from __future__ import annotations

from tests.refusals.bases import Row

MASS = '<mass value="1.2"/>'
JAW = '<origin xyz="0.1226 0 0.0561" rpy="0 0 0"/>\n    <axis xyz="0 -1 0"/>'
SLIDE = "0.3835683289474219 0 -0.9235124996601196"
LIP = '<box size="0.012 0.2 0.0003"/>'
INERTIA = 'iyy="0.001142"'
TYPE = 'name="jaw" type="revolute"'
FOOT = '<link name="rocker_foot"/>'
PLATE = '<collision name="bottom_plate">'
LIMIT = ' lower="-3.2" upper="3.2"'
ENDS = '<parent link="bottom_nipper"/>\n    <child link="top_nipper"/>'
FIXED = '<child link="rocker_foot"/>'
FRAME = '<link name="frame">'
PICTURE = '<visual name="frame_wall">\n      <origin xyz="0 0 0"'


def limit(old: str, new: str) -> tuple[str, str]:
    return JAW + "\n    <limit" + LIMIT, JAW + "\n    <limit" + LIMIT.replace(old, new)


def frame(mass: str, about: int) -> str:
    """The foot of the rocker with a mass and a number for all its inertias."""
    turning = "".join(f' i{axes}="{about}"' for axes in ("xx", "yy", "zz"))
    return f'<link name="rocker_foot"><inertial>{mass}<inertia{turning}/></inertial></link>'


# Of the E62: numbers that are none (as XML has them), bodies, axes, the tree and shapes.
URDFS = {
    "mass zero": (MASS, '<mass value="0"/>'),
    "mass negative": (MASS, '<mass value="-2"/>'),
    "mass missing": (MASS, ""),
    **{f"mass {text}": (MASS, f'<mass value="{text}"/>') for text in (
        "x", "inf", "1_2", "\uff11.2", "\u0661", "0x1p3", "1e", "1.2.3")},
    "inertia negative": (INERTIA, 'iyy="-1"'),
    "inertia of no body": (INERTIA, 'iyy="0.01"'),
    "hinge out of plane": (JAW, JAW.replace("0 -1 0", "0 -1 0.1")),
    "hinge a little out of plane": (JAW, JAW.replace("0 -1 0", "0 -1 1e-2")),
    "no direction": (JAW, JAW.replace("0 -1 0", "0 0 0")),
    "no axis": (JAW, JAW.partition("\n")[0]),
    "slide out of plane": (SLIDE, "0.38 0.1 -0.92"),
    "slide without direction": (SLIDE, "0 0 0"),
    "placement out of plane": (JAW, JAW.replace("0 0 0", "0.1 0 0")),
    "joint floating": (TYPE, 'name="jaw" type="floating"'),
    "joint planar": (TYPE, 'name="jaw" type="planar"'),
    "mimic": (JAW, JAW + '<mimic joint="steeve" offset="1"/>'),
    "two parents": ('<child link="top_nipper"/>', '<child link="rocker"/>'),
    "several roots": (FOOT, FOOT + '<link name="loose"/>'),
    "circle": ('<parent link="frame"/>\n    <child link="pendulum_arm"/>',
        '<parent link="top_nipper"/>\n    <child link="pendulum_arm"/>'),
    "same link twice": (FOOT, FOOT + FRAME[:-1] + "/>"),
    "link without name": (FOOT, "<link/>"),
    "size": (LIP, '<box size="1 2 0"/>'),
    "sizes missing": (LIP, '<box size="1 2"/>'),
    "geometry": (LIP, "<torus/>"),
    **{f"mesh {name}": (LIP, f'<mesh filename="{name}"/>') for name in (
        "../lip.stl", "/tmp/lip.stl", "package://a/lip.stl", "package://a/../lip.stl", "lip.stl",
        "a/../../lip.stl", "C:lip.stl", "a\\lip.stl", "", "package://only")},
    "picture above the folder": ('"meshes/rockers.stl"', '"../a.stl"'),
    "same shape twice": (PLATE, '<collision name="bottom_lip">'),
    "shape called as a link": (PLATE, '<collision name="frame">'),
    "lower limit nan": limit("-3.2", "nan"),
    "lower limit inf": limit("-3.2", "inf"),
    "upper limit -inf": limit('"3.2"', '"-inf"'),
    **{f"upper limit {text!r}": limit('"3.2"', f'"{text}"') for text in (
        "0.2m", "true", "1,5", "", " ", "0x1", "1_0", "3 deg", "\u03c0")},
    "axis of what is fixed": (FIXED, f'{FIXED}<axis xyz="0 one 0"/>'),
    "mass of what stands": (FRAME, f'{FRAME}<inertial><mass value="heavy"/></inertial>'),
    "origin of a picture": (PICTURE, PICTURE.replace("0 0 0", "0 zero 0")),
    "no inertial": ('<link name="rocker_foot"/>', '<link name="rocker_foot"/><link name="x"/>'
        '<joint name="y" type="prismatic"><parent link="rocker"/><child link="x"/>'
        '<axis xyz="1 0 0"/><limit/></joint>'),
    "no XML": ("</robot>", "</robot"),
    "no robot": ("<robot", "<machine", "</robot>", "</machine>"),
    **{f"colour {text}": ('rgba="0.62 0.65 0.70 1"', f'rgba="{text}"')
       for text in ("1 x 0 1", "red")},
    **{f"scale {text!r} of a picture": ('"meshes/rockers.stl"',
        f'"meshes/rockers.stl" scale="{text}"') for text in ("", "0.001")},
    **{f"{text} of a joint": (JAW, f"{JAW}<dynamics {text}/>") for text in (
        'damping="0.1" friction="0.2"', 'friction="-1"', 'friction="nan"', 'damping="-0.1"',
        'damping="much"')},
    "macro": ("<robot", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"', FOOT,
        FOOT + '<xacro:finger prefix="l"/>'),
    "undeclared macro": (FOOT, FOOT + "<xacro:finger/>"),
    "expression": (FOOT, FOOT.replace("rocker_foot", "${side}_foot")),
    "name that no message can show": ('link name="cylinder_axis"', 'link name="a&#10;b"'),
    **{f"place of {text}": (JAW, JAW.replace("0.1226", text))
       for text in ("1.1e15", "-1.1e15", "1e308")},
    "lips that opening drives together": ("0.082409829417841 0 -0.03502955916540127",
        "0.0815 0 -0.0384"),
    "mass of a frame": (FOOT, frame('<mass value="-1e-9"/>', 0)),
    "frame that turns without mass": (FOOT, frame('<mass value="0"/>', 1)),
}  # fmt: skip
URDF_NAMES = {
    "parent": (ENDS, ENDS.replace("bottom_nipper", "nipper")),
    "child": (ENDS, ENDS.replace("top_nipper", "nipper")),
}  # fmt: skip

BODY = '<mass value="1.0"/><inertia ixx="1.0" iyy="1.0" izz="1.0" ixy="0" ixz="0" iyz="0"/>'
ROOT = '<link name="frame"/>'
LEVER = '<link name="lever"><inertial>'
BOX = "<geometry><box size='1 1 1'/></geometry></collision>"


def shapes(first: str, second: str) -> tuple[str, str]:
    """Two shapes on the lever."""
    names = "".join(f"<collision name='{name}'>{BOX}" for name in (first, second))
    return LEVER, LEVER.replace("<inertial>", names + "<inertial>")


def whole(text: str) -> Row:
    """The URDF as a whole, in letters of one byte each."""
    return Row("", {"small.urdf": text.encode("latin-1")})


# What is no mistake.
TAKEN = {
    "only shape called as its link": (
        LEVER, LEVER.replace("<inertial>", f"<collision name='lever'>{BOX}<inertial>")),
}  # fmt: skip

# Of the small machine.
SMALL_URDFS = {
    "mass without an inertia": (BODY, '<mass value="1.0"/>'),
    "inertia without a mass": (BODY, BODY.partition("/>")[2]),
    "inertia of a half": (BODY, BODY.replace('iyy="1.0"', 'iyy="2.1"')),
    "shapes of one name": shapes("x", "x"),
    "shape called as its link": shapes("lever", "x"),
    "shape called as another link": shapes("x", "sled"),
    "package that cannot be read": Row(("</inertial></link>",
        "</inertial><collision name='x'><geometry><mesh "
        "filename='package://mine/x.stl'/></geometry></collision></link>"), {"package.xml": b"<p>",
        "x.stl": b""}),
    "two links of one root": (ROOT, ROOT + '<link name="x"/><link name="y"/>'),
    "nothing that resists": (BODY, '<mass value="1"/><inertia ixx="0" iyy="0" izz="0"/>'),
    "same joint twice": ('joint name="axle"', 'joint name="pivot"'),
    "hinge across the others": ('<axis xyz="0 -1 0"/>', '<axis xyz="1 0 0"/>'),
    "nothing that moves": whole('<robot name="u"><link name="base"/></robot>'),
    **{f"letters of another encoding than {name}": whole(
        f'<?xml version="1.0" encoding="{name}"?><robot name="gr\u00f6\u00dfer"/>') for name in (
        "utf-8", "us-ascii", "klingon", "hex", "utf-16")},
}  # fmt: skip


def chain(count: int = 10_000) -> str:
    """Links that hang from one another by fixed joints."""
    return "".join(
        f'<link name="c{k}"/><joint name="j{k}" type="fixed">'
        f'<parent link="{f"c{k - 1}" if k else "rocker"}"/><child link="c{k}"/></joint>'
        for k in range(count)
    )


def entity(named: str, what: str) -> tuple[str, ...]:
    """A document type with entities, one of which is a mass."""
    head = '<?xml version="1.0"?>'
    return head, f"{head}<!DOCTYPE robot [{what}]>", MASS, f'<mass value="&{named};"/>'


def shape(content: bytes) -> Row:
    return Row((LIP, '<mesh filename="bad.stl"/>'), {"bad.stl": content})


# What once ended in a traceback, a crash or a wait without end.
HOSTILE = {
    "deep XML": ("</robot>", "<a>" * 10**5 + "</a>" * 10**5 + "</robot>"),
    "chain of links": ("</robot>", chain() + "</robot>"),
    "entity of a file": entity("x", '<!ENTITY x SYSTEM "file:///etc/hostname">'),
    "entities that explode": entity("a11", '<!ENTITY a0 "aaaaaaaaaa">' + "".join(
        f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 12))),
    "formula as a name": (TYPE, TYPE.replace("jaw", "=jaw")),
    **{f"scale {text} of a shape": (LIP, f'<mesh filename="meshes/rockers.stl" scale="{text}"/>')
        for text in ("nan 1 1", "1e30 1 1", "1 1", "x")},
    "mesh cut off": shape(b"solid x\nfacet normal nan"),
    "mesh of no length": shape(b"\0" * 80 + b"\xff\xff\xff\x7f" + b"\0" * 10),
    "mesh of no numbers": shape(b"solid x\nfacet normal 0 0 1\nouter loop\nvertex nan 0 0\n"
        b"vertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"),
}  # fmt: skip
