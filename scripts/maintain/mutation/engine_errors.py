"""Deliberate errors of the engine: what each does, and the text that it changes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Mutation:
    """One deliberate error.

    Attributes:
        name: Short name.
        meaning: What it does to the engine.
        file: File inside the package.
        right: Text that stands there once.
        wrong: Text that takes its place.
    """

    name: str
    meaning: str
    file: str
    right: str
    wrong: str


MUTATIONS = (
    Mutation(
        "restitution-sign", "a stop goes on closing after a collision",
        "dynamics/impact.py", "wanted = [-e_N * rate", "wanted = [e_N * rate",
    ),
    Mutation(
        "restitution-row", "all stops in contact have the restitution of the first",
        "dynamics/impact.py", "for e_N, rate in zip(restitution, before",
        "for e_N, rate in zip(restitution[:1] * len(before), before",
    ),
    Mutation(
        "loss-of-energy", "energy lost from the jump of the rate instead of its mean",
        "dynamics/impact.py", "(stop.rate(v) + wanted[place])",
        "(stop.rate(v) - wanted[place])",
    ),
    Mutation(
        "arrest-sign", "rest doubles the last rate instead of taking it away",
        "dynamics/impact.py", "jumps = [-stop.rate(v)", "jumps = [stop.rate(v)",
    ),
    Mutation(
        "stale-placement", "closure Jacobians are read with the placement of the state before",
        "dynamics/multibody.py",
        "                constraint.calc(model, data, constraint_data)\n", "",
    ),
    Mutation(
        "dead-row", "closures keep x and the row out of the plane instead of x and z",
        "dynamics/open_tree.py",
        "PLANAR_ROWS_OF_A_POINT = (0, 2)", "PLANAR_ROWS_OF_A_POINT = (0, 1)",
    ),
    Mutation(
        "lost-coriolis", "accelerations without any term in the rates",
        "dynamics/multibody.py", "q[row], v[row], tau[row], pins",
        "q[row], 0.0 * v[row], tau[row], pins",
    ),
    Mutation(
        "stale-lift", "rates of dependent joints by the closures of another configuration",
        "dynamics/system.py", "if place is not jacobian or", "if place is None or",
    ),
    Mutation(
        "preload-sign", "the preload pulls",
        "dynamics/coefficients.py", "preload[spring.index] -= ", "preload[spring.index] += ",
    ),
    Mutation(
        "lost-damping", "elastic drive trains without damping of the shaft's own rate",
        "dynamics/system.py", "tau -= phase.damping * v", "tau -= 0.0 * phase.damping * v",
    ),
    Mutation(
        "lost-feedforward", "elastic drive trains without the inertia of the law",
        "dynamics/system.py", "numbers.inertia * a_law\n                + numbers", "numbers",
    ),
    Mutation(
        "lost-spring-force", "forces of constraint without the springs",
        "dynamics/multipliers.py", " - system.applied_forces(q, v)", "",
    ),
    Mutation(
        "strut-sign", "springs and dampers between two points push where they should pull",
        "dynamics/elements.py", "tau -= np.einsum(", "tau += np.einsum(",
    ),
    Mutation(
        "half-a-strut", "a spring between two points does not load the joints behind its second",
        "dynamics/open_tree.py",
        "data.oMi[joint_b].act(local_b.translation), -force)",
        "data.oMi[joint_b].act(local_b.translation), 0.0 * force)",
    ),
    Mutation(
        "beyond-the-table", "a motion that leaves the table of a spring goes on",
        "dynamics/elements.py", "if outside.size:", "if outside.size > len(x):",
    ),
    Mutation(
        "lost-heat", "the energy balance without what dampers take",
        "hybrid/result/energy_balance.py",
        " - self.impact_losses - self.dissipated", " - self.impact_losses",
    ),
    Mutation(
        "guide-curvature", "second derivative of the oscillating guide with the wrong sign",
        "mechanism/drives/oscillating_guide.py",
        "second = (d * (r * r - d * d))", "second = (d * (d * d - r * r))",
    ),
    Mutation(
        "preload-unit", "preload lengths in centimetres",
        "mechanism/build/elements.py", "        M_PER_MM,\n", "        10.0 * M_PER_MM,\n",
    ),
    Mutation(
        "gap-unchecked", "closures that do not meet are accepted",
        "mechanism/build/closing.py", "if length > most_m:", "if length > 1e9 * most_m:",
    ),
    Mutation(
        "index-sense", "the index scale runs against the cylinder",
        "mechanism/cylinder.py", "turns = self.sense * (psi", "turns = -self.sense * (psi",
    ),
    Mutation(
        "series-slope", "the limit of a series of bounces with the slope of one flight",
        "hybrid/contact/bounce_series.py", "0.5 * (1.0 - e_N))", "0.5)",
    ),
    Mutation(
        "half-left-out", "what bounces that are left out do to rates, without its second order",
        "hybrid/error_estimate/truncated_bounces.py", "by_place + by_rates", "by_place",
    ),
    Mutation(
        "pressed-sign", "a stop stays closed when it is pulled open",
        "hybrid/contact/complementarity.py", ".rate(a) <= 0.0:", ".rate(a) >= 0.0:",
    ),
    Mutation(
        "no-release", "closed stops never let go",
        "hybrid/event_location/guards.py", "for column, stop in enumerate(phase.shut):",
        "for column, stop in enumerate(phase.shut[:0]):",
    ),
    Mutation(
        "lever-inverse", "the lip's impulse multiplied by the lever instead of divided",
        "hybrid/result/tables.py", "event.P_N[stop.name] / stop.lever",
        "event.P_N[stop.name] * stop.lever",
    ),
    Mutation(
        "copied-turn", "all copies of a repeating turn lie on the second one",
        "hybrid/run/phase_manager.py", "delay, moved = turn * period", "delay, moved = period",
    ),
    Mutation(
        "lost-impulse-work", "the energy balance without the work of the held drives' impulses",
        "hybrid/result/energy_balance.py",
        "self.drive_work + self.drive_impulse_work + self.gravity_work",
        "self.drive_work + self.gravity_work",
    ),
    Mutation(
        "saved-swapped", "velocities before and after change places on disk",
        "hybrid/files/npz.py", "event.v_before, event.v_after, event.delta",
        "event.v_after, event.v_before, event.delta",
    ),
    Mutation(
        "mesh-outside", "mesh paths may leave the model folder through links",
        "mechanism/files/urdf_shapes.py", "if not path.is_relative_to(followed(mesh_folder)):",
        "if not path.is_absolute():",
    ),
)  # fmt: skip
