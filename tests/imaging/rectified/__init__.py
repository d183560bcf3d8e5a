"""Tests of `plumbline.imaging.rectified`."""
