"""What stands beside the picture: sliders, fields, buttons, numbers, and their layout."""
