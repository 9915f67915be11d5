"""Tolerances of models and dynamics."""

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
