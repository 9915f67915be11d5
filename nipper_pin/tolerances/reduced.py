"""Tolerances of the reduced engine: tables, flights and the rest of the turn."""

from .mechanics import EPS

FINEST_TOLERANCE = 1e-13
"""[1] Least tolerance of the reduced engine that may be asked for. A choice: it is 450 eps, and the
defect of a panel alone is known to 8 eps of the acceleration."""
COARSEST_TOLERANCE = 1e-3
"""[1] Largest tolerance of the reduced engine that may be asked for. A choice: three digits."""
ARRIVAL_TABLES = 1e-10
"""[1] Least tolerance to which tables of the rest of a turn are made. A choice: a rest before the
touch removes most of their effect, so more digits would cost time and change no phase."""
TURN_TABLES = 1e-11
"""[1] Tolerance to which tables of turns are made, by the size of an acceleration, and those of
drive torques, by the size of a torque. A choice: that of a transition unless another is asked
for."""
NO_ACCELERATION = 1e-290
"""[m/s^2 or rad/s^2] Accelerations at touch below this are zero. Weights are divided by them, and
1e-290 leaves 18 decades for the dividend before doubles overflow at 1.8e308."""
TABLE_ERROR_SAFETY = 2.0
"""[1] Factor on the largest error of a series at points that are sampled, or on its last terms. A
choice: random points miss the highest place, near which a smooth error is flat."""
REFINEMENT_GAIN = 0.1
"""[1] A refinement after which more than this part of the last terms is left has met round-off. A
choice: terms of a resolved smooth function fall by much more when cells or nodes double."""
TRIMMED_SHARE = 0.1
"""[1] Part of the tolerance that terms which are left out of a table may add up to. A choice: nine
tenths are left to other errors."""
GAP_SHARE = 1e-14
"""[1] Part of the size of a gap or of its slope that the terms which are left out of a table of a
turn may add up to. A choice: 45 eps, so that a stop that has just opened is not taken as closed."""
CORNER_ROUND_OFF = 128.0 * EPS
"""[1] Round-off of the place where a stop takes over from another one, by a turn, and of the gaps
there, by one radian or the reach of the machine. Measured on 1,000 random turns with three kernels
of BLAS: at most 97 eps."""
GROWTH_SAFETY = 2.0
"""[1] Factor on errors that grow along a flight as its linearised equation says. A choice: steps of
second order, sixteen a panel, miss a period of the motion by a few per cent."""
SAME_TURN = 1e-10
"""[1] Relative difference up to which two turns end alike. A choice: the tolerance of turns unless
another is asked for."""
COARSE_SWEEP = 1e-4
"""[1] Change of the acceleration, by that at the start, where the first guess of a flight's length
is good enough. A choice: it only places the end of a panel, with a margin of 1e-2."""
NEWTON_STEP = 1e-8
"""[1] Last step of Newton's method for a zero or a peak, by the time of the zero or the panel. What
is left is about its square, 1e-16, about half of eps."""
ZERO_RESOLUTION = 64.0 * EPS
"""[1] A Newton step out of the bracket that is shorter ends the search, by the time of the zero. A
choice: the polynomial is a sum of up to 25 rounded terms, and its zero no better known."""
TRAVEL_END = 1e-12
"""[1] Part of the travel of the tables below which nothing is left to follow. A choice: thousands
of times the round-off of a place, 2.2e-16."""
DEFECT_EFFECT = 12.0
"""[1] A defect of the acceleration between n nodes acts on end and peak at most as a constant error
of this multiple of it, divided by n^2. Computed for the first missing polynomials with decays of
0.1 to 0.8: 7.9; times 1.5 for other decays, and rounded up."""
LIMIT_ERROR_SAFETY = 32.0
"""[1] Factor on the difference of the last extrapolations of a series of bounces, which may agree
by chance. Measured on 20,000 random transitions: the error of the better one was larger by up to 10
in one of them; on 700 random turns by up to 26."""
LIMIT_CHANGE_SHARE = 0.125
"""[1] Part of what a limit of bounces still changes by that counts as a difference of its last
extrapolations. A choice: with ``LIMIT_ERROR_SAFETY``, a safety factor of four on that change; the
error was 3.2 times as large where a stop slows down three times less at its rest than it lands."""
ARRIVAL_SHARE = 1e-2
"""[1] Part of the tolerance to which the long flight before the touch is followed. A choice: its
error is then small beside that of the flights after it."""
PHASE_TOLERANCE = 1e-6
"""[1] Tolerance of flights that only decide in which phase the machine arrives. A choice: a tenth
of ``BEFORE_TOUCH``, within which nothing is decided."""
BEFORE_TOUCH = 1e-5
"""[rad] A rest, release or collision nearer to the touch leaves the phase of arrival undecided. A
choice: ten times ``PHASE_TOLERANCE``, the accuracy of the flights before it."""
FORCE_SIGN = 1e-9
"""[1] An extreme of a force that is smaller, by its largest mean on a cell of the tables, has no
certain sign. A choice: ten times ``ARRIVAL_TABLES``, the least tolerance of those tables."""
LATE_REST_SAFETY = 2.0
"""[1] Factor on what a series of bounces lasts at constant deceleration, within which it ends at
one that changes a little. A choice: a rest that much later still changes nothing, if the stop is
pressed until then."""
FLIGHT_UNRESOLVED = 1e-3
"""[1] Error of the gap at the touch, by the gap, from which a flight over it is not resolved. A
choice: of a smaller error the effect on the collision is nearly proportional to it."""
FLAT_EXTREME = 1e-6
"""[1] Part of a panel to which the place of an extreme is narrowed. There a torque is flat, so its
value is known to about the square, 1e-12."""
