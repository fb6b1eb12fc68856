"""Experience: what runs live through, keep and are measured by."""
