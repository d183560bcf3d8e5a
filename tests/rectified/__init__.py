"""Tests of `plumbline.rectified`."""
