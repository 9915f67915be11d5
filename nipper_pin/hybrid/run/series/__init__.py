"""Series of collisions that end after a finite time: at rest, or in a jam."""
