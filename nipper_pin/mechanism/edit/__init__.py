"""Changing single values of a model by their paths, before anything is validated."""
