"""Networks: passes, derivatives, steps, and the units that they work in."""
