"""The fit: the only floor that knows JAX's solver."""
