"""The same soft hand in Thenar, Rapier and MuJoCo, side by side."""
