"""How a robot moves: substeps with contact, and their derivatives."""
