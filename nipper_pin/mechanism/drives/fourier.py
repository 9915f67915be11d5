"""Fourier series in the cylinder angle."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ...arrays import FloatArray
from ...units import M_PER_MM
from ..files.law_tables import AnyTable
from ..laws import Evaluation


@dataclass(frozen=True, kw_only=True)
class Fourier:
    """A Fourier series in the cylinder angle.

    Attributes:
        mean: Mean value [rad or m].
        cosine: Coefficients of cos psi, cos 2 psi, ... [rad or m].
        sine: Coefficients of sin psi, sin 2 psi, ... [rad or m].
    """

    mean: float
    cosine: tuple[float, ...] = ()
    sine: tuple[float, ...] = ()
    knots_rad: ClassVar[tuple[float, ...]] = ()
    _orders: FloatArray = field(init=False, repr=False, compare=False)
    _weights: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Lay out the coefficients of the value and both derivatives as one matrix."""
        count = max(len(self.cosine), len(self.sine))
        c, s = np.zeros(count), np.zeros(count)
        c[: len(self.cosine)] = self.cosine
        s[: len(self.sine)] = self.sine
        n = np.arange(1.0, count + 1.0)
        weights = np.vstack(
            [np.hstack([c, s]), np.hstack([n * s, -n * c]), np.hstack([-n * n * c, -n * n * s])]
        )
        object.__setattr__(self, "_orders", n)
        object.__setattr__(self, "_weights", weights.T.copy())

    def evaluate(self, psi: FloatArray) -> Evaluation:
        """Evaluate the law; see ``DriveLaw.evaluate``."""
        angles = np.multiply.outer(psi, self._orders)
        sums = np.concatenate([np.cos(angles), np.sin(angles)], axis=-1) @ self._weights
        return sums[..., 0] + self.mean, sums[..., 1], sums[..., 2]


class FourierDrive(AnyTable, frozen=True, kw_only=True, tag="fourier"):
    """A Fourier series in the cylinder angle; coefficient n belongs to n turns per turn.

    Attributes:
        mean_rad: Mean value of a hinge [rad].
        cosine_rad: Coefficients of cos psi, cos 2 psi, ... of a hinge [rad].
        sine_rad: Coefficients of sin psi, sin 2 psi, ... of a hinge [rad].
        mean_mm: Mean value of a slide [mm].
        cosine_mm: Coefficients of cos psi, cos 2 psi, ... of a slide [mm].
        sine_mm: Coefficients of sin psi, sin 2 psi, ... of a slide [mm].
    """

    mean_rad: float = 0.0
    cosine_rad: tuple[float, ...] = ()
    sine_rad: tuple[float, ...] = ()
    mean_mm: float = 0.0
    cosine_mm: tuple[float, ...] = ()
    sine_mm: tuple[float, ...] = ()

    hinge_keys: ClassVar[tuple[str, ...]] = ("mean_rad", "cosine_rad", "sine_rad")
    slide_keys: ClassVar[tuple[str, ...]] = ("mean_mm", "cosine_mm", "sine_mm")

    def build(self) -> Fourier:
        """Return the law; see :meth:`DriveTable.build`. Keys of the other unit are empty."""
        return Fourier(
            mean=self.mean_rad + M_PER_MM * self.mean_mm,
            cosine=self.cosine_rad or tuple(M_PER_MM * value for value in self.cosine_mm),
            sine=self.sine_rad or tuple(M_PER_MM * value for value in self.sine_mm),
        )
