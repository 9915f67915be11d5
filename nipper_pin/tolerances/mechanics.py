"""Tolerances of models and dynamics."""

import sys

EPS = sys.float_info.epsilon
"""[1] Relative round-off is a multiple of this. Spacing of doubles above one, 2^-52."""

# Closures, constraint forces and impacts

CLOSURE_RESIDUAL = 16.0 * EPS
"""[1] By the reach of the mechanism: gap of a closure at which its iteration ends. A sum of ten
rounded lengths of that size is no better."""
TRACKING_RESIDUAL = 1e-6
"""[1] By the reach of the mechanism: gap of a closure on the way to where an assembly ends. A
choice: steps on the way are far longer, and only the end is closed to round-off."""
MAX_CONDITION = 5e4
"""[1] Condition of the dependent closure columns from which a position is singular. Positions are
known to 16 eps times it, 2e-10, rates to 1e-5; accelerations lose it once more, and a little beyond
round-off decides on them."""
GOOD_CONDITION = 25.0
"""[1] By the number of closure rows: condition up to which no better choice of dependent
coordinates is looked for. A choice: it multiplies what is left unresolved of the independent
ones."""
REPARTITION_GAIN = 0.5
"""[1] Part of the condition that another choice of dependent coordinates must come below. A choice:
a gain of one binary digit; any choice is valid, so it decides on cost alone."""
DEAD_CENTRE_SHARE = 0.3
"""[1] By the largest component of a near-singular motion: coordinates that a message names. A
choice, which enters no equation."""
PROXIMAL_REGULARISATION = 1e-14
"""[1] By one over the heaviest mass: regularisation of the proximal iteration. A choice: it keeps
dead rows from zero pivots, and is small beside the smallest eigenvalue of G M^-1 G'."""
PROXIMAL_RESIDUAL = 1e-14
"""[m/s^2] Residual of closures, of a machine of a metre, where the proximal iteration stops. It is
45 eps, so round-off of accelerations of about one; with larger ones ``PROXIMAL_CHANGE`` ends it."""
PROXIMAL_CHANGE = 1e-12
"""[1] By the multipliers: change by a proximal iteration that ends it, too. Each iteration divides
what is missing by the same factor: where G M^-1 G' is above 1e-12, 3e-15 is left."""
LIGHT_BODY_SHARE = 1e-7
"""[1] By the heaviest body: accelerations of mechanisms with a lighter one are refined. Forces that
balance but for round-off accelerate it by eps / 1e-7 = 2e-9 of its acceleration or more."""
TABLE_END_OVERRUN = 1e-9
"""[1] By the length of a table: overrun of its end that counts as none. A choice, far above the
round-off of a root of a gap that lies at the end, and far below what a table resolves."""
HEAT_ROUND_OFF = 1e-12
"""[1] By the largest power of its force on a panel: heat of a law below zero that counts as none. A
choice: 4500 eps, for laws that find it as a difference."""
KNOT_ANGLE = 1e-9
"""[rad] Distance to a knot of a drive below which the next one is taken. It is 4e6 eps, round-off
of a hundred thousand turns, and 2e4 times less than a thousandth of a degree."""
STILL_GAP_RATE = 1e-13
"""[1] By the fastest rate before an impact: rates after it that count as zero. It is 450 eps, as
the solution of an impact loses two to three digits."""
RESTITUTION_SLACK = 1e-12
"""[1] By the fastest gap rate: how far the restitution law may be missed from below. Tenfold
``STILL_GAP_RATE``, since rates of several stops are subtracted in it."""
FAINT_GAP_RATE = 1e-6
"""[1] By the fastest gap rate: from ``STILL_GAP_RATE`` to here the round-off of a rate is computed.
Only a condition of the impact matrix of 4e9 would bring eps to more."""
IMPACT_RESIDUAL = 1e-13
"""[1] By the rates before an impact: residual of its equations at which refinement ends. Equal to
``STILL_GAP_RATE``, or an impact would leave rates that count as motion."""
MAX_IMPACT_RESIDUAL = 1e-9
"""[1] The same, beyond which an impact is refused. A choice: four digits above ``IMPACT_RESIDUAL``,
so that only a failure exceeds it, such as a rank-deficient system."""
EQUAL_APPROACH = 1e-4
"""[1] By the fastest approach: contacts that are as fast and struck at the same time. A choice:
five digits of a symmetric machine differ by less."""
DEPENDENT_PIVOT = 1e-12
"""[1] By the response of a stop alone: what other stops leave of it, below which it depends on
them. A choice: it is 4500 eps, and masses that differ by 1e8 leave 1e-8."""
EQUAL_RATIO = 16.0 * EPS
"""[1] By the largest rate: ratios of a pivoting step that are equal. A choice: a few roundings of
rows of the same size."""

# Models: what a folder is checked for

COINCIDENT_M = 1e-9
"""[m] Distance below which two points are one, of a machine of a metre. A choice: a millionth of a
millimetre is below any drawing and far above the round-off of a metre."""
ASSEMBLY_TOLERANCE_M = 1e-9
"""[m] Largest gap of a closure in the touch configuration, of a machine from a millimetre to a
metre. A choice, as ``COINCIDENT_M``."""
ROUNDED_SHARE = 1e-4
"""[1] By the reach: gap of a closure that is closed as left by rounded numbers. A choice: programs
write angles to 5e-5 rad and better."""
TOUCH_TOLERANCE_M = 1e-6
"""[m] Largest gap or overlap of touching bodies in the touch configuration, of a machine from a
millimetre to a metre. A choice: a thousandth of a millimetre."""
RANK_TOLERANCE = 1e-8
"""[1] Singular values of rows of length one below which their rank is less. A choice: half the
digits of a double."""
URDF_TOLERANCE = 1e-9
"""[1] Error of the triangle inequality of inertias, and of their signs. A choice: files are written
with nine digits and more."""
IN_PLANE_RAD = 2e-3
"""[rad] Largest angle by which the axis of a joint may miss the plane of the others, and frames the
axes of the file. Files say 3.14 for half a turn, 0.0016 rad less."""
TURN_ROUND_OFF = 1e-12
"""[1] By a turn: excess of the sum of a cam's sections that counts as none. A choice, far above the
round-off of angles that are written in degrees, 1e-15."""
LEAST_TABLE_STEP = 1e-12
"""[unit of the table] Least distance of two of its rows. A choice: at smaller ones slopes are
round-off."""
CURVE_DEPARTURE = 0.05
"""[1] By a table's range: a curve farther from its chords is told of. A choice."""
ACROSS_PLANE = 1e-12
"""[1] Distance of a cosine from one up to which the axis of a cylinder is across the plane. A
choice, far above round-off; the angle is at most 1.4e-6 rad."""
PARALLEL_FACES = 1e-4
"""[rad] Angle up to which faces of lips may be parallel. A choice: 20 mm then open by 2 um."""
DISTANCE_ACCURACY_M = 1e-12
"""[m] Accuracy asked of distances between lips, of a machine of a metre. A choice: a millionth of
``TOUCH_TOLERANCE_M``."""
TOUCH_STEP = 1e-13
"""[1] By the unit of the coordinate: last step of the search for where bodies touch. A choice:
450 eps."""
DRIVE_REPEATS = 1e-9
"""[rad or m] Largest error of the turn that a drive table spans, largest difference of places of a
drive law of such a travel a turn apart, and least motion of one that moves, by its largest place. A
choice, far above the round-off of written numbers."""
DEPENDENT_SHARE = 1e-6
"""[1] Part in a dependence of unit rows from which a row is named in a message. A choice, which
enters no equation."""
