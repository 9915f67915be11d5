"""Draw a model in side view, jaw open and jaw closed, from its collision shapes.

Run: python scripts/maintain/figures/draw_side_view.py [MODEL] [FILE.png]
"""

from __future__ import annotations

import sys

import numpy as np
import pinocchio as pin
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

import nipper_pin as nip
from nipper_pin.mechanism import collision_model


def draw(axes: Axes, mechanism: nip.Mechanism, links: list[pin.SE3]) -> None:
    """Draw all shapes: circles for cylinders across the plane, outlines for everything else."""
    geometry, _ = collision_model(mechanism)
    order = [mechanism.model.getJointId(joint.name) for joint in mechanism.joints]
    for item in geometry.geometryObjects:
        joint = order.index(item.parentJoint) + 1 if item.parentJoint else 0
        place = links[joint] * item.placement
        colour = f"C{joint}" if joint else "0.6"
        x, _, z = 1e3 * place.translation
        kind = type(item.geometry).__name__
        if kind == "Cylinder" and abs(place.rotation[1, 2]) > 0.9:
            axes.add_patch(Circle((x, z), 1e3 * item.geometry.radius, fc=colour, ec="k", alpha=0.5))
            continue
        half = np.array(
            [item.geometry.radius, 0.0, item.geometry.halfLength]
            if kind == "Cylinder"
            else item.geometry.halfSide
        )
        corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        outline = [1e3 * place.act(half * np.array([a, 0.0, b]))[[0, 2]] for a, b in corners]
        axes.add_patch(Polygon(outline, fc=colour, ec="k", alpha=0.5))
    axes.set_aspect("equal")
    axes.autoscale_view()


def main(model: str = "e62", file: str = "side_view.png") -> None:
    """Draw the start of a cycle (jaw open) and the middle of the phase with the jaw closed."""
    mechanism = nip.load(model)
    speed = mechanism.cylinder.rated_speed_rpm
    solution = nip.simulate(mechanism, nip.Case(speed_rpm=speed, window=nip.Window.CYCLE))
    stop = mechanism.transition_stop
    closed = next(phase for phase in solution.phases if stop in phase.closed)
    figure = Figure(figsize=(11.0, 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    for place, t in enumerate((0.0, 0.5 * (closed.t_start + closed.t_end))):
        axes = figure.add_subplot(1, 2, place + 1)
        q = solution.trajectory.evaluate(t).q[0]
        draw(axes, mechanism, [pin.SE3.Identity(), *solution.system.body.placements(q)])
        index = mechanism.cylinder.index_from_angle(float(solution.shaft.angle(t)))
        axes.set_title(f"{'jaw closed' if place else 'jaw open'}, index {index:.1f}")
        axes.set_xlabel("x [mm]")
        axes.set_ylabel("z [mm]")
    figure.suptitle(mechanism.title)
    figure.savefig(file, dpi=110)
    print(f"wrote {file}")


if __name__ == "__main__":
    main(*sys.argv[1:3])
