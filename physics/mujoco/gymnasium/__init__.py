"""Gymnasium's v5 tasks of MuJoCo's models: same rewards, ends, starts and observations."""
