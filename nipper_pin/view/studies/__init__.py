"""Reports and plots of studies."""
