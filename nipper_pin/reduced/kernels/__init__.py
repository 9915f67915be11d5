"""Compiled solution of the reduced model: panels, flights, transitions and their errors."""
