"""Gradient ascent of the actor through the simulator."""
