"""Tolerances of judges and peers, none of them shared with the engines that they judge."""

import sys

EPS = sys.float_info.epsilon
"""[1] Relative round-off is a multiple of this. Spacing of doubles above one, 2^-52."""

# Checks of the stress campaign

AGREED = 2.0
"""[1] Multiple of the sum of two stated errors by which two solutions may differ. A choice: true
errors of chains were measured to be up to 1.2 times the stated ones, at coarse tolerances."""
MIRRORED = 0.25
"""[1] The same for a machine and its mirror image. A choice: truncation is the same in both, so
that they differ by round-off alone."""
PARTED = 10.0
"""[1] Multiple of what is allowed, for the first events of two solutions that are not the same. A
choice: what comes after they part is less accurate than what came before."""
IMPULSE_ROUND_OFF = 1e-9
"""[1] Impulses that are smaller, by the largest in the same instant, are not compared. A choice: a
stop that is struck by round-off alone has an impulse far below."""
POWER = 1e-9
"""[1] Relative error of the power of springs and dampers, beside the round-off of their lengths. A
choice: six or seven digits above eps."""
BALANCED = 1e-8
"""[1] Part of its largest force that the equation of a coordinate may be off by. A choice: half the
digits of a double."""
UPRIGHT = 1.0 - 1e-9
"""[1] A frame whose y leaves the normal of the plane by a smaller cosine is turned in the plane. A
choice: 45 urad, above what six written digits of an angle are off, below any tilt that is meant."""
SAME_MODEL = 1e-10
"""[1] Relative difference of masses and weights by two ways. A choice: both are sums of rounded
places and angles, and keep ten digits of sixteen."""
CLOSURE_SUM = 4.0 * EPS
"""[rad or m] Round-off of a position that closures determine. Sums of some eight terms, each with
half a last digit of angles of about a radian and lengths below a metre."""
LEFT_OUT = 40.0
"""[1] Defect of the equations between nodes, by the tolerance times (2 order)^2. A choice: two
integrals divide the coefficient of degree k by (2 k)^2, and an interpolant leaves out several, more
at kinks of tables."""
POSITION_TERMS = 4.0
"""[1] Round-off of a position in eps of its terms. It is a sum of four: its start, the way at its
first rate, and two integrals."""
ROUNDINGS_PER_LINK = 4.0
"""[1] Roundings, of half an eps each, for a link of a chain. A choice, for turning into its axes,
shifting to its joint and adding."""
FINER_RUN = 16.0
"""[1] The tolerance of a case by that of its second run. A choice: halved four times."""
FINEST_RUN = 1e-14
"""[1] Least tolerance of the second run. The least that the direct engine takes."""
FALSE_ALARM = 1e-6
"""[1] Probability that chance alone explains the refusals of a family, below which they are too
many. A choice: of a million families as good as those measured one is blamed."""
DRIVE_SHAKEN = 1e-20
"""[1] Change of the rate of a held drive in an impact, by the largest change. A choice: the inertia
with which a drive is held, 2^100 or 1e30, leaves 1e-30 of it beside masses of about one."""
MOMENTUM = 1e-9
"""[1] Part of its largest term that the momentum balance of an impact may be off by. A choice:
seven digits are left of sixteen, and more where inertias differ less."""
MOST_MOMENTUM = 1e-4
"""[1] The same of mechanisms whose inertias differ widely, where 64 eps times their ratio is
allowed. A choice: beyond it the check would find nothing."""
IMPACT_LEFT = 1e-12
"""[1] Rates that an impact leaves of those that it takes away. Tenfold what the solution of an
impact is known to leave, 1e-13 of them."""
CLOSURE_RATE = 1e-10
"""[1] Rate of a closure, by the sum of its terms. A choice: ten digits of sixteen."""
RESTITUTION_LAW = 1e-11
"""[1] By the fastest approach: how far a stop may be off its restitution law. A choice, a tenth of
``CLOSURE_RATE``, which is a sum of more terms."""
ENERGY_LOST = 1e-9
"""[1] Relative error of the energy that an impact takes. A choice, as ``MOMENTUM``."""
PENETRATION = 1e-13
"""[rad or m] Depth of a stop beyond what tolerance and clock allow. It is 450 eps at lengths of
one."""
SLOPE_SHARE = 1e-5
"""[1] Difference of an acceleration and the slope of its velocity, by the largest of either, beside
ten roots of the tolerance. A choice: the slope of a polynomial of many nodes loses several
digits."""
PULL_SHARE = 1e-9
"""[1] By the largest force: pull of a closed stop, beside ten roots of the tolerance. A choice, far
above round-off."""
JUMP = 1e-11
"""[rad or m] Jump of coordinates between two segments, beyond what is moved meanwhile. A choice,
far above round-off at lengths of one."""
ENERGY_KEPT = 1e-8
"""[1] By all energies: what their balance may be off by, beside tolerance and round-off. A choice:
half the digits of a double."""
AMPLITUDE_SHARE = 1e-8
"""[1] Relative error of an amplitude beside the tolerance. A choice: the highest of the points that
are looked at is less than 1e-9 too low."""
TABLE_LEFT = 1e-8
"""[1] By the length of a table: how far it may be left. A choice: tenfold what the engine
allows."""

# Peers and tables

DIRECT_DEFAULT = 1e-12
"""[1] Tolerance at which the direct engine is graded. Its default."""
REDUCED_DEFAULT = 1e-10
"""[1] Tolerance at which the reduced engine is graded. Its default."""
HARD_CONSTRAINT = 1e-9
"""[1] Factor on MuJoCo's estimate of the inverse inertia that makes its constraints soft. A choice:
of an error of accelerations of 1e-4 it leaves 1e-13."""
LEAST_SHOWN_ERROR = 1e-16
"""[1] Smaller errors are drawn as this one. It is about half an eps: no double is known better."""

# The published study

SLOWEST_REBOUND = 1e-6
"""[rad/s] Rest rate of runs whose collisions are counted. A tenth of the lowest threshold of the
counts, 1e-5 rad/s, so that no count misses a collision."""
PRELOAD_STEP = 1e-3
"""[m or rad] Change of a preload from which the share of the spring in a lip force is found. A
choice: at a given motion forces are linear in the preload, so that no step truncates."""
