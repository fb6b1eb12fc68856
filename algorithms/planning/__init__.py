"""Planning: iLQR in a receding horizon."""
