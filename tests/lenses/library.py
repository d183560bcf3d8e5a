"""LensFun's own library, which has no types."""

from __future__ import annotations

from importlib import import_module
from typing import Any

lensfunpy: Any = import_module("lensfunpy")
