"""How much of a turn of the direct engine could a compiler take away?

    python scripts/maintain/measure/measure_turn_floor.py [--before OTHER] [--rounds 40]
        [--speed 650]

As `measure_transition_floor.py`, with the functions that follow a phase without freedom and
assemble the start. The calls that no rearrangement of the Python around them removes are recorded
once and made again with nothing else; time within the functions that a compiler could take over is
added up, without what they call of Pinocchio and of the drives. What is left of a turn when these
take no time at all is the floor. With OTHER, the folder of another checkout, its turn is measured
in turns with these and all is given as a share of it. Times are the least of all rounds, of the
processor but for the small dense work, as there.
"""

from __future__ import annotations

import argparse
import gc
import sys
from collections.abc import Callable
from pathlib import Path

from compare_versions import Version
from measure_transition_floor import DENSE, Owned, recorded, seconds, within

import nipper_pin as nip
from nipper_pin.dynamics.multibody import Multibody
from nipper_pin.dynamics.shaft import ShaftMotion
from nipper_pin.dynamics.system import System
from nipper_pin.hybrid import advance
from nipper_pin.hybrid.event_location import guards
from nipper_pin.hybrid.motion import kinematics, panel
from nipper_pin.hybrid.run import start

DRIVES: Owned = (ShaftMotion, ("driven", "driven_at"))
DYNAMICS: Owned = (Multibody, ("accelerations", "inverse_dynamics"))
CLOSURES: Owned = (Multibody, ("closures", "closure_accelerations", "impulse_response"))
CALLS: dict[str, tuple[Owned, ...]] = {
    "evaluations of the dynamics": (DYNAMICS,),
    "closures and impulse responses": (CLOSURES,),
    "laws of the drives": (DRIVES,),
}
WITHOUT_FREEDOM: tuple[Owned, ...] = (
    (advance, ("kinematic_panel",)),
    (kinematics, ("close_positions", "close_velocities", "multipliers")),
    (System, ("determined_accelerations",)),
    (panel, ("close_positions", "close_velocities", "inverses", "multipliers")),
    (guards, ("_gap_root", "_force_root", "first_descent")),
    (start, ("assemble",)),
)
# Called by these, and not to be counted with them.
OTHERS: tuple[Owned, ...] = (
    DRIVES,
    DYNAMICS,
    CLOSURES,
    (System, ("respond", "split", "prescribe")),
    (guards, ("one_state_at", "forces_at")),
)


def main() -> int:
    """Measure in turns."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--before", type=Path, help="folder of another checkout")
    parser.add_argument("--rounds", type=int, default=40)
    parser.add_argument("--speed", type=float, default=650.0, help="r/min")
    options = parser.parse_args()
    mechanism = nip.load("e62")
    case = nip.Case(speed_rpm=options.speed, window=nip.Window.CYCLE)

    def turn() -> object:
        return nip.simulate(mechanism, case)

    turn()
    rows: dict[str, Callable[[], float]] = {}
    if options.before is not None:
        other = Version(options.before.resolve(), options.speed)
        rows["turn of the other checkout"] = lambda: float(other.ask("cycle"))
    rows["turn"] = lambda: seconds(turn)
    for title, owned in CALLS.items():
        again, count = recorded(turn, *owned)
        rows[f"{title} ({count} calls)"] = lambda again=again: seconds(again)  # type: ignore[misc]
    rows["small dense work"] = lambda: within(turn, (*DENSE, *WITHOUT_FREEDOM), OTHERS)
    taken: dict[str, list[float]] = {title: [] for title in rows}
    gc.disable()
    for _ in range(options.rounds):
        for title, measure in rows.items():
            taken[title].append(measure())
        gc.collect()
    _report(taken)
    return 0


def _report(taken: dict[str, list[float]]) -> None:
    """Print the least of every row, the rest, and what is left without the small dense work."""
    found = {title: 1e3 * min(times) for title, times in taken.items()}
    whole = next(iter(found))
    parts = [found[title] for title in found if not title.startswith("turn")]
    rest = "the rest: panels, states, events, choice of phases and coordinates"
    found[rest] = found["turn"] - sum(parts)
    found["turn without the small dense work"] = found["turn"] - found["small dense work"]
    for title, least in found.items():
        print(f"{title:66} {least:6.2f} ms, {least / found[whole]:.3f} of the {whole}")


if __name__ == "__main__":
    sys.exit(main())
