"""What is checked of every solution of a campaign."""
