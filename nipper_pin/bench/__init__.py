"""What measures the package: run time, accuracy, stress campaigns, other simulators."""
