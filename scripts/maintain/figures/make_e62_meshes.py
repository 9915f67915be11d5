"""Make the solids that combers of the E62's layout are drawn with, from the model's dimensions.

The shapes are illustrations around estimated points and collision shapes, not the maker's parts.
The engine never sees them. The script writes one binary STL a solid into ``meshes`` of the model's
folder and the ``<visual>`` elements of the URDF, whose materials it expects there; it changes
nothing else.

Run: python scripts/maintain/figures/make_e62_meshes.py [MODEL FOLDER ...]
     without folders: those of the models e62 and e62_offset_guide
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from e62_shapes import Model, Pair, bar, both, coil, disc, plate, solid, tube
from shapely import Point, Polygon, box
from shapely.affinity import rotate, translate
from shapely.ops import unary_union

OWN = ("e62", "e62_offset_guide")
FRONT, WALL, WALL_BACK = -0.130, 0.150, 0.158  # ends of the shafts, wall behind the mechanism
BOSS = 0.166
SHAFT, PLAY = 0.0095, 0.0001  # radius of the cylinder shaft; clearance of a pin in its hole
RIM = 0.001  # least thickness of an eccentric around its shaft


@dataclass(frozen=True)
class Part:
    """One drawn solid of a link.

    Attributes:
        link: Link that it belongs to.
        name: Name of the visual, and of the file unless several visuals share one.
        material: Material of the URDF.
        mesh: The solid in the link's frame [m]; None if the file comes with another visual.
        file: File name without suffix.
        origin: Attributes of the origin element.
        scale: Scale attribute of the mesh, or None.
    """

    link: str
    name: str
    material: str
    mesh: trimesh.Trimesh | None
    file: str = ""
    origin: str = ""
    scale: str | None = None


def frame(model: Model) -> list[Part]:
    """Wall, base and rollers; the cylinder, which turns, stands at its angle of touch."""
    shaft, tension = model.joint["pendulum_shaft"], model.joint["tension_shaft"]
    lower, upper = (model.at(f"detaching_roller_{side}") for side in ("lower", "upper"))
    middle, floor = (0.0, 0.0), -0.127
    # Bearings of the three shafts: boss and bore.
    bearings = (
        (shaft, 0.024, model.radius("pendulum_shaft")),
        (middle, 0.020, SHAFT),
        (tension, 0.020, tension_radius(model)),
    )
    webs = ((shaft, middle), (shaft, tension), (tension, middle),
            (shaft, (shaft[0], floor)), (middle, (0.02, floor)))  # fmt: skip
    bosses = unary_union([disc(place, radius) for place, radius, _ in bearings])
    bores = unary_union([disc(place, bore + PLAY) for place, _, bore in bearings])
    wall = unary_union([bosses, *(bar(disc(a, 0.012), disc(b, 0.012)) for a, b in webs)])
    # The guide bar sweeps through where journals of the rollers would run to the wall, so that the
    # rollers have stands of their own, outside the circle of the crank.
    foot = (0.095, 0.03)
    stand = unary_union([
        bar(disc(lower, 0.016), disc(upper, 0.016), disc(foot, 0.010)),
        bar(disc(foot, 0.010), disc((foot[0], floor), 0.010)),
    ])  # fmt: skip
    journals = unary_union([disc(lower, 0.006), disc(upper, 0.006)])
    # An open base: where a processor draws, a closed one was a third of a picture.
    left, right, depth = shaft[0] - 0.04, 0.11, floor - 0.008
    base = box(left, depth, right, floor)
    ends = unary_union(
        [box(left, depth, left + 0.03, floor), box(right - 0.03, depth, right, floor)]
    )
    stands = both((0.122, 0.131))
    parts = [
        Part("frame", "frame_wall", "steel", solid(
            plate(wall.difference(bores), (WALL, WALL_BACK)),
            plate(bosses.difference(bores), (WALL, BOSS)),
            plate(stand.difference(journals.buffer(PLAY)), *stands),
            plate(base, (FRONT - 0.01, FRONT + 0.02), (WALL, BOSS)),
            plate(ends, (FRONT - 0.01, BOSS)),
        ))
    ]  # fmt: skip
    for side, material, flutes in (("lower", "steel", 36), ("upper", "rubber", 0)):
        name = f"detaching_roller_{side}"
        outline = model.disc(name)
        for k in range(flutes):
            turn = math.tau * k / flutes
            x, z = (c + model.radius(name) * f(turn)
                    for c, f in zip(model.at(name), (math.cos, math.sin), strict=True))  # fmt: skip
            outline = outline.difference(Point(x, z).buffer(0.0006, quad_segs=2))
        low, high = model.width(name)
        journal = plate(disc(model.at(name), 0.006), (-0.133, 0.133))
        parts.append(Part("frame", name, material, solid(plate(outline, (low, high)), journal)))
    return parts + cylinder(model)


def cylinder(model: Model) -> list[Part]:
    """Crankshaft, drum and comb segment, at the cylinder angle of the touch configuration."""
    drive = model.toml["drives"]["pendulum"]
    touch = math.radians(model.toml["cylinder"]["angle_at_touch_deg"])
    radius = 1e-3 * drive["crank_radius_mm"]
    pin = (radius * math.cos(touch), radius * math.sin(touch))
    low, high = model.width("guide_bar")
    inner, outer = (low - 0.0075, low - 0.0015), (high + 0.0015, high + 0.0065)
    web = bar(disc((0.0, 0.0), 0.016), disc(pin, 0.011))
    shaft = disc((0.0, 0.0), SHAFT)
    crank = solid(
        plate(shaft, (FRONT, inner[0]), (outer[1], BOSS + 0.002)),
        plate(web, inner, outer),
        plate(disc(pin, 0.005), (inner[0], outer[1])),
    )
    rim = model.radius("cylinder_drum")
    holes = [disc((0.032 * math.cos(a), 0.032 * math.sin(a)), 0.011)
             for a in np.linspace(0.0, math.tau, 6)[:-1]]  # fmt: skip
    face = disc((0.0, 0.0), rim - 0.0105).difference(unary_union([shaft, *holes]))
    side = model.width("cylinder_drum")[1] - 0.001
    # The needles pass under the lips while the nipper is at its rear end, where the guide bar
    # touches the circle of the crank pin: the first of two such places after the jaw has closed.
    axis = np.subtract(drive["guide_axis_mm"], drive["crank_axis_mm"])
    offset, away = drive.get("guide_offset_mm", 0.0), math.hypot(*axis)
    rear = [
        math.atan2(axis[1], axis[0])
        + sign * math.acos((drive["crank_radius_mm"] + sign * offset) / away)
        for sign in (1.0, -1.0)
    ]
    centre = 0.5 * math.pi + min((touch - psi) % math.tau for psi in rear)
    half, rows = math.radians(50.0), 17
    sector = Polygon([(0.0, 0.0), *((0.1 * math.cos(centre + a), 0.1 * math.sin(centre + a))
                                    for a in np.linspace(-half, half, 9))])  # fmt: skip
    comb = disc((0.0, 0.0), rim - 0.0045).difference(disc((0.0, 0.0), rim - 0.012))
    comb = comb.intersection(sector)
    teeth = []
    for a in np.linspace(-half + 0.05, half - 0.05, rows):
        # Needles lean forward, in the sense in which the cylinder turns.
        corners = [(rim - 0.006, 0.028), (rim - 0.0001, -0.018), (rim - 0.006, -0.012)]
        teeth.append(Polygon([(r * math.cos(centre + a + b), r * math.sin(centre + a + b))
                              for r, b in corners]))  # fmt: skip
    return [
        Part("frame", "cylinder_shaft", "dark_steel", crank),
        Part("frame", "cylinder_drum", "drum_brass", solid(plate(face, (-side, side)))),
        Part("frame", "cylinder_comb", "steel",
             solid(plate(unary_union([comb, *teeth]), (-side, side)))),
    ]  # fmt: skip


def pendulum_arm(model: Model) -> list[Part]:
    """Arms on the pendulum shaft, and the slotted guide bar in which the crank pin slides."""
    pivot, width = model.joint["nipper_pivot"], both(model.width("pendulum_arm_left"))
    arms = bar(disc((0.0, 0.0), 0.021), disc(pivot, 0.0125))
    # Pins stand where the joints are, which their collision shapes may miss a little.
    radius = model.radius("nipper_pivot_pin")
    hole = disc(pivot, radius + PLAY)
    low, high = model.width("guide_bar")
    reach = model.radius("pendulum_shaft")
    slot = bar(*(disc(model.axis("guide_bar", x, 0.0), 0.0052) for x in (-0.010, 0.1275)))
    guide = bar(*(disc(model.axis("guide_bar", x, 0.0), 0.010) for x in (-0.125, 0.1275)))
    guide = unary_union([guide, disc((0.0, 0.0), reach + 0.008)]).difference(slot)
    shaft = disc((0.0, 0.0), reach)
    return [
        Part("pendulum_arm", "pendulum_arms", "steel",
             solid(plate(arms.difference(hole).difference(shaft), *width))),
        Part("pendulum_arm", "guide_bar", "dark_steel", solid(
            plate(shaft, (model.width("pendulum_shaft")[0], BOSS + 0.002)),
            plate(guide, (low, high)),
            plate(disc(pivot, radius), model.width("nipper_pivot_pin")),
        )),
    ]  # fmt: skip


def bottom_nipper(model: Model) -> list[Part]:
    """Two arms, the stiffened cushion plate with its lip, studs, and the shaft of the jaw."""
    jaw, rocker = model.joint["jaw"], model.joint["rocker_pin"]
    arms = bar(disc((0.0, 0.0), 0.0135), disc(jaw, 0.0115))
    arms = arms.difference(disc((0.0, 0.0), model.radius("nipper_pivot_pin") + PLAY))
    bracket = bar(disc(rocker, 0.0095), model.outline("bottom_stiffener").intersection(
        disc(jaw, 0.045)), disc(jaw, 0.006))  # fmt: skip
    widths = both(model.width("bottom_arm_left"))
    low, high = model.width("bottom_plate")
    plates = unary_union([model.outline("bottom_plate"), model.outline("bottom_lip")])
    shaft = disc(jaw, 0.004)
    return [
        Part("bottom_nipper", "bottom_nipper", "nipper_blue", solid(
            plate(arms, *widths),
            plate(bracket, *widths),
            plate(model.outline("bottom_stiffener").buffer(-0.0002, join_style="mitre"),
                  (low + 0.002, high - 0.002)),
        )),
        Part("bottom_nipper", "cushion_plate", "steel",
             solid(plate(plates, model.width("bottom_lip")))),
        Part("bottom_nipper", "jaw_shaft", "dark_steel", solid(
            plate(shaft, (widths[1][0] - 0.001, widths[0][1] + 0.001)),
            plate(disc(rocker, model.radius("rocker_stud_left")),
                  *both(model.width("rocker_stud_left"))),
        )),
    ]  # fmt: skip


def rocker(model: Model) -> list[Part]:
    """Front rockers: an eye on the stud, a hub on the cylinder shaft."""
    foot = model.joint["rocker_foot_fixed"]
    outline = unary_union([
        bar(disc((0.0, 0.0), 0.0085), disc(foot, 0.0085)),
        disc((0.0, 0.0), 0.0105),
        model.disc("rocker_hub_left"),
    ]).difference(disc((0.0, 0.0), model.radius("rocker_stud_left") + PLAY))  # fmt: skip
    outline = outline.difference(disc(foot, SHAFT + PLAY))
    widths = both(model.width("rocker_arm_left"))
    return [Part("rocker", "rockers", "rocker_green", solid(plate(outline, *widths)))]


def top_nipper(model: Model) -> list[Part]:
    """Two arms from the jaw shaft over the plate, lugs of the steeve's pin, and the lip."""
    rod, width = model.joint["rod_pin"], model.width("top_plate")
    plates = model.outline("top_plate")
    nose = bar(model.disc("top_lip"), plates.intersection(disc(model.at("top_lip"), 0.012)))
    tip = disc(model.axis("top_plate", 0.036, 0.001), 0.0009)
    arms = bar(disc((0.0, 0.0), 0.009), disc(rod, 0.008), tip)
    # Nothing but the hub may reach below the plate, where the bottom nipper is.
    above = box(-0.1, -0.0015, 0.1, 0.1)
    pitch = math.degrees(math.atan2(*reversed(np.subtract(
        model.axis("top_plate", 1.0, 0.0), model.at("top_plate")).tolist())))  # fmt: skip
    above = rotate(above, pitch, origin=(0.0, 0.0))
    above = translate(above, *model.at("top_plate"))
    hub = model.disc("jaw_hub")
    arms = unary_union([arms.intersection(above), disc((0.0, 0.0), 0.0085)])
    lug = bar(disc(rod, 0.0075), model.outline("rod_lug_left").intersection(above))
    lug = lug.difference(disc(rod, model.radius("rod_cross_pin") + PLAY))
    bore = disc((0.0, 0.0), 0.0041)
    inner = width[1] - 0.008
    return [
        Part("top_nipper", "top_nipper", "nipper_orange", solid(
            plate(plates, width),
            plate(arms.difference(bore).difference(disc(rod, 0.0051)), *both((inner, width[1]))),
            plate(hub.difference(bore), model.width("jaw_hub")),
            plate(lug, *both(model.width("rod_lug_left"))),
        )),
        Part("top_nipper", "top_lip", "steel", solid(plate(nose, model.width("top_lip")))),
    ]  # fmt: skip


def steeve(model: Model) -> list[Part]:
    """Rod with nut below, tube with head above, and between them the spring, left and right."""
    head = model.joint["steeve"]
    length = math.hypot(*head)
    up = np.array(head) / length

    def on(distance: float) -> Pair:
        return float(up[0] * distance), float(up[1] * distance)

    y = sum(model.width("steeve_rod_left")) / 2.0
    top = 2.0 * math.hypot(*model.at("steeve_tube_left"))
    nut, end = 0.036, length - top
    rods, nuts, tubes = [], [], []
    for side in (y, -y):
        width = (side - 0.0075, side + 0.0075)
        eye = disc((0.0, 0.0), 0.0095).difference(disc((0.0, 0.0), 0.0051))
        rods += [*plate(eye, width), tube(on(0.0085), on(0.108), side, 0.005)]
        nuts += [tube(on(nut - 0.008), on(nut - 0.002), side, 0.0088, n=6),
                 tube(on(nut - 0.002), on(nut), side, 0.0095)]  # fmt: skip
        ring = disc((0.0, 0.0), model.radius("steeve_head_left"))
        ring = ring.difference(disc((0.0, 0.0), model.radius("eccentric_disc_left") + PLAY))
        tubes += [
            *plate(ring, (side - 0.009, side + 0.009)),
            tube(
                _less(head, on(length - 0.017)), _less(head, on(end + 0.001)), side, 0.009, 0.0053
            ),
            tube(_less(head, on(end + 0.004)), _less(head, on(end)), side, 0.0105, 0.0056),
        ]
    pitch = math.atan2(up[0], up[1])
    start = on(nut)
    springs = [
        Part("steeve_lower", f"spring_steeve_{name}", "spring_red",
             coil(end - nut) if name == "left" else None, file="spring",
             origin=f'xyz="{start[0]:.8f} {side:g} {start[1]:.8f}" rpy="0 {pitch!r} 0"',
             scale=f"1 1 {end - nut:.8f}")
        for name, side in (("left", y), ("right", -y))
    ]  # fmt: skip
    pin = plate(disc((0.0, 0.0), model.radius("rod_cross_pin")), model.width("rod_cross_pin"))
    return [
        Part("steeve_lower", "steeve_rods", "steeve_grey", solid(rods)),
        Part("steeve_lower", "steeve_nuts", "dark_steel", solid(nuts, pin)),
        *springs,
        Part("steeve_upper", "steeve_tubes", "steeve_grey", solid(tubes)),
    ]


def _less(head: Pair, point: Pair) -> Pair:
    """From the frame of the lower half of the steeve to that of the upper one."""
    return point[0] - head[0], point[1] - head[1]


def tension_radius(model: Model) -> float:
    """Radius of the tension shaft: no larger than its eccentrics can hold."""
    off = math.hypot(*model.joint["eccentric_pin_fixed"])
    return min(model.radius("tension_shaft"), model.radius("eccentric_disc_left") - off - RIM)


def eccentric(model: Model) -> list[Part]:
    """Tension shaft and its two eccentrics."""
    low, _ = model.width("tension_shaft")
    shaft = disc((0.0, 0.0), tension_radius(model))
    discs = disc(model.joint["eccentric_pin_fixed"], model.radius("eccentric_disc_left"))
    return [
        Part("eccentric", "tension_shaft", "dark_steel", solid(plate(shaft, (low, BOSS + 0.002)))),
        Part("eccentric", "eccentric_discs", "drum_brass",
             solid(plate(discs.difference(shaft), *both(model.width("eccentric_disc_left"))))),
    ]  # fmt: skip


def visual(part: Part) -> str:
    """The element of the URDF that draws a part."""
    scaled = f' scale="{part.scale}"' if part.scale else ""
    origin = part.origin or 'xyz="0 0 0" rpy="0 0 0"'
    mesh = f'<mesh filename="meshes/{part.file or part.name}.stl"{scaled}/>'
    return (
        f'    <visual name="{part.name}">\n'
        f"      <origin {origin}/>\n"
        f"      <geometry>{mesh}</geometry>\n"
        f'      <material name="{part.material}"/>\n'
        "    </visual>\n"
    )


def write_visuals(urdf: Path, parts: Sequence[Part]) -> None:
    """Replace the visual elements of a URDF; every other character stays."""
    text = re.sub(r" *<visual\b.*?</visual>\n", "", urdf.read_text(encoding="utf-8"), flags=re.S)
    for link in dict.fromkeys(part.link for part in parts):
        block = "".join(visual(part) for part in parts if part.link == link)
        # A link's visuals stand after its inertia, or first in a link without one.
        place = re.compile(rf'(<link name="{link}">\n(?: *<inertial>.*?</inertial>\n)?)', re.S)
        found = place.search(text)
        if found is None:
            sys.exit(f"{urdf}: there is no link {link}")
        text = text[: found.end()] + block + text[found.end() :]
    urdf.write_text(text, encoding="utf-8")


def make(home: Path) -> None:
    """Write meshes and visual elements of one model and say how large the meshes are."""
    model = Model(home)
    makers = (frame, pendulum_arm, bottom_nipper, rocker, top_nipper, steeve, eccentric)
    parts = [part for maker in makers for part in maker(model)]
    target = home / "meshes"
    target.mkdir(exist_ok=True)
    for old in target.glob("*.stl"):
        old.unlink()
    total = 0
    for part in parts:
        if part.mesh is None:
            continue
        if not part.mesh.is_watertight:
            sys.exit(f"{part.name}: the solid is not closed")
        data = part.mesh.export(file_type="stl")
        if not isinstance(data, bytes):
            sys.exit(f"{part.name}: trimesh wrote text where binary STL was asked for")
        total += (target / f"{part.file or part.name}.stl").write_bytes(data)
        print(f"{part.link:14} {part.name:24} {len(part.mesh.faces):6} triangles")
    write_visuals(home / f"{home.name}.urdf", parts)
    print(f"wrote {total / 1e3:.0f} kB into {target}")


def main(*folders: str) -> None:
    """Make the solids of the models named, or of all that come with the package."""
    models = Path(__file__).resolve().parents[3] / "models"
    for home in map(Path, folders) if folders else (models / name for name in OWN):
        make(home)


if __name__ == "__main__":
    main(*sys.argv[1:])
