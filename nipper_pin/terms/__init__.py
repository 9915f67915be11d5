"""What people and files call each quantity and parameter: words, symbols, units, digits."""

from .names import named
from .parameters import NONE, parameter_shown, unit_of
from .shown import Shown, counted, digits, fixed, shown_in
from .table import SUBJECTS, TERMS, Term, term_of

__all__ = [
    "NONE",
    "SUBJECTS",
    "TERMS",
    "Shown",
    "Term",
    "counted",
    "digits",
    "fixed",
    "named",
    "parameter_shown",
    "shown_in",
    "term_of",
    "unit_of",
]
