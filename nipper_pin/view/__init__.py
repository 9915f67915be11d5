"""What people look at: tables and plots. Import the module you need; each brings its library.

``nipper_pin.view(solution)`` shows a solution: the room carries the name of what it is for, so it
can be called.
"""

import sys
from types import ModuleType

from .show import view


class _Room(ModuleType):
    """A module that shows what it is called with."""

    __call__ = staticmethod(view)


# Where help and signatures look.
__wrapped__ = view
sys.modules[__name__].__class__ = _Room
