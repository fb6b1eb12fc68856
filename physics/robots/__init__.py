"""Robots: articulated bodies with contact as a complementarity problem."""
