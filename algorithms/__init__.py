"""The learners, pure of Ray, SQL and HTTP."""
