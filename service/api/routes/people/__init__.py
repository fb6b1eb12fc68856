"""Routes to who may call: signing in and out, users, shares, sessions."""
