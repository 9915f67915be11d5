"""Tolerances of studies: fits, designs and what is said of them."""

STUDY_TOLERANCE = 1e-12
"""[1] Tolerance of the runs of levers. The default of a case."""
NO_EFFECT = 1e-6
"""[1] Relative changes of a rebound that are smaller count as none. A choice: a million times the
accuracy of a run, and below what anybody would use."""
OVERLAP_M = 1e-6
"""[m] Links overlap when they are deeper in one another. The distances come from an iteration with
this tolerance, the default of the library Coal."""
CONTRADICTED = 1e-3
"""[1] Probability of so large a chi-square below which the data contradict a fit, and of so small a
one below which it is too good. A choice: of right fits one in a thousand falls on each side."""
OUTLYING = 0.01
"""[1] Probability, for the worst of all targets, below which it is an outlier. A choice: one set of
right targets in a hundred loses one."""
AT_BOUND = 1e-3
"""[1] Distance from a bound, by the range of the number, below which it is at that bound. A choice:
as ``FIT_STEP``, within which slopes are one-sided."""
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
"""[1] Part of a stretch between events, or of a turn, that is left out of account. A choice: in so
short a time nothing moves far."""
CONTROL_ROUND_OFF = 1e-9
"""[1] Relative round-off of what the control of an optimum reads off a turn. A choice, for the
reason of ``QUANTITY_ROUND_OFF``."""
FIT_START = 1e-6
"""[1] Least distance of a start from a bound, by the range of the number. A choice: the method
moves inside its bounds, and cannot start on one."""
FIT_END = 1e-8
"""[1] Relative gain of the cost that ends a fit. A choice, equal to the default tolerance of a
fit."""
PROFILE_END = 1e-7
"""[1] Relative gain of the cost that ends a fit of the other numbers in a profile. A choice, ten
times ``FIT_END``: profiles need fewer digits."""
FIT_LAST_STEP = 1e-6
"""[1] Step, or scaled gradient, that ends a fit, by the ranges. A choice: a thousandth of
``FIT_STEP``."""
LEAST_FREE_SHARE = 1e-6
"""[1] Least part of a target that is taken as not fitted away. A choice: it keeps the residual of a
target that alone determines a number from division by zero."""
CYCLE_ROOT = 1e-14
"""[rad or m, and 1 by the time] Value of a coordinate, or length of its bracket, at which a root of
the working cycle is found. A choice: it is 45 eps at lengths of one."""
NO_SPREAD = 1e-6
"""[1] By the largest value: spread of a quantity over samples below which its size is its scale. A
choice: a quantity that hardly changes would have a scale of round-off."""
LEAST_SCALE = 1e-12
"""[unit of the quantity] Least scale of a quantity that does not change. A choice: it keeps a
quantity that is zero from division by zero."""
COARSEST_TURN = 1e-4
"""[1] Largest tolerance of the second run of a turn whose difference from the first states an
error. A choice: coarser turns may take another order of collisions."""
SAME_DIMENSION = 1e-9
"""[mm, deg, kg or kg m2; relative above 1] Difference of a dimension or a mass of two models that
is round-off. A choice: a point that is moved turns others by eps times lengths of 1e3 mm."""
