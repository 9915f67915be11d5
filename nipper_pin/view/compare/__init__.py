"""Two runs side by side: on the terminal, as a figure, and in one film."""
