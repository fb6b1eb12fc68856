"""What the API says no with, as problems (RFC 9457) and sentences."""
