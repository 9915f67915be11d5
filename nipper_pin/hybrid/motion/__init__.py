"""Motion between two events, panel by panel: collocation, its solution and its resolution."""
