"""Motion with changing contacts: events, phases and whole runs."""
