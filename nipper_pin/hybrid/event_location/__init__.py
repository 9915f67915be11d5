"""Where a panel of motion ends: gaps that close and contact forces that vanish."""
