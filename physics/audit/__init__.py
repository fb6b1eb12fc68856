"""The audit: compares every Jacobian with differences."""
