"""The commands ``benchmark`` and ``stress``."""
