"""Contact with friction as a linear complementarity problem, solved directly."""
