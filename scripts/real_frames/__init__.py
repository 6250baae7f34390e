"""Parts of scripts/tank_study.py: networks that are trained on simulated frames and tested on real ones."""
