"""The compiled fit: all that knows JAX."""
