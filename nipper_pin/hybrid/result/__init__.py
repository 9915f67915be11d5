"""What a simulation returns: events, motion, tables and energies."""
