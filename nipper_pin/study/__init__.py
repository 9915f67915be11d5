"""Studies on top of single simulations."""
