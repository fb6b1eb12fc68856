"""What runs measured, as answers and files show it."""
