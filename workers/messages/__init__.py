"""Messages: what the service, its pool and the workers say to each other."""
