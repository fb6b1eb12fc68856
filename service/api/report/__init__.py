"""A sweep, or several as one, as a single HTML file."""
