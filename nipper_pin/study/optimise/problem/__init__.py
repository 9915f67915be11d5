"""What is to be optimised: free numbers, aims, limits and quantities, from their files."""
