"""The audit: every Jacobian against differences."""
