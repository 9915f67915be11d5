"""Tables of the functions of the reduced model, and what is known of their errors."""
