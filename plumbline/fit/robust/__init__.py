"""Fits that leave wrong picks out, and what is wrong with those."""
