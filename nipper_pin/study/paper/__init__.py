"""The published study of the E62 nipper: done again, compared, and what it leaves open."""

from .study import PaperStudy, paper_study

__all__ = ["PaperStudy", "paper_study"]
