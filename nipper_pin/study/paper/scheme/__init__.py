"""The published scheme: fixed steps on the hand-derived planar equation of the E62."""
