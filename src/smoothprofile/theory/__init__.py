"""One-dimensional reduced problems and closed forms; NumPy and SciPy only."""
