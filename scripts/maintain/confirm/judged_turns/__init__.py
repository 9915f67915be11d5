"""Turns of the reduced engine beside those of the direct one (judge_turns.py)."""
