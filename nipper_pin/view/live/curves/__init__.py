"""Curves of the live page, and the motion behind the rest that they need."""
