"""Tolerances of the direct engine: panels, events, stated errors and results."""

from .mechanics import EPS

# Panels

SMALLEST = 1e-300
"""[1] Addition to a divisor that may be zero. Beside any motion it changes no bit."""
COORDINATE_ROUND_OFF = 4.0 * EPS
"""[1] By a coordinate or the reach: round-off of a computed coordinate. A choice: four of its last
digits."""
ROUND_OFF_SAFETY = 8.0
"""[1] Factor on a round-off that was sampled. A choice: one pattern of signs is tried out of
many."""
ITERATION_FLOOR = 1e3 * EPS
"""[1] Relative change of a sweep below which an iteration that no longer converges is at its end. A
choice: round-off of sums over the nodes is tens to hundreds of eps."""
NOTICED_ROUND_OFF = 0.1
"""[1] By the motion on a panel: an allowance for round-off that may decide on it. A choice: a
smaller one changes no verdict that is not at its edge."""
SHORTEST_PANEL = 1e-12
"""[1] By a turn: shorter panels are refused. Tenfold ``SIMULTANEOUS``, so that its ends are never
one event."""
KNOT_ROUND_OFF = 8.0 * EPS
"""[1] By the cylinder angle and a turn: distance to a knot of a drive within which its law is not
asked, but continued. A choice: round-off of the angle, of the knot, and of both in one turn."""

# Events and contact

ROOT_RESOLUTION = 4.0 * EPS
"""[1] By the ends of its bracket: where the search for a root in time ends. Its four last digits
are round-off."""
SHALLOW_DIP = 0.25
"""[1] By the higher side of a dip: a bottom above, as a parabola has it, is above zero. A choice:
of a resolved function the parabola errs by less."""
GAP_ROUND_OFF = 1e-13
"""[1] By the unit of its coordinate: gap that counts as zero where closures determine it. It is 450
eps."""
ROOT_GAP_ROUND_OFF = 1e-14
"""[1] By the unit of its coordinate: gap at a root that was just found, up to which it is zero. It
is 45 eps."""
SIMULTANEOUS = 1e-13
"""[1] By a turn: events that are nearer are one. It is 450 eps of a turn."""
CLOSING_SHARE = 1e-3
"""[1] By the largest closing term of a gap of zero: one that starts with less does not close at
once. A choice, far above round-off."""
RISING_FORCE = 1e-9
"""[1] By its largest value: how far below zero a force may start that rises. A choice, far above
the round-off of a force that starts at zero."""
ACTIVE_SET_ROUND_OFF = 1e-12
"""[1] By the largest value of the stop in any set: a force or acceleration below zero that counts
as zero. A choice: 4500 eps, for accelerations that solve a linear system."""
ACCELERATION_LOOKAHEAD = 1e-7
"""[1] Part of a turn after which accelerations are looked at again. A choice above the square root
of eps, 1.5e-8, below which a difference loses more by round-off than it gains."""
TIME_ROUND_OFF = 1e-15
"""[1] By a time or a turn: remaining time that counts as none. It is four and a half eps."""
SERIES_LIMIT_STEP = 1e-4
"""[1] By what an order changes: last step to the limit of a series of bounces. A choice: the
order's own error is larger, and two or three steps reach it."""
SERIES_SAFETY = 3.0
"""[1] Factor on the difference of two orders, the error of a series of bounces. A choice; what it
misses ``SERIES_ERROR_SAFETY`` covers."""
SERIES_PART = 0.06
"""[1] Part of the difference before that the error is at least. A choice: the last difference may
be small because it changes its sign."""
SERIES_EARLIER = 0.1
"""[1] The same of the difference two orders before. A choice, limited by ``SERIES_PACE``."""
SERIES_PACE = 10.0
"""[1] Factor on what differences that fall at one ratio predict. A choice: it limits what a large
early difference adds to an error."""
SETTLED_DECELERATION = 0.75
"""[1] Relative change of the deceleration from which earlier collisions are not extrapolated. A
choice: a polynomial through them seems to converge, to a wrong limit."""
NESTED_ERROR_SAFETY = 4.0
"""[1] Factor on the difference of two orders of a nested series, which shows the error of the
higher one. A choice."""
NESTED_ERROR_PART = 0.015
"""[1] Part of the difference before that counts if the last is smaller. A choice: the last may be
small because it changes its sign."""
NESTED_AT_LAST = 1e3
"""[1] By the tolerance, of a turn: error of the limit of a nested series of very many collisions. A
choice: what is extrapolated from limits of the series inside loses two or three of their digits."""
NEARLY_GEOMETRIC = 0.5
"""[1] Relative distance of a limit from that of a geometric series, beyond which it is not used. A
choice: such collisions are not of one series yet."""
CONSTANT_DECELERATION = 0.1
"""[1] Change of a deceleration up to which the rest follows from it alone. A choice: the change, by
the remaining time, is stated as the error."""
STEADY_DECELERATION = 1e-12
"""[1] Change of a deceleration over a flight, and of the flight's length by it, up to which it does
not change. A choice: 4500 eps, for accelerations that solve a linear system."""
VANISHED_REBOUND = 8.0 * EPS
"""[1] By the farthest place of a stop of its part: a rebound that is no higher is round-off of the
coordinate. Eight units: those of a gap at both ends of a flight."""
DROPPED_SERIES = 100.0
"""[1] By the tolerance: cube of the relative rate from which a series may end. Measured: it leaves
at most 2e-3 of that cube in rates of inertial shafts, 0.2 of the tolerance."""
SLOWEST_JAM_RATE = 1e-9
"""[1] By the fastest rate: slower collisions end a series and are no jam. A choice: there round-off
keeps times and rates from falling."""
JAM_SLOWING = 1e-3
"""[1] Part of its rate that a stop must lose over the collisions of one instant, or they are a jam.
A choice: a restitution of 0.9999 loses twice as much in twenty."""

# Stated errors

DIFFERENCE_STEP = 1e-6
"""[1] By the unit of a coordinate, or by the largest rate: step of difference quotients in stated
errors. A choice between the square root of eps, best for one-sided ones, and its cube root, for
central ones."""
LOCAL_ERROR_SAFETY = 8.0
"""[1] Factor on the estimated error of a panel. Measured over ten runs at six tolerances: true
errors were up to 4.6 times the bare estimate, and up to 11 times with masses that differ by 1e8."""
INDEPENDENT_ROUND_OFF = 4.0 * EPS
"""[1] By the reach: round-off of an independent position. Measured: of what 8 eps state, true
errors of events that follow from the drives were at most a tenth."""
POLYNOMIAL_ROUND_OFF = 4.0 * EPS
"""[1] By its largest term: round-off of a polynomial. A choice: four of its last digits."""
SERIES_ERROR_SAFETY = 2.0
"""[1] Factor on the error of the limit of a series of bounces. Measured: limits were off by up to
1.8 times what their points tell."""
FORCE_SLOPE_STEP = 1e-3
"""[1] Part of a panel over which the slope of a falling force is taken. A choice: truncation is a
thousandth, and round-off of the force less."""
CLOCK_ROUND_OFF = 2.0 * EPS
"""[1] By the time: round-off of the clock. One rounding of each of two times that are
subtracted."""
RATE_ROUND_OFF = 16.0 * EPS
"""[1] By a rate that follows from drives and closures: its round-off. A choice, as
``CLOSURE_RESIDUAL`` of positions."""
LEVER_ROUND_OFF = 2.0 * EPS
"""[1] By the terms of a closure rate, levers times rates: their round-off. Four roundings: of the
two places that a lever is the difference of, of the lever and of the product. Measured on 2,474
machines of other dimensions, with ``LENGTH_ROUND_OFF``: true errors were at most a sixth."""
LENGTH_ROUND_OFF = 1.0 * EPS
"""[1] By the reach, which is a sum of lengths: round-off of closures in the touch configuration.
One rounding of each length that is read, and one of each sum: nothing is turned there."""
ANGLE_ROUND_OFF = 2.0 * EPS
"""[1] By the cylinder angle or a radian, whichever is more: its round-off. Near the extreme of a
drive law terms of the size of one cancel in its rate."""
NEGLIGIBLE_DEVIATION = 1e-12
"""[1] By the longest deviation: directions that are shorter are not kept apart. A choice: twelve
digits of an error."""

# Results: the premise, periodic turns and energy

REST_BEFORE_TOUCH = 1e-6
"""[1] Part of a turn by which the last rest has to lie before the touch. A choice, a thousand times
``DECISION_TOLERANCE``."""
DECISION_TOLERANCE = 1e-9
"""[1] Least tolerance of a run that only decides on the premise. A choice: its times are right to a
thousandth of ``REST_BEFORE_TOUCH``."""
SAME_ASSEMBLY = 1e-5
"""[1] By units of coordinates: largest difference of positions in one assembly of the links. A
choice: two assemblies differ by far more, and positions of one by far less."""
SAME_POSITION = 1e-9
"""[1] By units of coordinates: largest difference between the ends of a periodic turn. A choice,
far above the round-off of closed positions."""
SAME_RATE = 1e-6
"""[1] By the largest rate of the turn: the same of rates. A choice, far above amplified round-off
and far below what an event changes."""
FORCE_RESOLVED = 1e-11
"""[1] By the largest coefficient: last ones of a series that holds the force of a closed stop. A
choice, a tenth of the tolerance that turns have unless another is asked for."""
REAL_ROOT = 1e-9
"""[1] Imaginary part, by half the interval, up to which a root of such a series is real. A choice
above the round-off of eigenvalues; a root that is taken or left in error changes an extreme by its
square."""
ENERGY_AGREEMENT = 1e-12
"""[1] Error of an energy integral, by the energy of the panel, or by the largest kinetic energy so
far times its part of the duration. A choice: round-off may exceed the former."""
SELF_CHECK = 1e-6
"""[1] Part of the reach of the mechanism by which closures may gape, and part of all exchanged
energy that the balance may leave over, before a run is refused. A choice, far above round-off."""
SELF_CHECK_TOLERANCES = 1e3
"""[1] The same in tolerances of the run. A choice: some thousand times what the machines of the
package leave over."""
STORED_ENERGY = 1e-12
"""[1] Round-off of the energy balance by the energy of springs and weights. A choice, as
``ENERGY_AGREEMENT``."""

# Limits of a case

LEAST_TOLERANCE = 1e-14
"""[1] Least tolerance of the direct engine that may be asked for. A choice: it is 45 eps, below
which panels would resolve round-off."""
LARGEST_TOLERANCE = 1e-3
"""[1] Largest tolerance of the direct engine that may be asked for. A choice: three digits."""
