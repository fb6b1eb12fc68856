"""The search that chooses the presets: its spaces, its table, and what it found."""
