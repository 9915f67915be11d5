"""The published study of the E62 nipper: done again, compared, and what it leaves open."""
