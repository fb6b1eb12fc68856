"""Actor-critic learners with a replay: DDPG, SAC and their hybrids."""
