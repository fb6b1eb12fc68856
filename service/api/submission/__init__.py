"""From a posted sweep to its runs: checked, counted, and only then expanded."""
