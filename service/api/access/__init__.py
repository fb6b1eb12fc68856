"""Who may call, and what: tokens, sign-in, scopes, and the guard in front of everything."""
