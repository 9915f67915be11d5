"""Events on a panel of motion: gaps that close and contact forces that vanish."""
