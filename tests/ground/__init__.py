"""Tests of `plumbline.ground`."""
