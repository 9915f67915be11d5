"""A planar solver for impact mechanisms in absolute coordinates, which judges the package.

It reads the model folder itself, the links as the campaign's judge does, and shares no line with
what it judges: every link has x, z and an angle of its own, every joint is a constraint, motion is
integrated by Gauss collocation, and accelerations, forces and impulses come from one bordered
matrix.
"""
