"""Studies built on solving and simulating: comparisons with printed values, sweeps, tuning."""
