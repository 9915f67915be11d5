"""Following the motion from event to event."""
