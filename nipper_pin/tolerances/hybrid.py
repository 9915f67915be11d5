"""Tolerances of the direct engine: panels, events, stated errors and results."""

from .mechanics import EPS

# Hybrid motion: panels, events and contact

SMALLEST = 1e-300
"""[1] Added to a divisor that may be zero: beside any motion it changes no bit."""
COORDINATE_ROUND_OFF = 4.0 * EPS
"""[1] By a coordinate or the reach: round-off of a computed coordinate, four of its last digits."""
ROUND_OFF_SAFETY = 8.0
"""[1] Over a sampled round-off: one pattern of signs out of many in which it may fall is tried."""
ITERATION_FLOOR = 1e3 * EPS
"""[1] Relative change of a sweep below which only round-off is left in the iteration."""
TIME_ROUND_OFF = 1e-15
"""[1] By a time or a turn: four and a half eps; of a shorter time nothing is left but round-off."""
ROOT_RESOLUTION = 4.0 * EPS
"""[1] By the ends of its bracket: four last digits, beyond which no root in time is resolved."""
GAP_ROUND_OFF = 1e-13
"""[rad or m] Of a gap that the closures determine: 450 eps at lengths of one."""
ROOT_GAP_ROUND_OFF = 1e-14
"""[rad or m] Of a gap at a root that was just found: 45 eps at lengths of one."""
SIMULTANEOUS = 1e-13
"""[1] Triggers nearer than this fraction of a turn are one event: 450 eps of a turn."""
SHORTEST_PANEL = 1e-12
"""[1] By a turn: tenfold ``SIMULTANEOUS``, so that a panel's ends are never one event."""
CLOSING_SHARE = 1e-3
"""[1] By the largest acceleration of a gap at zero: with less it does not start to close."""
RISING_FORCE = 1e-9
"""[1] By its largest value: a force that starts at zero may start, by round-off, below it."""
ACTIVE_SET_ROUND_OFF = 1e-12
"""[1] By the largest value of the stop in any set: a force or acceleration below zero by less."""
ACCELERATION_LOOKAHEAD = 1e-7
"""[1] Part of a turn in which accelerations tell how they change: above the square root of eps,
below which a difference quotient loses more by round-off than it gains."""

# Hybrid motion: stated errors

DIFFERENCE_STEP = 1e-6
"""[rad or m, or a share of the largest rate] Of difference quotients: near the cube root of eps,
6e-6, where truncation and round-off of a derivative balance."""
LOCAL_ERROR_SAFETY = 8.0
"""[1] True errors were up to 4.6 times the bare estimate, over ten runs at six tolerances; with
masses that differ by 1e8 up to 11 times."""
CLOCK_ROUND_OFF = 2.0 * EPS
"""[1] By the time: round-off of the clock, one rounding of each of two times subtracted."""
RATE_ROUND_OFF = 16.0 * EPS
"""[1] By a rate that follows from drives and closures, as ``CLOSURE_RESIDUAL`` of positions."""
ANGLE_ROUND_OFF = 2.0 * EPS
"""[1] By the cylinder angle or a radian, whichever is more: near the extreme of a drive law terms
of the size of one cancel in its rate."""
NEGLIGIBLE_DEVIATION = 1e-12
"""[1] By the longest deviation: directions shorter than this are not kept apart."""

# Results: the premise, periodic turns and jams

REST_BEFORE_TOUCH = 1e-6
"""[1] Part of a turn by which the last rest has to lie before the touch: far above both errors."""
DECISION_TOLERANCE = 1e-9
"""[1] Of a run that only decides: times right to a thousandth of ``REST_BEFORE_TOUCH``."""
SAME_ASSEMBLY = 1e-5
"""[rad or m] Assemblies of the links that are not the same differ by far more."""
SAME_POSITION = 1e-9
"""[rad or m] Between the ends of a periodic turn: far above round-off of closed positions."""
SAME_RATE = 1e-6
"""[1] By the largest rate of the turn: far above amplified round-off, far below what an event
changes."""
SLOWEST_JAM_RATE = 1e-9
"""[1] By the fastest rate: slower ones end a series of bounces, where round-off keeps times and
rates from falling."""
SERIES_LIMIT_STEP = 1e-4
"""[1] A root is found when a step is this part of what the order changes; it takes two or three."""
ENERGY_AGREEMENT = 1e-12
"""[1] Error of an energy integral, by the panel's energy or the largest kinetic energy so far times
its part of the duration: round-off may exceed the former."""
