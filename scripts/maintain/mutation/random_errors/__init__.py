"""Random mutations of the package, and the tests that notice them."""
