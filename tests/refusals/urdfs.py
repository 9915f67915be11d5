"""Mistakes in the URDF of a model, and hostile models: edit, place and value."""

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
LINK, EYE = "link top_nipper", "link rocker_foot"
SHAPE = "link bottom_nipper collision bottom_lip"
CLASH = "link bottom_nipper collision name"
LIMIT = ' lower="-3.2" upper="3.2"'
ENDS = '<parent link="bottom_nipper"/>\n    <child link="top_nipper"/>'
FIXED = '<child link="rocker_foot"/>'
FRAME = '<link name="frame">'
PICTURE = '<visual name="frame_wall">\n      <origin xyz="0 0 0"'


def mass(text: str, value: object) -> Row:
    return Row((MASS, text), f"{LINK} mass", value)


def axis(text: str, value: object) -> Row:
    return Row((JAW, JAW.replace("0 -1 0", text)), "joint jaw axis", value)


def mesh(name: str) -> Row:
    return Row((LIP, f'<mesh filename="{name}"/>'), f"{SHAPE} mesh", name)


def limit(side: str, old: str, new: str) -> Row:
    return Row((JAW + "\n    <limit" + LIMIT, JAW + "\n    <limit" + LIMIT.replace(old, new)),
               f"joint jaw limit {side}", new.strip('"'))  # fmt: skip


def frame(mass: str, about: int) -> str:
    """The foot of the rocker with a mass and a number for all its inertias."""
    turning = "".join(f' i{axes}="{about}"' for axes in ("xx", "yy", "zz"))
    return f'<link name="rocker_foot"><inertial>{mass}<inertia{turning}/></inertial></link>'


# Of the E62: numbers that are none (as XML has them), bodies, axes, the tree and shapes.
URDFS = {
    "mass zero": mass('<mass value="0"/>', 0.0),
    "mass negative": mass('<mass value="-2"/>', -2.0),
    "mass missing": mass("", None),
    **{f"mass {text}": mass(f'<mass value="{text}"/>', text)
       for text in ("x", "inf", "1_2", "\uff11.2", "\u0661", "0x1p3", "1e", "1.2.3")},
    "inertia negative": Row((INERTIA, 'iyy="-1"'), f"{LINK} inertia", ...),
    "inertia of no body": Row((INERTIA, 'iyy="0.01"'), f"{LINK} inertia", ...),
    "hinge out of plane": axis("0 -1 0.1", [0.0, -1.0, 0.1]),
    "hinge a little out of plane": axis("0 -1 1e-2", [0.0, -1.0, 0.01]),
    "no direction": axis("0 0 0", [0.0, 0.0, 0.0]),
    "no axis": Row((JAW, JAW.partition("\n")[0]), "joint jaw axis", "none, which means 1 0 0"),
    "slide out of plane": Row((SLIDE, "0.38 0.1 -0.92"), "joint steeve axis", [0.38, 0.1, -0.92]),
    "slide without direction": Row((SLIDE, "0 0 0"), "joint steeve axis", [0.0, 0.0, 0.0]),
    "placement out of plane": Row((JAW, JAW.replace("0 0 0", "0.1 0 0")),
                                  "joint jaw axis", [0.0, -1.0, 0.0]),
    "joint floating": Row((TYPE, 'name="jaw" type="floating"'), "joint jaw type", "floating"),
    "joint planar": Row((TYPE, 'name="jaw" type="planar"'), "joint jaw type", "planar"),
    "mimic": Row((JAW, JAW + '<mimic joint="steeve" offset="1"/>'), "joint jaw mimic offset", 1.0),
    "two parents": Row(('<child link="top_nipper"/>', '<child link="rocker"/>'),
                       "joint jaw child", "rocker"),
    "several roots": Row((FOOT, FOOT + '<link name="loose"/>'), "root links", ["frame", "loose"]),
    "circle": Row(('<parent link="frame"/>\n    <child link="pendulum_arm"/>',
                   '<parent link="top_nipper"/>\n    <child link="pendulum_arm"/>'), "links", ...),
    "same link twice": Row((FOOT, FOOT + FRAME[:-1] + "/>"), "<link> name", "frame"),
    "link without name": Row((FOOT, "<link/>"), "<link> name", None),
    "size": Row((LIP, '<box size="1 2 0"/>'), f"{SHAPE} size", [1.0, 2.0, 0.0]),
    "sizes missing": Row((LIP, '<box size="1 2"/>'), f"{SHAPE} size", "1 2"),
    "geometry": Row((LIP, "<torus/>"), SHAPE, ["torus"]),
    **{f"mesh {name}": mesh(name) for name in (
        "../lip.stl", "/tmp/lip.stl", "package://a/lip.stl", "package://a/../lip.stl", "lip.stl",
        "a/../../lip.stl", "C:lip.stl", "a\\lip.stl", "", "package://only")},
    "picture above the folder": Row(('"meshes/rockers.stl"', '"../a.stl"'), ..., "../a.stl"),
    "same shape twice": Row((PLATE, '<collision name="bottom_lip">'), CLASH, "bottom_lip"),
    "shape called as a link": Row((PLATE, '<collision name="frame">'), CLASH, "frame"),
    "lower limit nan": limit("lower", "-3.2", "nan"),
    "lower limit inf": limit("lower", "-3.2", "inf"),
    "upper limit -inf": limit("upper", '"3.2"', '"-inf"'),
    **{f"upper limit {text!r}": limit("upper", '"3.2"', f'"{text}"')
       for text in ("0.2m", "true", "1,5", "", " ", "0x1", "1_0", "3 deg", "\u03c0")},
    "axis of what is fixed": Row((FIXED, f'{FIXED}<axis xyz="0 one 0"/>'), ..., "0 one 0"),
    "mass of what stands": Row(
        (FRAME, f'{FRAME}<inertial><mass value="heavy"/></inertial>'), "link frame mass", "heavy"),
    "origin of a picture": Row((PICTURE, PICTURE.replace("0 0 0", "0 zero 0")),
                               "link frame visual frame_wall origin xyz", "0 zero 0"),
    "no inertial": Row(('<link name="rocker_foot"/>', '<link name="rocker_foot"/><link name="x"/>'
                        '<joint name="y" type="prismatic"><parent link="rocker"/><child link="x"/>'
                        '<axis xyz="1 0 0"/><limit/></joint>'), "link x inertial", None),
    "no XML": Row(("</robot>", "</robot"), "XML", ...),
    "no robot": Row(("<robot", "<machine", "</robot>", "</machine>"), "root element", ...),
    **{f"colour {text}": Row(('rgba="0.62 0.65 0.70 1"', f'rgba="{text}"'), ..., ...)
       for text in ("1 x 0 1", "red")},
    **{f"scale {text!r} of a picture": Row(
        ('"meshes/rockers.stl"', f'"meshes/rockers.stl" scale="{text}"'), ..., text)
       for text in ("", "0.001")},
    **{f"{text} of a joint": Row(
        (JAW, f"{JAW}<dynamics {text}/>"), f"joint jaw dynamics {key}", found)
       for text, key, found in (
           ('damping="0.1" friction="0.2"', "friction", 0.2), ('friction="-1"', "friction", -1.0),
           ('friction="nan"', "friction", "nan"), ('damping="-0.1"', "damping", -0.1),
           ('damping="much"', "damping", "much"))},
    "macro": Row(("<robot", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"',
                  FOOT, FOOT + '<xacro:finger prefix="l"/>'), "xacro", "<xacro:finger>"),
    "undeclared macro": Row((FOOT, FOOT + "<xacro:finger/>"), "xacro", "<xacro:"),
    "expression": Row((FOOT, FOOT.replace("rocker_foot", "${side}_foot")), "xacro", "${side}_foot"),
    "name that no message can show": Row(
        ('link name="cylinder_axis"', 'link name="a&#10;b"'), ..., ...),
    **{f"place of {text}": Row(
        (JAW, JAW.replace("0.1226", text)), "joint jaw origin xyz", ...)
       for text in ("1.1e15", "-1.1e15", "1e308")},
    "lips that opening drives together": Row(
        ("0.082409829417841 0 -0.03502955916540127", "0.0815 0 -0.0384"),
        "stops.jaw.contact", ...),
    "mass of a frame": Row((FOOT, frame('<mass value="-1e-9"/>', 0)), f"{EYE} mass", -1e-9),
    "frame that turns without mass": Row((FOOT, frame('<mass value="0"/>', 1)), f"{EYE} mass", 0.0),
}  # fmt: skip
URDF_NAMES = {
    "parent": Row((ENDS, ENDS.replace("bottom_nipper", "nipper")), "link", "nipper"),
    "child": Row((ENDS, ENDS.replace("top_nipper", "nipper")), "link", "nipper"),
}

BODY = '<mass value="1.0"/><inertia ixx="1.0" iyy="1.0" izz="1.0" ixy="0" ixz="0" iyz="0"/>'
ROOT = '<link name="frame"/>'
LEVER = '<link name="lever"><inertial>'
BOX = "<geometry><box size='1 1 1'/></geometry></collision>"


def shapes(first: str, second: str, place: str, value: str) -> Row:
    """Two shapes on the lever."""
    names = "".join(f"<collision name='{name}'>{BOX}" for name in (first, second))
    return Row((LEVER, LEVER.replace("<inertial>", names + "<inertial>")), place, value)


def whole(text: str, place: object, value: object) -> Row:
    """The URDF as a whole, in letters of one byte each."""
    return Row("", place, value, {"small.urdf": text.encode("latin-1")})


# What is no mistake.
TAKEN = {
    "only shape called as its link": (
        LEVER, LEVER.replace("<inertial>", f"<collision name='lever'>{BOX}<inertial>")),
}  # fmt: skip

# Of the small machine.
SMALL_URDFS = {
    "mass without an inertia": Row((BODY, '<mass value="1.0"/>'), "link lever inertia", None),
    "inertia without a mass": Row((BODY, BODY.partition("/>")[2]), "link lever mass", None),
    "inertia of a half": Row((BODY, BODY.replace('iyy="1.0"', 'iyy="2.1"')),
                             "link lever inertia", [1.0, 1.0, 2.1]),
    "shapes of one name": shapes("x", "x", "link lever collision name", "x"),
    "shape called as its link": shapes("lever", "x", "link lever collision name", "lever"),
    "shape called as another link": shapes("x", "sled", "link lever collision name", "sled"),
    "package that cannot be read": Row(
        ("</inertial></link>", "</inertial><collision name='x'><geometry><mesh "
         "filename='package://mine/x.stl'/></geometry></collision></link>"),
        "link lever collision x mesh", "package://mine/x.stl",
        {"package.xml": b"<p>", "x.stl": b""}),
    "two links of one root": Row((ROOT, ROOT + '<link name="x"/><link name="y"/>'),
                                 "root links", ["frame", "x", "y"]),
    "nothing that resists": Row((BODY, '<mass value="1"/><inertia ixx="0" iyy="0" izz="0"/>'),
                                "link lever inertia", 0.0),
    "hinge across the others": Row(('<axis xyz="0 -1 0"/>', '<axis xyz="1 0 0"/>'),
                                   "joint pivot axis", [1.0, 0.0, 0.0]),
    "nothing that moves": whole('<robot name="u"><link name="base"/></robot>',
                                "joints that move", 0),
    **{f"letters of another encoding than {name}": whole(
        f'<?xml version="1.0" encoding="{name}"?><robot name="gr\u00f6\u00dfer"/>', ..., ...)
       for name in ("utf-8", "us-ascii", "klingon", "hex", "utf-16")},
}  # fmt: skip


def chain(count: int = 10_000) -> str:
    """Links that hang from one another by fixed joints."""
    return "".join(
        f'<link name="c{k}"/><joint name="j{k}" type="fixed">'
        f'<parent link="{f"c{k - 1}" if k else "rocker"}"/><child link="c{k}"/></joint>'
        for k in range(count)
    )


def entity(named: str, what: str) -> Row:
    """A document type with entities, one of which is a mass."""
    head = '<?xml version="1.0"?>'
    return Row(
        (head, f"{head}<!DOCTYPE robot [{what}]>", MASS, f'<mass value="&{named};"/>'), ..., ...
    )


def shape(content: bytes) -> Row:
    return Row((LIP, '<mesh filename="bad.stl"/>'), ..., ..., {"bad.stl": content})


# What once ended in a traceback, a crash or a wait without end.
HOSTILE = {
    "deep XML": Row(("</robot>", "<a>" * 10**5 + "</a>" * 10**5 + "</robot>"), ..., ...),
    "chain of links": Row(("</robot>", chain() + "</robot>"), ..., ...),
    "entity of a file": entity("x", '<!ENTITY x SYSTEM "file:///etc/hostname">'),
    "entities that explode": entity("a11", '<!ENTITY a0 "aaaaaaaaaa">' + "".join(
        f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 12))),
    "formula as a name": Row((TYPE, TYPE.replace("jaw", "=jaw")), ..., "=jaw"),
    **{f"scale {text} of a shape": Row(
        (LIP, f'<mesh filename="meshes/rockers.stl" scale="{text}"/>'), ..., ...)
       for text in ("nan 1 1", "1e30 1 1", "1 1", "x")},
    "mesh cut off": shape(b"solid x\nfacet normal nan"),
    "mesh of no length": shape(b"\0" * 80 + b"\xff\xff\xff\x7f" + b"\0" * 10),
    "mesh of no numbers": shape(b"solid x\nfacet normal 0 0 1\nouter loop\nvertex nan 0 0\n"
                                b"vertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"),
}  # fmt: skip
