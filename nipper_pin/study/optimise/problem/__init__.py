"""Design problems: free numbers, aims, limits and quantities, from their files."""
