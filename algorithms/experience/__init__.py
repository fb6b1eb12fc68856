"""Experience: the steps of runs, the replay of transitions, and evaluation."""
