"""JAX's persistent compilation cache, kept in the user's cache folder.

A fit takes milliseconds, compiling its program seconds. `PLUMBLINE_CACHE_DIR` names another
folder. A cache that JAX is already configured with is left alone, and one that cannot be
written is done without.
"""

from __future__ import annotations

import os
from pathlib import Path

import jax
from platformdirs import user_cache_path


def cache_folder() -> Path:
    """Where compiled programs are kept."""
    chosen = os.environ.get("PLUMBLINE_CACHE_DIR")
    return Path(chosen) if chosen else user_cache_path("plumbline", appauthor=False)


def enable() -> None:
    """Let JAX keep compiled programs, unless it already does or they cannot be kept."""
    if jax.config.jax_compilation_cache_dir is not None:
        return
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    if not os.access(folder, os.W_OK | os.X_OK):
        return
    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.1)
