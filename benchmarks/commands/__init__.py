"""The commands ``run`` and ``stress``."""
