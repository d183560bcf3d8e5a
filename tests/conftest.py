"""What every test shares: strict JAX types, and Hypothesis that tries the same cases every time."""

from __future__ import annotations

import jax
from hypothesis import settings

# JAX must not mix types silently. The compilation cache stays where the package puts it.
jax.config.update("jax_numpy_dtype_promotion", "strict")

settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.load_profile("repeatable")
