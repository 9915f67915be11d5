"""Tables, plots, films and pages of solutions and studies.

Each module imports only the library that it needs. ``nipper_pin.view(solution)`` shows a solution:
the package is callable, like the public function of its name.
"""

import sys
from types import ModuleType

from .show import view


class _Room(ModuleType):
    """A module that shows a solution when it is called."""

    __call__ = staticmethod(view)


# Where help and signatures look.
__wrapped__ = view
sys.modules[__name__].__class__ = _Room
