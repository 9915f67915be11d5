"""Identification problems: free numbers, targets and limits, from their files."""
