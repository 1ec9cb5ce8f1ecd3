"""Independent twins in plain float64 NumPy of what kernels compute, written from the formulas and not from the code."""
