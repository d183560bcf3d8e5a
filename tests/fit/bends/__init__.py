"""Tests of generalised least squares on bent edges."""
