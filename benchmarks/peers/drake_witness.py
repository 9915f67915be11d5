"""Drake's hybrid simulator: error control, witness functions for the impacts.

The witness is th / (time since the last impact), which starts at the rebound rate instead of zero:
a bounce inside a single step is then seen, and steps need no limit. Drake isolates its root by
bisection; what is left is removed along a parabola when the impact law is applied. The system is
the hand-derived equation: Drake's continuous multibody plant has no loops.
"""

from __future__ import annotations

import math

from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import (
    Context,
    ContinuousState,
    EventStatus,
    LeafSystem,
    State,
    UnrestrictedUpdateEvent,
    WitnessFunction,
    WitnessFunctionDirection,
)

from nipper_pin.mechanism import Mechanism
from nipper_pin.study.paper.scheme.planar_model import first_rebound_rate, planar_model
from nipper_pin.study.paper.scheme.planar_motion import jaw_equation

from .protocol import Bounces, Four, Run, Setting

NAME = "Drake runge_kutta5, witness functions (hand-derived equation)"
PACKAGE = "drake"
SETTINGS = (
    Setting("accuracy 1e-4", 1e-4),
    Setting("accuracy 1e-6", 1e-6),
    Setting("accuracy 1e-8", 1e-8),
    Setting("accuracy 1e-10", 1e-10),
    Setting("accuracy 1e-12", 1e-12),
    Setting("accuracy 1e-13", 1e-13),
)
_LONGEST = 0.1
_LONGEST_STEP = 2e-3


def prepare(mechanism: Mechanism, speed_rpm: float) -> Run:
    """Read the numbers and compile the right-hand side.

    Args:
        mechanism: The E62, or another set of numbers for it.
        speed_rpm: Cylinder speed [r/min].
    """
    p = planar_model(mechanism, speed_rpm)
    rate = first_rebound_rate(p)
    acceleration = jaw_equation(p)

    class Jaw(LeafSystem):  # type: ignore[misc]
        """The jaw in flight, its impacts and its greatest angle."""

        def __init__(self, bounces: Bounces) -> None:
            LeafSystem.__init__(self)
            self.bounces, self.evaluations, self.last, self.rate = bounces, 0, 0.0, rate
            self.DeclareContinuousState(1, 1, 0)
            falls = WitnessFunctionDirection.kPositiveThenNonPositive
            self.impact = self.MakeWitnessFunction(
                "impact", falls, self._ground, UnrestrictedUpdateEvent(self._impact)
            )
            self.apex = self.MakeWitnessFunction(
                "apex", falls, self._rate, UnrestrictedUpdateEvent(self._apex)
            )

        def DoCalcTimeDerivatives(self, context: Context, derivatives: ContinuousState) -> None:
            th, w = context.get_continuous_state_vector().CopyToVector().tolist()
            self.evaluations += 1
            derivatives.SetFromVector((w, acceleration(context.get_time(), th, w)))

        def DoGetWitnessFunctions(self, context: Context) -> list[WitnessFunction]:
            del context
            return [self.impact, self.apex] if self.last == 0.0 else [self.impact]

        def _ground(self, context: Context) -> float:
            since = context.get_time() - self.last
            if since <= 0.0:
                return self.rate
            return float(context.get_continuous_state_vector()[0] / since)

        def _rate(self, context: Context) -> float:
            return float(context.get_continuous_state_vector()[1])

        def _apex(self, context: Context, event: object, state: State) -> None:
            del event, state
            th, w = context.get_continuous_state_vector().CopyToVector().tolist()
            self.bounces.amplitude = th - 0.5 * w * w / acceleration(context.get_time(), th, w)

        def _impact(self, context: Context, event: object, state: State) -> EventStatus:
            del event
            t = context.get_time()
            th, w = context.get_continuous_state_vector().CopyToVector().tolist()
            approach = -math.sqrt(w * w - 2.0 * acceleration(t, th, w) * th)
            late = 2.0 * th / (w + approach)
            self.last, self.rate = t - late, -p.restitution * approach
            a = acceleration(self.last, 0.0, self.rate)
            new = (self.rate + 0.5 * a * late) * late, self.rate + a * late
            state.get_mutable_continuous_state().SetFromVector(new)
            if self.bounces.add(self.last, self.rate, -a):
                return EventStatus.ReachedTermination(self, "at rest")
            return EventStatus.Succeeded()

    def run(setting: Setting) -> Four:
        bounces = Bounces(p.restitution, rate, -acceleration(0.0, 0.0, rate), setting.value)
        jaw = Jaw(bounces)
        simulator = Simulator(jaw)
        integrator = ResetIntegratorFromFlags(simulator, "runge_kutta5", _LONGEST_STEP)
        integrator.set_target_accuracy(setting.value)
        context = simulator.get_mutable_context()
        # How far roots are isolated; the parabola to the root does the rest.
        context.SetAccuracy(math.sqrt(setting.value))
        context.SetContinuousState((0.0, rate))
        simulator.Initialize()
        simulator.AdvanceTo(_LONGEST)
        return bounces.four(jaw.evaluations)

    return run
