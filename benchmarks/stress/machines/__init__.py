"""Random machines of a stress campaign, written out as models."""
