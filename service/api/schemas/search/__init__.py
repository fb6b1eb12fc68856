"""The forms of searches and of what they have found."""
