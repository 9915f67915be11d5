"""Which stops are closed after an event, and where a series of bounces ends."""
