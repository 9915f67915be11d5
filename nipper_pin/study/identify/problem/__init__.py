"""What is to be identified: free numbers, targets and limits, from their files."""
