"""Search for an optimum: samples of the box, descents, limits that bind, and the front."""
