"""Libraries that only some commands need: the extra of each, and the error where one is missing."""

from __future__ import annotations

from importlib.util import find_spec

from .errors import InputError

_SWEEPS = ("numba", "pyarrow")
EXTRAS = {
    "view": ("meshcat", "umsgpack", "matplotlib", "PIL"),
    "live": ("meshcat", "umsgpack", "tornado"),
    "study": ("matplotlib", *_SWEEPS),
    "sweep": _SWEEPS,
    "cluster": (*_SWEEPS, "distributed"),
    "completion": ("shtab",),
    "peers": ("numba", "mujoco"),
}
"""Modules that come with each extra of the package."""

PACKAGES = {
    "PIL": "pillow",
    "umsgpack": "u-msgpack-python",
}
"""Name at the package index of each module that has another one there."""


def installed(module: str) -> bool:
    """Whether a module can be imported.

    Args:
        module: Name of a top-level module.
    """
    try:
        return find_spec(module) is not None
    except ImportError:
        return False


def require(extra: str, *modules: str, what: str) -> None:
    """Refuse to go on without the modules of an extra, and say how to get them.

    Args:
        extra: The extra, a key of :data:`EXTRAS`.
        *modules: The modules that are needed; without any, all of the extra.
        what: What needs them, the beginning of the sentence.

    Raises:
        InputError: One of them is not installed. Evidence: ``extra``, ``packages``.
    """
    missing = [PACKAGES.get(name, name) for name in modules or EXTRAS[extra] if not installed(name)]
    if not missing:
        return
    *others, last = missing
    named = f"{', '.join(others)} and {last}, which are" if others else f"{last}, which is"
    message = f'{what} needs {named} not installed: pip install "nipper-pin[{extra}]"'
    raise InputError(message, extra=extra, packages=tuple(missing))
