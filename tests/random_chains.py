"""Random machines of several freedoms: chains with a lower and an upper stop on each joint."""

from __future__ import annotations

import numpy as np
from small_machines import SHAFT, frame, hinge, link, machine, slide

from nipper_pin import Mechanism


def chain(rng: np.random.Generator, free: int, shaken: bool, tied: bool) -> Mechanism:
    """A chain of hinges and slides with random masses, springs and stops on both sides.

    Args:
        rng: Where the numbers come from.
        free: Number of its joints.
        shaken: Whether it hangs on a base that a shaft swings, or on the frame.
        tied: Whether its end is tied to the frame by two links more and a pin, which leave it its
            freedoms.
    """
    parts, springs, stops, drives, closures, parent = [], {}, {}, {}, {}, "frame"
    end = np.zeros(2)
    if shaken:
        parts += [link("base"), hinge("shaft", "frame", "base")]
        drives["shaft"] = {
            "joint": "shaft", "law": "fourier", "sine_rad": [0.3, 0.1], **SHAFT
        }  # fmt: skip
        parent = "base"
    for number in range(free):
        name, x, z = f"j{number}", *rng.uniform(-0.4, 0.4, 2).tolist()
        end += x, z
        centre = tuple(rng.uniform(-0.3, 0.3, 2).tolist())
        mass, inertia = rng.uniform(0.2, 3.0), rng.uniform(0.01, 0.2)
        parts.append(link(f"b{number}", float(mass), float(inertia), centre))
        turns = rng.random() < 0.6
        if turns:
            parts.append(hinge(name, parent, f"b{number}", (x, z)))
        else:
            angle = rng.uniform(0.0, 2.0 * np.pi)
            axis = (float(np.cos(angle)), float(np.sin(angle)))
            parts.append(slide(name, parent, f"b{number}", axis, (x, z)))
        at, scale = ("at_deg", 40.0) if turns else ("at_mm", 400.0)
        # A loop has to close wherever the stops let the chain go.
        scale *= 0.1 if tied else 1.0
        for side, sign in (("lower", -1.0), ("upper", 1.0)):
            stops[f"{name} {side}"] = {
                "joint": name, "restitution": float(rng.uniform(0.0, 1.0)), "side": side,
                at: sign * scale * float(rng.uniform(0.1, 1.0)),
            }  # fmt: skip
        stiffness, preload = (
            ("stiffness_N_m_per_rad", "preload_deg") if turns
            else ("stiffness_N_per_m", "preload_length_mm")
        )  # fmt: skip
        springs[f"s{number}"] = {
            "joint": name, stiffness: float(rng.uniform(1.0, 50.0)),
            preload: float(rng.normal(0.0, 50.0)),
        }  # fmt: skip
        parent = f"b{number}"
    if tied:
        x, z = end.tolist()
        parts += [
            frame("tip", parent, (0.2, 0.1)),
            link("rocker", 0.7, 0.02), hinge("rocker_axis", "frame", "rocker", (x + 1.0, z + 0.3)),
            link("coupler", 0.4, 0.01), hinge("elbow", "rocker", "coupler", (-0.3, -0.9)),
            frame("coupler_end", "coupler", (-0.5, 0.7)),
        ]  # fmt: skip
        closures["tie"] = {"frame_a": "tip", "frame_b": "coupler_end"}
    return machine(
        parts, free + shaken, gravity=9.81, drives=drives, springs=springs, stops=stops,
        closures=closures,
    )  # fmt: skip
