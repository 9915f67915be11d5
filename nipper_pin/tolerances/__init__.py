"""Tolerances and safety factors, a module for each room, each with its unit and its derivation.

The text of each begins with its unit in brackets, [1] for a ratio; it says what the number decides,
and how it was derived, what was measured, or that it is a choice. What a user sets is in
:class:`nipper_pin.Case`; counts, and orders of polynomials, stand where they are used.
"""
