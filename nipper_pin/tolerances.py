"""Tolerances and safety factors, each with its unit and why it has its value.

The text of each begins with its unit in brackets, [1] for a ratio. What a user sets is in
:class:`nipper_pin.Case`; counts, and orders of polynomials, stand where they are used.
"""

import sys

EPS = sys.float_info.epsilon
"""[1] Spacing of doubles above one, 2^-52: unit of round-off."""

# Dynamics: closures, constraint forces and impacts

CLOSURE_RESIDUAL = 16.0 * EPS
"""[1] By the reach of the mechanism: a sum of ten rounded lengths of that size is no better."""
MAX_CONDITION = 5e4
"""[1] Of the dependent closure columns. Positions are known to 16 eps times it, rates lose it once
more, to 1e-5; accelerations lose it a third time, and a little beyond round-off decides on them."""
GOOD_CONDITION = 25.0
"""[1] By the number of closure rows, where other coordinates may be made dependent: what is left
unresolved of the independent ones is multiplied by it."""
REPARTITION_GAIN = 0.5
"""[1] Dependent coordinates change only for half the condition or less: a gain of one binary digit.
Any choice is valid, so the factor decides on cost and never on the result's order of error."""
DEAD_CENTRE_SHARE = 0.3
"""[1] By the largest component of the near-singular motion: coordinates that count as part of it.
It chooses what a message names, and enters no equation."""
PROXIMAL_REGULARISATION = 1e-14
"""[1] By the heaviest body: beside the smallest eigenvalue of G M^-1 G' near a dead centre it must
be small, or the proximal iteration does not converge; it only keeps dead rows from zero pivots."""
PROXIMAL_RESIDUAL = 1e-14
"""[m/s^2 or rad/s^2] Residual of closures where the proximal iteration stops: 45 eps, so round-off
of accelerations of the size of one; of larger ones the limit of iterations ends it."""
LIGHT_BODY_SHARE = 1e-7
"""[1] By the heaviest body: forces that balance but for round-off accelerate a lighter one, by more
than eps / 1e-7 = 2e-9 of its acceleration. Such accelerations are refined."""
TABLE_END_OVERRUN = 1e-9
"""[1] By the length of a table: a root of a gap at its end may lie, by round-off, beyond it. Far
above that round-off, far below what a table resolves."""
KNOT_ANGLE = 1e-9
"""[rad] A time computed from a knot of a drive may lie, by round-off, before it: 4e6 eps covers the
angle of a hundred thousand turns, and a thousandth of a degree is 2e4 times more."""
STILL_GAP_RATE = 1e-13
"""[1] By the fastest rate before an impact: rates after it that are round-off, 450 eps, as solving
for an impact loses two to three digits."""
RESTITUTION_SLACK = 1e-12
"""[1] By the fastest gap rate: how far the restitution law may be missed from below. Tenfold
``STILL_GAP_RATE``, since rates of several stops are subtracted in it."""
FAINT_GAP_RATE = 1e-6
"""[1] By the fastest gap rate: from ``STILL_GAP_RATE`` to here the condition of the impact matrix
tells how much of a rate is round-off; above, eps times a condition of 4e9 were needed to matter."""
IMPACT_RESIDUAL = 1e-13
"""[1] By the rates before an impact, left along its rows: 450 eps, as ``STILL_GAP_RATE``, or an
impact would leave rates that count as motion."""
MAX_IMPACT_RESIDUAL = 1e-9
"""[1] The same, beyond which an impact is refused: a rank-deficient system gives a finite wrong
velocity. Four digits above what refinement reaches, so that only a failure exceeds it."""

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

# Models: what a folder is checked for

COINCIDENT_M = 1e-9
"""[m] Below this distance two points are one, and the line between them has no direction: a
millionth of a millimetre, below any drawing and far above round-off of lengths of a metre."""
ASSEMBLY_TOLERANCE_M = 1e-9
"""[m] Largest gap of a closure in the touch configuration, as ``COINCIDENT_M``."""
TOUCH_TOLERANCE_M = 1e-6
"""[m] Largest gap or overlap of the bodies at coordinate zero: a thousandth of a millimetre."""
RANK_TOLERANCE = 1e-8
"""[1] Singular values below this are zero: half the digits of a double."""
URDF_TOLERANCE = 1e-9
"""[1] Of unit axes, rotations and the triangle inequality of inertias: nine written digits."""
TURN_ROUND_OFF = 1e-12
"""[1] By a turn: excess of the sum of a cam's sections that is round-off of its written angles."""
LEAST_TABLE_STEP = 1e-12
"""[unit of the table] Least distance of two of its rows."""

# Reduced engine: tables, flights and the rest of the turn

FINEST_TOLERANCE = 1e-13
"""[1] Least tolerance of the reduced engine that may be asked for. 450 eps: the defect of a panel
alone is known to 8 eps of the acceleration, and a choice leaves room above that."""
COARSEST_TOLERANCE = 1e-3
"""[1] Largest tolerance of the reduced engine that may be asked for. A choice: three digits."""
ARRIVAL_TABLES = 1e-10
"""[1] Least tolerance to which tables of the rest of a turn are made. A choice: a rest before the
touch removes most of their effect, so more digits would cost time and change no phase."""
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
COARSE_SWEEP = 1e-4
"""[1] Change of the acceleration, by that at the start, where the first guess of a flight's length
is good enough. A choice: it only places the end of a panel, with a margin of 1e-2."""
NEWTON_STEP = 1e-8
"""[1] Last step of Newton's method for a zero or a peak, by the time of the zero or the panel. What
is left is about its square, 1e-16, half of eps."""
ZERO_RESOLUTION = 64.0 * EPS
"""[1] A Newton step out of the bracket that is shorter ends the search, by the time of the zero. A
choice: the polynomial is a sum of up to 25 rounded terms, and its zero no better known."""
TRAVEL_END = 1e-12
"""[1] Part of the travel of the tables below which nothing is left to follow. A choice:
thousands of times the round-off of a place, 2.2e-16."""
DEFECT_EFFECT = 12.0
"""[1] A defect of the acceleration between n nodes acts on end and peak at most as a constant error
of this times it by n^2. Computed for the first missing polynomials with decays of 0.1 to 0.8: 7.9;
times 1.5 for other decays, and rounded up."""
LIMIT_ERROR_SAFETY = 16.0
"""[1] Factor on the difference of the last extrapolations of a series of bounces. Measured on
20,000 random cases: the error of the better one was larger by up to 10 in one of them."""
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
"""[1] Factor on what a series of bounces still lasts at constant deceleration. A choice: one that
is lower by a quarter, ``STEADY_DECELERATION``, lengthens it by a third only."""
STEADY_DECELERATION = 0.25
"""[1] Relative change of a deceleration up to which it may count as constant. A choice, which
``LATE_REST_SAFETY`` covers."""
FLIGHT_UNRESOLVED = 1e-3
"""[1] Error of the gap at the touch, by the gap, from which a flight over it is not resolved. A
choice: of a smaller error the effect on the collision is nearly proportional to it."""

# Studies: fits, designs and what is said of them

STUDY_TOLERANCE = 1e-12
"""[1] Tolerance of the runs of the published study and of sensitivities. The default of a case."""
SLOWEST_REBOUND = 1e-6
"""[rad/s] Rest rate of runs whose collisions are counted. A tenth of the lowest threshold of the
counts, 1e-5 rad/s, so that no count misses a collision."""
PRELOAD_STEP = 1e-3
"""[m or rad] Change of a preload from which the share of the spring in a lip force is found. A
choice: at a given motion forces are linear in the preload, so that no step truncates."""
DOUBTFUL = 1e-3
"""[1] Disagreement of two ways to a sensitivity, by the largest effect of the number, beyond which
it is not used. A choice: the second way has truncation, and sentences name two digits."""
SMALL_EFFECT = 0.1
"""[% per unit] Effects that are smaller are weighed as if they were this large. A choice: of
effects that nobody would use the relative disagreement says nothing."""
NO_EFFECT = 1e-6
"""[% per unit] Effects that are smaller count as none. A choice: 1e-5 of ``SMALL_EFFECT``."""
OVERLAP_M = 1e-6
"""[m] Links overlap when they are deeper in one another. The distances come from an iteration with
this tolerance, the default of the library Coal."""
CONTRADICTED = 1e-3
"""[1] Probability of so large a chi-square below which the data contradict a fit, and of so small a
one below which it is too good. A choice: of right fits one in a thousand falls on either side."""
OUTLYING = 0.01
"""[1] Probability, for the worst of all targets, below which it is an outlier. A choice: one set of
right targets in a hundred loses one."""
AT_BOUND = 1e-3
"""[1] Distance from a bound, by the range of the number, below which it is at that
bound. A choice: as ``FIT_STEP``, within which slopes are one-sided."""
FIT_STEP = 1e-3
"""[1] Step of differences of a fit, by the range of a number. Truncation is of the order of its
square, 1e-6, and the default tolerance of a fit, 1e-8, a factor of 1e5 below the step."""
FIT_DESCENT_STEP = 1e-4
"""[1] Step of the one-sided differences with which a fit goes down, by the range of a number. The
square root of the default tolerance, 1e-8: there truncation and error are equal."""
COARSEST_FIT = 1e-4
"""[1] Largest tolerance of a fit that may be asked for. A choice: differences over twice
``FIT_STEP`` then have one digit."""
COARSEST_DESIGN = 1e-6
"""[1] Largest tolerance of an optimisation that may be asked for. A choice: differences over twice
``DESIGN_STEP`` then have two or three digits."""
DESIGN_STEP = 5e-4
"""[1] Step of central differences of an optimisation, by the range of a number. Near the cube root
of the default tolerance, 1e-10, where truncation and error are equal."""
FEASIBLE = 1e-6
"""[1] Largest violation of a limit, by its scale, that counts as none. A choice: a thousand times
``DESCENT_END``, to which descents meet their limits."""
ACTIVE_LIMIT = 1e-4
"""[1] A limit with less slack, by its scale, or a bound that is nearer, by the range, is active. A
choice: a hundred times ``FEASIBLE``, since a descent ends with a little slack."""
DESCENT_END = 1e-9
"""[1] Gain of the aim, by its scale, that ends a descent. A choice: ten times the default tolerance
of the transitions, since a line search in noise has no end."""
DESCENT_GAIN = 1e-7
"""[1] Gain of a descent, by the scale of the aim, that is worth another one. A choice: a hundred
times ``DESCENT_END``."""
NO_CONFLICT = 1e-6
"""[1] Difference of the second aim, by its scale, between the best designs by either aim, up to
which there is no front. A choice: as ``FEASIBLE``."""
QUANTITY_ROUND_OFF = 1e-9
"""[1] Relative round-off of a quantity of the working cycle. A choice: positions at the largest
condition of the closures that is allowed lose 16 eps times 5e4, 2e-10."""
SHORT_STRETCH = 1e-6
"""[1] Stretches between events that are shorter, by the whole, are not searched for a peak. A
choice: in so short a time nothing moves far."""
CONTROL_ROUND_OFF = 1e-9
"""[1] Relative round-off of what the control of an optimum reads off a turn. A choice, for the
reason of ``QUANTITY_ROUND_OFF``; the control shares no number with the search."""
CONTROL_EDGE = 1e-6
"""[1] Part of a phase at either end that the control leaves out. A choice: there the stop is just
being hit or left, and the force belongs to either phase."""
DRIVE_RETURNS = 1e-6
"""[rad or m] Change of a driven coordinate over a turn above which its drive winds on. A choice: a
drive that winds on moves by far more, any other by round-off alone."""
