"""Parts of scripts/real_study.py: the comparison of simulated crops with real ones. tank_study.py uses some of them."""
