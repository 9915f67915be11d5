"""Kinematics, constrained dynamics, impacts and forces of a mechanism, on Pinocchio."""
